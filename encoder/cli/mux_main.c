/* nsdf-mux: cuts, joins and changes .nsdf files without coding anything again. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "cli_util.h"
#include "mux_info.h"
#include "mux_input.h"
#include "mux_options.h"

static int report(const char *name, const nsdf_encoder_error *error) {
    nsdf_cli_error("%s: %s", name, error->message);
    return NSDF_CLI_FAILURE;
}

/* ---- Joining ------------------------------------------------------------------------------------------------------
 */

/* As a fraction of the diagonal; some times what models of one surface are apart. */
static const double widest_gap = 0.01;

/* A join in a moving surface is mixed over; one between different surfaces would show both at once. */
static uint32_t choose_fade(const mux_options *o, const mux_input *before, const mux_input *input) {
    if (o->has_fade)
        return o->fade;
    const double gap = mux_input_gap(before, o->shared ? 0 : 1, input);
    nsdf_cli_verbose("%s is %.2g %% of the diagonal from where %s leads: %s", input->name, 100.0 * gap, before->name,
                     gap <= widest_gap ? "it goes on" : "no cross-fade");
    return gap <= widest_gap ? NSDF_MUX_FADE_AUTO : 0;
}

/* The frame after the last is made by the model that ends, as far as it reaches, and then stands still. */
static int append(const mux_options *o, nsdf_mux *whole, const mux_input *before, const mux_input *input) {
    nsdf_encoder_error error = {.status = NSDF_OK};
    nsdf_mux *mux = mux_input_open(input);
    if (!mux)
        return NSDF_CLI_FAILURE;
    const uint32_t fade = choose_fade(o, before, input);
    nsdf_status status = o->shared ? NSDF_OK : nsdf_mux_hold(whole, 1, &error);
    if (status == NSDF_OK)
        status = nsdf_mux_append(whole, mux, fade, &error);
    nsdf_mux_close(&mux);
    return status == NSDF_OK ? NSDF_CLI_SUCCESS : report(input->name, &error);
}

static int join(const mux_options *o, nsdf_mux **whole) {
    mux_input before, input;
    int result = mux_input_read(&before, o->inputs[0]) == 0 ? NSDF_CLI_SUCCESS : NSDF_CLI_FAILURE;
    if (result == NSDF_CLI_SUCCESS && !(*whole = mux_input_open(&before)))
        result = NSDF_CLI_FAILURE;
    for (int i = 1; i < o->input_count && result == NSDF_CLI_SUCCESS; i++) {
        result = mux_input_read(&input, o->inputs[i]) == 0 ? append(o, *whole, &before, &input) : NSDF_CLI_FAILURE;
        mux_input_free(&before);
        before = input;
    }
    mux_input_free(&before);
    return result;
}

/* ---- Replacing and cutting ------------------------------------------------------------------------------------------
 */

static int replace(const mux_options *o, nsdf_mux *whole) {
    mux_input input;
    nsdf_encoder_error error;
    nsdf_mux *mux = mux_input_read(&input, o->with) == 0 ? mux_input_open(&input) : NULL;
    const uint32_t last = o->replaced.last == UINT32_MAX ? nsdf_mux_segment_count(whole) - 1 : o->replaced.last;
    int result = NSDF_CLI_FAILURE;
    if (mux) {
        const nsdf_status status = nsdf_mux_replace(whole, o->replaced.first, last, mux, &error);
        result = status == NSDF_OK ? NSDF_CLI_SUCCESS : report(o->with, &error);
    }
    nsdf_mux_close(&mux);
    mux_input_free(&input);
    return result;
}

/* Frames of segments; the one that begins the next segment is its last. */
static int frames_of_segments(const mux_options *o, const nsdf_mux *mux, uint32_t *first, uint32_t *last) {
    const uint32_t count = nsdf_mux_segment_count(mux);
    const uint32_t end = o->segments.last == UINT32_MAX ? count - 1 : o->segments.last;
    nsdf_mux_segment a, b;
    if (nsdf_mux_get_segment(mux, o->segments.first, &a) != NSDF_OK || nsdf_mux_get_segment(mux, end, &b) != NSDF_OK)
        return nsdf_cli_usage_error("--segments: out of range: there are segments 0 to %u", count - 1);
    *first = a.first_frame;
    *last = b.last_frame;
    return NSDF_CLI_SUCCESS;
}

