/* Editing files in parts (nsdf/mux.h). */
#include "mux_file.h"

#include "frames.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static nsdf_status out_of_memory(nsdf_encoder_error *error) {
    return nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory");
}

nsdf_status nsdf_mux_open(nsdf_mux **mux, const void *data, size_t size, nsdf_encoder_error *error) {
    if (!mux || !data)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given");
    nsdf_mux *m = calloc(1, sizeof *m);
    if (!m)
        return out_of_memory(error);
    const nsdf_status status = nsdf_mux_read(m, data, size, error);
    if (status == NSDF_OK)
        *mux = m;
    else
        nsdf_mux_close(&m);
    return status;
}

void nsdf_mux_close(nsdf_mux **mux) {
    if (!mux || !*mux)
        return;
    nsdf_mux_release(*mux);
    free(*mux);
    *mux = NULL;
}

uint32_t nsdf_mux_frame_count(const nsdf_mux *mux) {
    return mux ? mux->header.frame_count : 0;
}

uint32_t nsdf_mux_segment_count(const nsdf_mux *mux) {
    return mux ? mux->header.segment_count : 0;
}

nsdf_status nsdf_mux_get_quality(const nsdf_mux *mux, nsdf_quality *quality) {
    if (!mux || !quality || !mux->has_quality)
        return NSDF_INVALID_ARGUMENT;
    const nsdf_quality_record *q = &mux->quality;
    *quality =
        (nsdf_quality){q->mean[0], q->mean[1], q->rms[0], q->rms[1], q->max[0], q->max[1], q->resolution, q->frames};
    return NSDF_OK;
}

/* ---- Joining ------------------------------------------------------------------------------------------------ */

nsdf_status nsdf_mux_expect_same(const nsdf_file_header *a, const nsdf_file_header *b, nsdf_encoder_error *error) {
    if ((uint64_t)a->rate_num * b->rate_den != (uint64_t)b->rate_num * a->rate_den)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "frame rates differ: %u/%u and %u/%u", a->rate_num,
                                 a->rate_den, b->rate_num, b->rate_den);
    for (int k = 0; k < 3; k++)
        if (a->centre[k] != b->centre[k] || a->scale != b->scale || a->domain_min[k] != b->domain_min[k] ||
            a->domain_max[k] != b->domain_max[k])
            return nsdf_encoder_fail(
                error, NSDF_INVALID_ARGUMENT, "boxes differ: (%g %g %g) to (%g %g %g), and (%g %g %g) to (%g %g %g)",
                a->box_min[0], a->box_min[1], a->box_min[2], a->box_max[0], a->box_max[1], a->box_max[2], b->box_min[0],
                b->box_min[1], b->box_min[2], b->box_max[0], b->box_max[1], b->box_max[2]);
    return NSDF_OK;
}

static nsdf_status expect_room(const nsdf_mux *mux, const nsdf_mux *other, uint32_t fade, nsdf_encoder_error *error) {
    const nsdf_index_entry *before = &mux->entries[mux->header.segment_count - 1], *after = &other->entries[0];
    const uint64_t frames = (uint64_t)mux->header.frame_count + other->header.frame_count - 1;
    const uint64_t segments = (uint64_t)mux->header.segment_count + other->header.segment_count;
    const uint32_t left = before->last_frame - before->first_frame - before->fade;
    const uint32_t right =
        after->last_frame - after->first_frame - (other->header.segment_count > 1 ? other->entries[1].fade : 0);
    if (mux->header.frame_count < 2 || other->header.frame_count < 2)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT,
                                 "a file of a single frame cannot be joined: hold it for a frame first");
    if (frames > INT32_MAX || segments > NSDF_MAX_SEGMENTS)
        return nsdf_encoder_fail(error, NSDF_LIMIT, "more than 2^31 - 1 frames or 2^20 segments together");
    if (fade > 0 && ((int64_t)fade > before->trail || (int64_t)fade > after->lead || fade > left || fade > right))
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT,
                                 "a cross-fade of %u frames needs models that reach over the join by as many: they "
                                 "reach %d and %d, and have %u and %u frames of their own",
                                 fade, before->trail, after->lead, left, right);
    return NSDF_OK;
}

/* Means by frames.  The frame of the join was measured in both files, but for one that is held, which was in none of
 * `mux`: it counts once, with the mean of `other`. */
