/* Editing files in parts: segments, rate and metadata replaced, and what is in them (nsdf/mux.h). */
#include "mux_file.h"

#include "frames.h"

#include <string.h>

static nsdf_status fail_null(nsdf_encoder_error *error) {
    return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given");
}

static nsdf_status out_of_memory(nsdf_encoder_error *error) {
    return nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory");
}

/* ---- Segments ----------------------------------------------------------------------------------------------- */

nsdf_status nsdf_mux_get_segment(const nsdf_mux *mux, uint32_t index, nsdf_mux_segment *segment) {
    if (!mux || !segment || index >= mux->header.segment_count)
        return NSDF_INVALID_ARGUMENT;
    const nsdf_index_entry *e = &mux->entries[index];
    *segment = (nsdf_mux_segment){
        e->first_frame, e->last_frame, e->lead, e->trail, e->fade, mux->payloads[index].size, e->parameter_hash};
    return NSDF_OK;
}

static uint32_t at_most(uint32_t value, int64_t limit) {
    return limit <= 0 ? 0 : value < limit ? value : (uint32_t)limit;
}

/* As short as what its two sides leave room for. */
static void shorten_fade(nsdf_mux *mux, uint32_t index) {
    const nsdf_index_entry *before = &mux->entries[index - 1], *e = &mux->entries[index];
    const uint32_t next = index + 1 < mux->header.segment_count ? mux->entries[index + 1].fade : 0;
    uint32_t fade = at_most(e->fade, before->trail);
    fade = at_most(fade, e->lead);
    fade = at_most(fade, (int64_t)before->last_frame - before->first_frame - before->fade);
    mux->entries[index].fade = at_most(fade, (int64_t)e->last_frame - e->first_frame - next);
}

/* Those of `mux` with segments first to last taken from `other`. */
static int assemble(nsdf_mux *made, const nsdf_mux *mux, uint32_t first, uint32_t last, const nsdf_mux *other) {
    const uint32_t count = other->header.segment_count, behind = mux->header.segment_count - 1 - last;
    const uint32_t shift = mux->entries[first].first_frame;
    if (first > 0 && nsdf_mux_take_segments(made, mux, 0, first) != 0)
        return -1;
    if (nsdf_mux_take_segments(made, other, 0, count) != 0)
        return -1;
    for (uint32_t i = first; i < first + count; i++) {
        made->entries[i].first_frame += shift;
        made->entries[i].last_frame += shift;
    }
    return behind > 0 ? nsdf_mux_take_segments(made, mux, last + 1, behind) : 0;
}

static nsdf_status check_replacement(const nsdf_mux *mux, uint32_t first, uint32_t last, const nsdf_mux *other,
                                     nsdf_encoder_error *error) {
    const uint32_t count = mux->header.segment_count;
    if (first > last || last >= count)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "segments %u to %u of a file that has segments 0 to %u",
                                 first, last, count - 1);
    const uint32_t steps = mux->entries[last].last_frame - mux->entries[first].first_frame;
    if (other->header.frame_count - 1 != steps)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "the segments have %u frames, and the other file has %u",
                                 steps + 1, other->header.frame_count);
    if ((uint64_t)count + other->header.segment_count > NSDF_MAX_SEGMENTS)
        return nsdf_encoder_fail(error, NSDF_LIMIT, "more than 2^20 segments together");
    return nsdf_mux_expect_same(&mux->header, &other->header, error);
}

nsdf_status nsdf_mux_replace(nsdf_mux *mux, uint32_t first, uint32_t last, const nsdf_mux *other,
                             nsdf_encoder_error *error) {
    if (!mux || !other)
        return fail_null(error);
    const nsdf_status status = check_replacement(mux, first, last, other, error);
    if (status != NSDF_OK)
        return status;
    nsdf_mux made = {.header = mux->header, .has_metadata = mux->has_metadata};
    made.header.segment_count = 0;
    nsdf_buffer_append(&made.metadata, mux->metadata.data, mux->metadata.size);
    if (made.metadata.failed || assemble(&made, mux, first, last, other) != 0) {
        nsdf_mux_release(&made);
        return out_of_memory(error);
    }
    made.entries[first].fade = mux->entries[first].fade;
    const uint32_t end = first + other->header.segment_count;
    if (first > 0)
        shorten_fade(&made, first);
    if (end < made.header.segment_count)
        shorten_fade(&made, end);
    nsdf_mux_join_box(&made.header, &other->header);
    nsdf_mux_release(mux);
    *mux = made;
    return NSDF_OK;
}

