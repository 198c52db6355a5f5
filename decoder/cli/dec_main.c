/* nsdf-dec: decodes .nsdf files to triangle meshes. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli_input.h"
#include "cli_util.h"
#include "dec_bench.h"
#include "dec_info.h"
#include "dec_options.h"
#include "dec_output.h"
#include "cli_times.h"

static int print_error(const dec_options *options, const nsdf_error *error) {
    if (error->status == NSDF_LIMIT && error->message[0])
        nsdf_cli_error("%s: %s; see --max-memory", options->input, error->message);
    else
        nsdf_cli_nsdf_error(options->input, error);
    return NSDF_CLI_FAILURE;
}

/* What is decoded, and how. */
typedef struct job {
    const dec_options *options;
    nsdf_cli_input *input;
    nsdf_decoder *decoder;
} job;

/* A call on the handle failed; the details are kept there. */
static int report(const job *j, nsdf_status status) {
    nsdf_error error;
    if (status == NSDF_CANCELLED || (status == NSDF_IO && nsdf_cli_interrupts() > 0)) {
        nsdf_cli_error("interrupted");
        return NSDF_CLI_FAILURE;
    }
    nsdf_cli_get_error(j->decoder, status, &error);
    nsdf_cli_input_explain(j->input, &error);
    return print_error(j->options, &error);
}

/* Checking all of a file would transfer all of it. */
static void set_decoder_options(const job *j, nsdf_decoder_options *out) {
    const dec_options *options = j->options;
    nsdf_decoder_options_init(out);
    out->threads = options->threads;
    out->cpu_mask = options->cpu_mask;
    out->check_all = !nsdf_cli_input_is_remote(j->input);
    if (options->max_memory)
        out->max_memory = options->max_memory;
    if (options->resolution > out->max_resolution)
        out->max_resolution = options->resolution;
}

static void set_mesh_options(const dec_options *options, nsdf_mesh_options *out) {
    nsdf_mesh_options_init(out);
    out->resolution = options->resolution;
    out->normals = options->normals != 0;
    out->projection = options->projection;
    out->dense = options->dense != 0;
    out->all_pieces = options->all_pieces != 0;
    out->cancel = nsdf_cli_is_interrupted;
}

/* ---- Extraction -------------------------------------------------------------------------------------------- */

typedef struct tally {
    double started, triangles, first_empty;
    uint32_t frames, empty;
} tally;

static int extract_frame(const job *j, dec_output *output, double seconds, nsdf_mesh **mesh, tally *t) {
    nsdf_mesh_options mesh_options;
    nsdf_mesh_view view;
    set_mesh_options(j->options, &mesh_options);
    nsdf_status status = nsdf_extract_mesh(j->decoder, seconds, &mesh_options, mesh);
    if (status == NSDF_OK)
        status = nsdf_mesh_get_view(*mesh, &view);
    if (status == NSDF_OK && nsdf_cli_interrupts() > 0)
        status = NSDF_CANCELLED;
    if (status != NSDF_OK)
        return report(j, status);
    if (view.vertex_count == 0 && t->empty++ == 0)
        t->first_empty = seconds;
    t->triangles += view.triangle_count;
    nsdf_cli_verbose("%.9g s: %lu vertices, %lu triangles", seconds, (unsigned long)view.vertex_count,
                     (unsigned long)view.triangle_count);
    return dec_output_write(output, t->frames++, seconds, &view);
}

static void summarise(const job *j, const dec_output *output, const tally *t) {
    const dec_options *options = j->options;
    nsdf_info info;
    const double elapsed = nsdf_cli_clock() - t->started;
    if (t->empty > 0)
        nsdf_cli_warn("%lu of %lu frames have no surface, the first at %.9g s", (unsigned long)t->empty,
                      (unsigned long)t->frames, t->first_empty);
    if (nsdf_get_info(j->decoder, &info) != NSDF_OK)
        return;
    char *first = NULL, *last = NULL;
    if (output->kind == DEC_OUTPUT_FILES) {
        first = dec_output_name(output, 0);
        last = dec_output_name(output, t->frames - 1);
    } else if (output->kind == DEC_OUTPUT_FILM && strcmp(options->output, "-") != 0) {
        first = dec_output_name(output, 0);
    }
    nsdf_cli_say("%lu frame%s, resolution %lu, %.0f triangles on average, %.3g ms a frame%s%s%s%s",
                 (unsigned long)t->frames, t->frames == 1 ? "" : "s",
                 (unsigned long)(options->resolution ? options->resolution : info.default_resolution),
                 t->triangles / t->frames, 1e3 * elapsed / t->frames, first ? " -> " : "", first ? first : "",
                 last && t->frames > 1 ? " ... " : "", last && t->frames > 1 ? last : "");
    free(first);
    free(last);
}