static void join_quality(nsdf_mux *mux, const nsdf_mux *other) {
    nsdf_quality_record *a = &mux->quality;
    const nsdf_quality_record *b = &other->quality;
    const uint32_t shared = !mux->is_held, more = b->frames > shared ? b->frames - shared : 0;
    mux->has_quality = mux->has_quality && other->has_quality && a->resolution == b->resolution &&
                       (uint64_t)a->frames + more > 0 && (uint64_t)a->frames + more <= UINT32_MAX;
    if (!mux->has_quality)
        return;
    const double share = (double)more / ((double)a->frames + more);
    for (int k = 0; k < 2; k++) {
        a->mean[k] += share * (b->mean[k] - a->mean[k]);
        a->rms[k] = sqrt((1.0 - share) * a->rms[k] * a->rms[k] + share * b->rms[k] * b->rms[k]);
        a->max[k] = fmax(a->max[k], b->max[k]);
    }
    a->frames += more;
}

void nsdf_mux_join_box(nsdf_file_header *a, const nsdf_file_header *b) {
    for (int k = 0; k < 3; k++) {
        a->box_min[k] = fmin(a->box_min[k], b->box_min[k]);
        a->box_max[k] = fmax(a->box_max[k], b->box_max[k]);
    }
    /* A larger bound skips less, and gives the same surface. */
    a->extraction_bound = fmaxf(a->extraction_bound, b->extraction_bound);
    /* The thinnest surface of both needs the finer one. */
    if (b->default_resolution > a->default_resolution)
        a->default_resolution = b->default_resolution;
}

/* Whether the first segment of `other` is the rest of the last one of mux: one model, at one place in time. */
static int goes_on(const nsdf_mux *mux, const nsdf_mux *other) {
    const uint32_t last = mux->header.segment_count - 1;
    const nsdf_index_entry *a = &mux->entries[last], *b = &other->entries[0];
    const nsdf_buffer *x = &mux->payloads[last], *y = &other->payloads[0];
    const int64_t start = (int64_t)a->last_frame + b->first_frame - b->lead;
    const int64_t end = (int64_t)a->last_frame + b->last_frame + b->trail;
    return start == (int64_t)a->first_frame - a->lead && end == (int64_t)a->last_frame + a->trail &&
           !(a->smallest_piece < b->smallest_piece) && !(a->smallest_piece > b->smallest_piece) && x->size == y->size &&
           memcmp(x->data, y->data, x->size) == 0;
}

static int append_rest(nsdf_mux *mux, const nsdf_mux *other) {
    nsdf_index_entry *a = &mux->entries[mux->header.segment_count - 1];
    const nsdf_index_entry *b = &other->entries[0];
    const uint32_t last = a->last_frame + b->last_frame;
    if (nsdf_mux_take_rest(mux, other) != 0)
        return -1;
    a = &mux->entries[mux->header.segment_count - other->header.segment_count];
    a->last_frame = last;
    a->trail = b->trail;
    return 0;
}

static int append_segments(nsdf_mux *mux, const nsdf_mux *other, uint32_t fade) {
    const uint32_t at = mux->header.segment_count;
    if (nsdf_mux_take_segments(mux, other, 0, other->header.segment_count) != 0)
        return -1;
    mux->entries[at].fade = fade;
    return 0;
}

static uint32_t longest_fade(const nsdf_mux *mux, const nsdf_mux *other) {
    uint32_t fade = NSDF_MUX_FADE;
    nsdf_encoder_error refused;
    while (fade > 0 && expect_room(mux, other, fade, &refused) != NSDF_OK)
        fade--;
    return fade;
}

nsdf_status nsdf_mux_append(nsdf_mux *mux, const nsdf_mux *other, uint32_t fade, nsdf_encoder_error *error) {
    if (!mux || !other)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given");
    if (mux == other)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a file cannot be appended to itself: open it twice");
    const int rest = (fade == 0 || fade == NSDF_MUX_FADE_AUTO) && goes_on(mux, other);
    if (fade == NSDF_MUX_FADE_AUTO)
        fade = longest_fade(mux, other);
    nsdf_status status = nsdf_mux_expect_same(&mux->header, &other->header, error);
    if (status == NSDF_OK)
        status = expect_room(mux, other, fade, error);
    if (status != NSDF_OK)
        return status;
    const uint32_t at = mux->header.segment_count, shift = mux->header.frame_count - 1;
    if ((rest ? append_rest(mux, other) : append_segments(mux, other, fade)) != 0)
        return out_of_memory(error);
    for (uint32_t i = at; i < mux->header.segment_count; i++) {
        mux->entries[i].first_frame += shift;
        mux->entries[i].last_frame += shift;
    }
    nsdf_mux_join_box(&mux->header, &other->header);
    mux->header.frame_count += other->header.frame_count - 1;
    join_quality(mux, other);
    mux->is_held = other->is_held;
    return NSDF_OK;
}

