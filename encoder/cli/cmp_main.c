/* nsdf-cmp: how far a decoded moving surface is from the input. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli_util.h"
#include "cmp_frames.h"
#include "cmp_heatmap.h"
#include "cmp_options.h"
#include "cmp_output.h"

/* Colours end there unless --heatmap-max says otherwise; fraction of the diagonal. */
static const double default_heatmap_top = 5e-3;

typedef struct session {
    const cmp_options *options;
    cmp_frames frames;
    nsdf_cli_pattern heatmap;
    nsdf_cli_file output;
    nsdf_compare *compare;
    nsdf_difference *differences; /* [chosen count] */
    double *vertex_distance;      /* of the decoded mesh at hand, for the heat map */
    double diagonal, peak;        /* world units */
} session;

static int out_of_memory(void) {
    nsdf_cli_error("out of memory");
    return NSDF_CLI_FAILURE;
}

/* Box of the frames seen so far. */
static void measure_box(session *s) {
    double square = 0.0, longest = 0.0;
    for (int k = 0; k < 3; k++) {
        const double side = s->frames.box_max[k] - s->frames.box_min[k];
        square += side * side;
        longest = fmax(longest, side);
    }
    s->diagonal = sqrt(square);
    s->peak = s->options->peak > 0.0 ? s->options->peak : longest;
}

/* ---- Frames --------------------------------------------------------------------------------------------- */

/* "reference: ..." and "decoded: ..." become the names of the files. */
static void report(const session *s, uint32_t i, const nsdf_encoder_error *error) {
    char name[512];
    const char *colon = strstr(error->message, ": ");
    if (strncmp(error->message, "reference", 9) == 0)
        nsdf_sequence_name_frame(s->frames.reference, s->frames.chosen.numbers[i], name, sizeof name);
    else
        cmp_frames_name_decoded(&s->frames, s->options, i, name, sizeof name);
    nsdf_cli_error("%s: %s", name, colon ? colon + 2 : error->message);
}

static int write_heatmap(session *s, uint32_t i, const nsdf_input_mesh *decoded) {
    const cmp_options *o = s->options;
    const double unit = o->world ? 1.0 : s->diagonal;
    const double top = o->heatmap_max > 0.0 ? o->heatmap_max * unit : default_heatmap_top * s->diagonal;
    return cmp_heatmap_write(&s->heatmap, s->frames.chosen.numbers[i], decoded, s->vertex_distance, top);
}

static int compare_frame(session *s, uint32_t i) {
    nsdf_input_mesh reference, decoded;
    nsdf_encoder_error error;
    int result = cmp_frames_load(&s->frames, s->options, i, &reference, &decoded);
    if (result != NSDF_CLI_SUCCESS)
        return result;
    free(s->vertex_distance);
    s->vertex_distance = s->options->heatmap ? calloc((size_t)decoded.vertex_count + 1, sizeof(double)) : NULL;
    if (s->options->heatmap && !s->vertex_distance)
        return out_of_memory();
    if (nsdf_compare_frame(s->compare, &reference, &decoded, s->vertex_distance, &s->differences[i], &error) !=
        NSDF_OK) {
        report(s, i, &error);
        return NSDF_CLI_FAILURE;
    }
    return s->options->heatmap ? write_heatmap(s, i, &decoded) : NSDF_CLI_SUCCESS;
}

static void tell_frame(const session *s, uint32_t i) {
    char name[512], reference[512];
    const nsdf_difference *d = &s->differences[i];
    cmp_frames_name_decoded(&s->frames, s->options, i, name, sizeof name);
    nsdf_sequence_name_frame(s->frames.reference, s->frames.chosen.numbers[i], reference, sizeof reference);
    nsdf_cli_verbose("%s, %s: mean %.3g and %.3g, Hausdorff %.3g, world units", reference, name, d->to_decoded.mean,
                     d->to_reference.mean, d->hausdorff);
}