static int frames_of_times(const mux_options *o, const nsdf_mux *mux, uint32_t *first, uint32_t *last) {
    uint32_t num = 0, den = 1;
    const double end = nsdf_mux_frame_count(mux) - 1;
    nsdf_mux_get_rate(mux, &num, &den);
    const double from = o->from * num / den, to = o->to * num / den;
    if (from < 0.0 || from > end)
        return nsdf_cli_usage_error("--times: %g s is out of range, which is 0 to %.9g s", o->from, end * den / num);
    *first = (uint32_t)floor(from + 1e-6);
    *last = (uint32_t)fmin(ceil(to - 1e-6), end);
    if (*last < *first)
        *last = *first;
    return NSDF_CLI_SUCCESS;
}

static int choose_frames(const mux_options *o, const nsdf_mux *mux, uint32_t *first, uint32_t *last) {
    const uint32_t end = nsdf_mux_frame_count(mux) - 1;
    if (o->segments.given)
        return frames_of_segments(o, mux, first, last);
    if (o->has_times)
        return frames_of_times(o, mux, first, last);
    *first = o->frames.first;
    *last = o->frames.last == UINT32_MAX ? end : o->frames.last;
    return *last <= end && *first <= end
               ? NSDF_CLI_SUCCESS
               : nsdf_cli_usage_error("--frames: out of range: there are frames 0 to %u", end);
}

/* How many frames of models that are kept lie outside the cut. */
static uint32_t frames_outside(const nsdf_mux *mux, uint32_t first, uint32_t last) {
    uint32_t outside = 0;
    nsdf_mux_segment s;
    for (uint32_t i = 0; nsdf_mux_get_segment(mux, i, &s) == NSDF_OK; i++) {
        if (s.first_frame < first && s.last_frame > first)
            outside += first - s.first_frame;
        if (s.first_frame < last && s.last_frame > last)
            outside += s.last_frame - last;
    }
    return outside;
}

static int cut(const mux_options *o, nsdf_mux *mux) {
    uint32_t first = 0, last = 0, num = 0, den = 1;
    nsdf_encoder_error error;
    const int result = choose_frames(o, mux, &first, &last);
    if (result != NSDF_CLI_SUCCESS)
        return result;
    const uint32_t outside = frames_outside(mux, first, last);
    nsdf_mux_get_rate(mux, &num, &den);
    nsdf_cli_say("frames %u to %u, %.9g s to %.9g s, of %u", first, last, (double)first * den / num,
                 (double)last * den / num, nsdf_mux_frame_count(mux));
    if (nsdf_mux_cut(mux, first, last, &error) != NSDF_OK)
        return report(o->inputs[0], &error);
    if (outside > 0)
        nsdf_cli_say("the cut lies inside segments, which cannot be divided: %u frames outside it stay in the file",
                     outside);
    return NSDF_CLI_SUCCESS;
}

/* ---- Changing -------------------------------------------------------------------------------------------------------
 */

static int change(const mux_options *o, nsdf_mux *mux) {
    nsdf_encoder_error error = {.status = NSDF_OK};
    nsdf_status status = o->rate_num ? nsdf_mux_set_rate(mux, o->rate_num, o->rate_den, &error) : NSDF_OK;
    if (status == NSDF_OK)
        status = nsdf_mux_hold(mux, o->hold, &error);
    for (int i = 0; i < o->pair_count && status == NSDF_OK; i++)
        status = nsdf_mux_set_metadata(mux, o->pairs[i].key, o->pairs[i].value, &error);
    return status == NSDF_OK ? NSDF_CLI_SUCCESS : report(o->inputs[0], &error);
}

static int edit(const mux_options *o, nsdf_mux **whole) {
    int result = join(o, whole);
    if (result == NSDF_CLI_SUCCESS && o->with)
        result = replace(o, *whole);
    if (result == NSDF_CLI_SUCCESS && (o->frames.given || o->has_times || o->segments.given))
        result = cut(o, *whole);
    return result == NSDF_CLI_SUCCESS ? change(o, *whole) : result;
}