/* Seconds from one frame to the next: one of --fps, or of those that were encoded. */
static double film_interval(const job *j) {
    const nsdf_cli_choice *choice = &j->options->choice;
    nsdf_info info;
    if (choice->rate_num)
        return (double)choice->rate_den / choice->rate_num;
    return nsdf_get_info(j->decoder, &info) == NSDF_OK ? (double)info.rate_den / info.rate_num : 0.0;
}

static int extract_all(const job *j, dec_output *output, const nsdf_cli_times *times) {
    nsdf_mesh *mesh = NULL;
    tally t = {.started = nsdf_cli_clock()};
    int result = dec_output_check_count(output, times->count);
    for (uint32_t i = 0; i < times->count && result == NSDF_CLI_SUCCESS; i++) {
        nsdf_cli_progress("frame %lu of %lu", (unsigned long)i + 1, (unsigned long)times->count);
        result = extract_frame(j, output, times->seconds[i], &mesh, &t);
    }
    nsdf_mesh_free(&mesh);
    if (result == NSDF_CLI_SUCCESS)
        result = dec_output_finish(output, film_interval(j));
    if (result == NSDF_CLI_SUCCESS && nsdf_cli_commit() != 0)
        result = NSDF_CLI_FAILURE;
    if (result == NSDF_CLI_SUCCESS)
        summarise(j, output, &t);
    return result;
}

/* ---- Other actions ----------------------------------------------------------------------------------------- */

static int verify(const job *j) {
    nsdf_info info;
    nsdf_status status = nsdf_verify(j->decoder);
    if (status == NSDF_OK)
        status = nsdf_get_info(j->decoder, &info);
    if (status != NSDF_OK)
        return report(j, status);
    printf("%s: ok (%lu frames, %lu segments, %llu parameters, hash %016llx)\n", j->options->input,
           (unsigned long)info.frame_count, (unsigned long)info.segment_count, (unsigned long long)info.parameter_count,
           (unsigned long long)info.parameter_hash);
    return NSDF_CLI_SUCCESS;
}

static int bench(const job *j, const nsdf_cli_times *times) {
    nsdf_decoder_options open_options;
    nsdf_mesh_options mesh_options;
    set_decoder_options(j, &open_options);
    set_mesh_options(j->options, &mesh_options);
    const nsdf_status status = dec_bench_run(j->decoder, j->input, j->options, &open_options, &mesh_options, times);
    return status == NSDF_OK ? NSDF_CLI_SUCCESS : report(j, status);
}

static int decode_times(const job *j, dec_output *output) {
    nsdf_cli_times times;
    int result = nsdf_cli_times_choose(&j->options->choice, j->decoder, &times);
    if (result == NSDF_CLI_SUCCESS)
        result = j->options->action == DEC_BENCH ? bench(j, &times) : extract_all(j, output, &times);
    nsdf_cli_times_free(&times);
    return result;
}

static int info(const job *j) {
    const int load = !nsdf_cli_input_is_remote(j->input);
    const char *name = j->options->input;
    const nsdf_status status =
        j->options->json ? dec_info_print_json(j->decoder, name, load) : dec_info_print(j->decoder, name, load);
    return status == NSDF_OK ? NSDF_CLI_SUCCESS : report(j, status);
}

static int act(job *j, dec_output *output) {
    nsdf_decoder_options decoder_options;
    nsdf_error error;
    set_decoder_options(j, &decoder_options);
    if (nsdf_cli_input_decoder(j->input, &j->decoder, &decoder_options, &error) != NSDF_OK)
        return print_error(j->options, &error);
    nsdf_cli_verbose("%s kernels", nsdf_kernel_name(j->decoder));
    const dec_action action = j->options->action;
    const int result = action == DEC_INFO ? info(j) : action == DEC_VERIFY ? verify(j) : decode_times(j, output);
    nsdf_cli_input_report(j->input, action == DEC_BENCH ? 0 : 1);
    nsdf_close(&j->decoder);
    return result;
}

static int run(const dec_options *options) {
    job j = {.options = options};
    nsdf_error error;
    dec_output output = {.film = NULL};
    if (options->action == DEC_NOTHING)
        return NSDF_CLI_SUCCESS;
    if (options->action == DEC_EXTRACT) {
        const int result = dec_output_prepare(options, &output);
        if (result != NSDF_CLI_SUCCESS)
            return result;
        nsdf_cli_catch_signals();
    }
    j.input = nsdf_cli_input_open(options->input, options->timeout, &error);
    const int result = j.input ? act(&j, &output) : print_error(options, &error);
    nsdf_cli_input_close(j.input);
    dec_output_free(&output);
    return result;
}

int main(int argc, char **argv) {
    dec_options options;
    nsdf_cli_begin("nsdf-dec");
    int result = dec_options_parse(argc, argv, &options);
    if (result == NSDF_CLI_SUCCESS)
        result = run(&options);
    nsdf_cli_abort();
    if (fflush(stdout) != 0 && result == NSDF_CLI_SUCCESS) {
        nsdf_cli_error("cannot write standard output: %s", strerror(errno));
        result = NSDF_CLI_FAILURE;
    }
    return result;
}