nsdf_status nsdf_mux_hold(nsdf_mux *mux, uint32_t frames, nsdf_encoder_error *error) {
    if (!mux)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given");
    nsdf_index_entry *last = &mux->entries[mux->header.segment_count - 1];
    if (frames > INT32_MAX - mux->header.frame_count || (int64_t)last->trail - frames < INT32_MIN)
        return nsdf_encoder_fail(error, NSDF_LIMIT, "more than 2^31 - 1 frames");
    last->last_frame += frames;
    last->trail -= (int32_t)frames;
    mux->header.frame_count += frames;
    mux->is_held |= frames > 0;
    return NSDF_OK;
}

/* ---- Cutting ------------------------------------------------------------------------------------------------ */

/* Makes a cross-fade as short as the frames on its sides. */
static void shorten_fades(nsdf_mux *mux) {
    mux->entries[0].fade = 0;
    for (uint32_t i = 1; i < mux->header.segment_count; i++) {
        const nsdf_index_entry *before = &mux->entries[i - 1];
        nsdf_index_entry *e = &mux->entries[i];
        const uint32_t left = before->last_frame - before->first_frame - before->fade;
        const uint32_t right = e->last_frame - e->first_frame, room = left < right ? left : right;
        e->fade = e->fade < room ? e->fade : room;
    }
}

/* The first and the last segment with a part of frames first to last: a last frame that only begins a segment does not
 * need it. */
static void find_segments(const nsdf_mux *mux, uint32_t first, uint32_t last, uint32_t *from, uint32_t *to) {
    *from = 0;
    while (*from + 1 < mux->header.segment_count && mux->entries[*from + 1].first_frame <= first)
        ++*from;
    *to = *from;
    while (*to + 1 < mux->header.segment_count && mux->entries[*to + 1].first_frame < last)
        ++*to;
}

static void move_ends(nsdf_mux *mux, uint32_t first, uint32_t last) {
    nsdf_index_entry *head = &mux->entries[0], *tail = &mux->entries[mux->header.segment_count - 1];
    head->lead += (int32_t)(first - head->first_frame);
    head->first_frame = first;
    tail->trail += (int32_t)(tail->last_frame - last);
    tail->last_frame = last;
    for (uint32_t i = 0; i < mux->header.segment_count; i++) {
        mux->entries[i].first_frame -= first;
        mux->entries[i].last_frame -= first;
    }
    mux->header.frame_count = last - first + 1;
    shorten_fades(mux);
}

nsdf_status nsdf_mux_cut(nsdf_mux *mux, uint32_t first, uint32_t last, nsdf_encoder_error *error) {
    if (!mux)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given");
    if (first > last || last >= mux->header.frame_count)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "frames %u to %u of a file that has frames 0 to %u",
                                 first, last, mux->header.frame_count - 1);
    if (first == 0 && last == mux->header.frame_count - 1)
        return NSDF_OK;
    uint32_t from, to;
    nsdf_mux cut = {.header = mux->header, .has_metadata = mux->has_metadata};
    cut.header.segment_count = 0;
    find_segments(mux, first, last, &from, &to);
    nsdf_buffer_append(&cut.metadata, mux->metadata.data, mux->metadata.size);
    if (cut.metadata.failed || nsdf_mux_take_segments(&cut, mux, from, to - from + 1) != 0) {
        nsdf_mux_release(&cut);
        return out_of_memory(error);
    }
    move_ends(&cut, first, last);
    nsdf_mux_release(mux);
    *mux = cut;
    return NSDF_OK;
}

/* ---- Writing ------------------------------------------------------------------------------------------------ */

nsdf_status nsdf_mux_write(const nsdf_mux *mux, int (*write)(void *user, const void *data, size_t size), void *user,
                           nsdf_encoder_error *error) {
    if (!mux || !write)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given");
    nsdf_buffer file = {NULL, 0, 0, 0};
    nsdf_file_parts parts = {mux->header,
                             mux->payloads,
                             mux->entries,
                             mux->has_metadata ? &mux->metadata : NULL,
                             mux->has_quality ? &mux->quality : NULL,
                             mux->others,
                             mux->other_count};
    nsdf_status status = NSDF_OK;
    if (nsdf_write_file(&file, &parts) != 0)
        status = out_of_memory(error);
    else if (write(user, file.data, file.size) != 0)
        status = nsdf_encoder_fail(error, NSDF_IO, "the file cannot be written");
    nsdf_buffer_free(&file);
    return status;
}