static int compare_all(session *s) {
    const uint32_t count = s->frames.chosen.count;
    const double began = nsdf_cli_clock();
    int result = NSDF_CLI_SUCCESS;
    for (uint32_t i = 0; i < count && result == NSDF_CLI_SUCCESS; i++) {
        const double spent = nsdf_cli_clock() - began;
        if (i == 0)
            nsdf_cli_progress("frame 1 of %lu", (unsigned long)count);
        else
            nsdf_cli_progress("frame %lu of %lu  %.0f s left", (unsigned long)i + 1, (unsigned long)count,
                              spent / i * (count - i));
        result = compare_frame(s, i);
        if (result == NSDF_CLI_SUCCESS)
            tell_frame(s, i);
        if (result == NSDF_CLI_SUCCESS && nsdf_cli_interrupts() > 0) {
            nsdf_cli_error("interrupted: nothing was written");
            result = NSDF_CLI_FAILURE;
        }
    }
    return result;
}

/* ---- Result --------------------------------------------------------------------------------------------- */

static int write_result(session *s) {
    cmp_result r = {.options = s->options,
                    .frames = s->frames.chosen.numbers,
                    .differences = s->differences,
                    .count = s->frames.chosen.count,
                    .diagonal = s->diagonal,
                    .peak = s->peak};
    if (nsdf_compare_summarise(r.differences, r.count, r.peak, &r.summary) != NSDF_OK)
        return NSDF_CLI_FAILURE; /* cannot happen: frames with triangles have a box */
    cmp_output_write(&r, &s->output);
    return nsdf_cli_file_close(&s->output) == 0 && nsdf_cli_commit() == 0 ? NSDF_CLI_SUCCESS : NSDF_CLI_FAILURE;
}

/* Colours in fractions of the diagonal need the whole box first; otherwise each frame is read once. */
static int run(session *s) {
    const cmp_options *o = s->options;
    int result = cmp_frames_open(&s->frames, o);
    if (result == NSDF_CLI_SUCCESS && o->heatmap)
        result = cmp_heatmap_prepare(o->heatmap, s->frames.chosen.count, &s->heatmap);
    if (result != NSDF_CLI_SUCCESS)
        return result;
    /* Before anything that takes time, so that a name that cannot be written is told at once. */
    if (nsdf_cli_file_open(&s->output, o->output ? o->output : "-") != 0)
        return NSDF_CLI_FAILURE;
    s->differences = calloc(s->frames.chosen.count, sizeof *s->differences);
    if (!s->differences)
        return out_of_memory();
    if (o->heatmap) {
        result = cmp_frames_read_box(&s->frames);
        measure_box(s);
    }
    if (result == NSDF_CLI_SUCCESS)
        result = compare_all(s);
    if (result == NSDF_CLI_SUCCESS && !o->heatmap)
        result = cmp_frames_finish_box(&s->frames);
    measure_box(s);
    return result == NSDF_CLI_SUCCESS ? write_result(s) : result;
}

int main(int argc, char **argv) {
    cmp_options options;
    nsdf_encoder_error error;
    session s = {.options = &options, .output.descriptor = -1};
    nsdf_cli_begin("nsdf-cmp");
    const int code = cmp_options_parse(&options, argc, argv);
    if (code >= 0)
        return code;
    nsdf_cli_set_verbosity(options.quiet ? -1 : options.verbose);
    if (nsdf_compare_create(&s.compare, &options.compare, &error) != NSDF_OK)
        return nsdf_cli_usage_error("%s", error.message);
    nsdf_cli_catch_signals();
    const int result = run(&s);
    nsdf_cli_file_drop(&s.output);
    nsdf_cli_abort(); /* after success nothing is left to remove */
    free(s.vertex_distance);
    free(s.differences);
    cmp_frames_close(&s.frames);
    nsdf_compare_close(&s.compare);
    return result;
}