/* ---- Output ---------------------------------------------------------------------------------------------------------
 */

static int is_same_file(const char *a, const char *b) {
    struct stat x, y;
    return stat(a, &x) == 0 && stat(b, &y) == 0 && S_ISREG(x.st_mode) && x.st_dev == y.st_dev && x.st_ino == y.st_ino;
}

static int check_output(const mux_options *o) {
    for (int i = 0; i < o->input_count; i++)
        if (is_same_file(o->inputs[i], o->output))
            return nsdf_cli_usage_error("%s: the output would replace an input", o->output);
    return NSDF_CLI_SUCCESS;
}

typedef struct counted_file {
    nsdf_cli_file file;
    uint64_t size;
} counted_file;

static int write_counted(void *user, const void *data, size_t size) {
    counted_file *c = user;
    c->size += size;
    return nsdf_cli_file_write(&c->file, data, size);
}

static int write_file(const mux_options *o, const nsdf_mux *mux) {
    nsdf_encoder_error error;
    counted_file out = {.size = 0};
    if (nsdf_cli_file_open(&out.file, o->output) != 0)
        return NSDF_CLI_FAILURE;
    const nsdf_status status = nsdf_mux_write(mux, write_counted, &out, &error);
    if (nsdf_cli_file_close(&out.file) != 0)
        return NSDF_CLI_FAILURE; /* says why, also when a write failed */
    if (status != NSDF_OK)
        return report(o->output, &error);
    if (nsdf_cli_interrupts() > 0) {
        nsdf_cli_error("interrupted");
        return NSDF_CLI_FAILURE;
    }
    if (nsdf_cli_commit() != 0)
        return NSDF_CLI_FAILURE;
    nsdf_cli_say("%s: %u frames, %u segment%s, %llu bytes", strcmp(o->output, "-") == 0 ? "output" : o->output,
                 nsdf_mux_frame_count(mux), nsdf_mux_segment_count(mux), nsdf_mux_segment_count(mux) == 1 ? "" : "s",
                 (unsigned long long)out.size);
    return NSDF_CLI_SUCCESS;
}

static int write_edited(const mux_options *o) {
    nsdf_mux *whole = NULL;
    nsdf_cli_catch_signals();
    int result = check_output(o);
    if (result == NSDF_CLI_SUCCESS)
        result = edit(o, &whole);
    if (result == NSDF_CLI_SUCCESS)
        result = write_file(o, whole);
    nsdf_mux_close(&whole);
    return result;
}

/* ---- Actions --------------------------------------------------------------------------------------------------------
 */

/* All inputs, also behind one that fails. */
static int look_at_each(const mux_options *o, int (*look)(const mux_input *input)) {
    int result = NSDF_CLI_SUCCESS;
    for (int i = 0; i < o->input_count; i++) {
        mux_input input;
        if (mux_input_read(&input, o->inputs[i]) != 0 || look(&input) != NSDF_CLI_SUCCESS)
            result = NSDF_CLI_FAILURE;
        mux_input_free(&input);
    }
    return result;
}

static int run(const mux_options *o) {
    switch (o->action) {
    case MUX_NOTHING:
        return NSDF_CLI_SUCCESS;
    case MUX_INFO:
        return look_at_each(o, mux_info_print);
    case MUX_VALIDATE:
        return look_at_each(o, mux_info_validate);
    default:
        return write_edited(o);
    }
}

int main(int argc, char **argv) {
    mux_options options;
    nsdf_cli_begin("nsdf-mux");
    int result = mux_options_parse(argc, argv, &options);
    if (result == NSDF_CLI_SUCCESS)
        result = run(&options);
    mux_options_free(&options);
    nsdf_cli_abort();
    if (fflush(stdout) != 0 && result == NSDF_CLI_SUCCESS) {
        nsdf_cli_error("cannot write standard output: %s", strerror(errno));
        result = NSDF_CLI_FAILURE;
    }
    return result;
}