/* ---- Rate ----------------------------------------------------------------------------------------------------- */

void nsdf_mux_get_rate(const nsdf_mux *mux, uint32_t *num, uint32_t *den) {
    if (!mux)
        return;
    *num = mux->header.rate_num;
    *den = mux->header.rate_den;
}

nsdf_status nsdf_mux_set_rate(nsdf_mux *mux, uint32_t num, uint32_t den, nsdf_encoder_error *error) {
    if (!mux)
        return fail_null(error);
    if (num == 0 || den == 0)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a frame rate of %u/%u", num, den);
    mux->header.rate_num = num;
    mux->header.rate_den = den;
    return NSDF_OK;
}

/* ---- Metadata ------------------------------------------------------------------------------------------------- */

/* The next pair; *key is NULL at the end.  What is in a nsdf_mux was checked. */
static int next_pair(const nsdf_buffer *metadata, size_t *cursor, const char **key, const char **value) {
    return nsdf_read_metadata(metadata->data, metadata->size, cursor, key, value, NULL) == NSDF_PARSE_OK && *key;
}

uint32_t nsdf_mux_metadata_count(const nsdf_mux *mux) {
    uint32_t count = 0;
    size_t cursor = 0;
    const char *key, *value;
    while (mux && next_pair(&mux->metadata, &cursor, &key, &value))
        count++;
    return count;
}

nsdf_status nsdf_mux_get_metadata(const nsdf_mux *mux, uint32_t index, const char **key, const char **value) {
    size_t cursor = 0;
    const char *k, *v;
    if (!mux || !key || !value)
        return NSDF_INVALID_ARGUMENT;
    while (next_pair(&mux->metadata, &cursor, &k, &v)) {
        if (index-- > 0)
            continue;
        *key = k;
        *value = v;
        return NSDF_OK;
    }
    return NSDF_INVALID_ARGUMENT;
}

/* The pairs of `from` with those of `key` replaced by one, or by none. */
static void rewrite(nsdf_buffer *to, const nsdf_buffer *from, const char *key, const char *value) {
    size_t cursor = 0;
    const char *k, *v;
    while (next_pair(from, &cursor, &k, &v)) {
        if (strcmp(k, key) != 0) {
            nsdf_write_metadata(to, k, v);
        } else if (value) {
            nsdf_write_metadata(to, key, value);
            value = NULL;
        }
    }
    if (value)
        nsdf_write_metadata(to, key, value);
}

static int is_allowed(const char *key, const char *value) {
    nsdf_buffer pair = {NULL, 0, 0, 0};
    size_t cursor = 0;
    const char *k, *v;
    if (!*key || strlen(key) > UINT16_MAX || (value && strlen(value) > UINT32_MAX))
        return 0;
    nsdf_write_metadata(&pair, key, value ? value : "");
    const int allowed = pair.failed || next_pair(&pair, &cursor, &k, &v);
    nsdf_buffer_free(&pair);
    return allowed;
}

nsdf_status nsdf_mux_set_metadata(nsdf_mux *mux, const char *key, const char *value, nsdf_encoder_error *error) {
    nsdf_buffer made = {NULL, 0, 0, 0};
    if (!mux || !key)
        return fail_null(error);
    if (!is_allowed(key, value))
        return nsdf_encoder_fail(
            error, NSDF_INVALID_ARGUMENT,
            "a key of metadata that is empty or longer than 65535 bytes, or text that is not UTF-8");
    rewrite(&made, &mux->metadata, key, value);
    if (made.failed) {
        nsdf_buffer_free(&made);
        return out_of_memory(error);
    }
    nsdf_buffer_free(&mux->metadata);
    mux->metadata = made;
    mux->has_metadata = made.size > 0;
    return NSDF_OK;
}

/* ---- Other chunks --------------------------------------------------------------------------------------------- */

uint32_t nsdf_mux_chunk_count(const nsdf_mux *mux) {
    return mux ? mux->other_count : 0;
}

nsdf_status nsdf_mux_get_chunk(const nsdf_mux *mux, uint32_t index, nsdf_mux_chunk *chunk) {
    if (!mux || !chunk || index >= mux->other_count)
        return NSDF_INVALID_ARGUMENT;
    const nsdf_loose_chunk *c = &mux->others[index];
    memset(chunk, 0, sizeof *chunk);
    for (int k = 0; k < 4; k++)
        chunk->type[k] = (char)(c->type >> 8 * k & 0xff);
    chunk->before = c->before;
    chunk->size = c->payload.size;
    return NSDF_OK;
}
