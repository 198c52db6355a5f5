/* Taking a file apart, and holding its parts. */
#include "mux_file.h"

#include "frames.h"

#include <stdlib.h>
#include <string.h>

/* ---- Growing ------------------------------------------------------------------------------------------------ */

static int append_copy(nsdf_buffer *to, const nsdf_buffer *from) {
    nsdf_buffer_append(to, from->data, from->size);
    return to->failed ? -1 : 0;
}

static int copy_segments(nsdf_mux *mux, const nsdf_mux *from, uint32_t first, uint32_t count) {
    const uint32_t at = mux->header.segment_count;
    for (uint32_t i = 0; i < count; i++) {
        mux->entries[at + i] = from->entries[first + i];
        memset(&mux->payloads[at + i], 0, sizeof *mux->payloads);
        mux->header.segment_count++; /* so that nsdf_mux_release frees it */
        if (append_copy(&mux->payloads[at + i], &from->payloads[first + i]) != 0)
            return -1;
    }
    return 0;
}

/* Whether chunk `c` goes with segments first to end - 1 of `from`. */
static int goes_along(const nsdf_mux *from, const nsdf_loose_chunk *c, uint32_t first, uint32_t end) {
    const int behind_all = c->before == from->header.segment_count && end == c->before;
    return (c->before >= first && c->before < end) || behind_all;
}

static int copy_others(nsdf_mux *mux, const nsdf_mux *from, uint32_t first, uint32_t count, uint32_t at) {
    for (uint32_t i = 0; i < from->other_count; i++) {
        const nsdf_loose_chunk *c = &from->others[i];
        if (!goes_along(from, c, first, first + count))
            continue;
        nsdf_loose_chunk *copy = &mux->others[mux->other_count++];
        *copy = (nsdf_loose_chunk){c->type, c->flags, c->before - first + at, {NULL, 0, 0, 0}};
        if (append_copy(&copy->payload, &c->payload) != 0)
            return -1;
    }
    return 0;
}

static int reserve(nsdf_mux *mux, uint32_t segments, uint32_t others) {
    const size_t total = (size_t)mux->header.segment_count + segments, loose = (size_t)mux->other_count + others;
    nsdf_index_entry *entries = realloc(mux->entries, total * sizeof *entries);
    if (entries)
        mux->entries = entries;
    nsdf_buffer *payloads = realloc(mux->payloads, total * sizeof *payloads);
    if (payloads)
        mux->payloads = payloads;
    nsdf_loose_chunk *chunks = realloc(mux->others, (loose + 1) * sizeof *chunks);
    if (chunks)
        mux->others = chunks;
    return entries && payloads && chunks ? 0 : -1;
}

/* Frees the segments and the other chunks from those numbers on. */
static void drop_from(nsdf_mux *mux, uint32_t segment, uint32_t other) {
    for (; mux->header.segment_count > segment; mux->header.segment_count--)
        nsdf_buffer_free(&mux->payloads[mux->header.segment_count - 1]);
    for (; mux->other_count > other; mux->other_count--)
        nsdf_buffer_free(&mux->others[mux->other_count - 1].payload);
}

int nsdf_mux_take_segments(nsdf_mux *mux, const nsdf_mux *from, uint32_t first, uint32_t count) {
    const uint32_t segments = mux->header.segment_count, others = mux->other_count;
    if (reserve(mux, count, from->other_count) != 0)
        return -1;
    if (copy_segments(mux, from, first, count) == 0 && copy_others(mux, from, first, count, segments) == 0)
        return 0;
    drop_from(mux, segments, others);
    return -1;
}

static int is_same_chunk(const nsdf_loose_chunk *a, const nsdf_loose_chunk *b) {
    return a->type == b->type && a->flags == b->flags && a->payload.size == b->payload.size &&
           (a->payload.size == 0 || memcmp(a->payload.data, b->payload.data, a->payload.size) == 0);
}

/* The other chunks of `from` but those that stand at the same place among the first `known` of mux already. */
static int copy_new_others(nsdf_mux *mux, const nsdf_mux *from, uint32_t at, uint32_t known) {
    for (uint32_t i = 0; i < from->other_count; i++) {
        const nsdf_loose_chunk *c = &from->others[i];
        const uint32_t before = c->before == 0 ? at : c->before - 1 + at, twin = c->before == 0 ? at - 1 : before;
        int found = 0;
        for (uint32_t k = 0; k < known && !found; k++)
            found = mux->others[k].before == twin && is_same_chunk(&mux->others[k], c);
        if (found)
            continue;
        nsdf_loose_chunk *copy = &mux->others[mux->other_count++];
        *copy = (nsdf_loose_chunk){c->type, c->flags, before, {NULL, 0, 0, 0}};
        if (append_copy(&copy->payload, &c->payload) != 0)
            return -1;
    }
    return 0;
}

int nsdf_mux_take_rest(nsdf_mux *mux, const nsdf_mux *from) {
    const uint32_t segments = mux->header.segment_count, others = mux->other_count;
    const uint32_t more = from->header.segment_count - 1;
    if (reserve(mux, more, from->other_count) != 0)
        return -1;
    if (copy_segments(mux, from, 1, more) == 0 && copy_new_others(mux, from, segments, others) == 0)
        return 0;
    drop_from(mux, segments, others);
    return -1;
}

void nsdf_mux_release(nsdf_mux *mux) {
    drop_from(mux, 0, 0);
    nsdf_buffer_free(&mux->metadata);
    free(mux->entries);
    free(mux->payloads);
    free(mux->others);
    memset(mux, 0, sizeof *mux);
}

/* ---- Reading ------------------------------------------------------------------------------------------------ */

/* The decoder knows all that a file must be, and says what is wrong. */
static nsdf_status check_file(const uint8_t *data, size_t size, nsdf_encoder_error *error) {
    nsdf_decoder_options options;
    nsdf_decoder *decoder = NULL;
    nsdf_error found;
    nsdf_decoder_options_init(&options);
    options.check_all = 1;
    const nsdf_status status = nsdf_open_memory(&decoder, data, size, &options, &found);
    nsdf_close(&decoder);
    if (status == NSDF_OK)
        return NSDF_OK;
    return nsdf_encoder_fail(error, status, "%s%sbyte %llu: %s", found.chunk, found.chunk[0] ? ", " : "",
                             (unsigned long long)found.offset, found.message);
}

static int add_other(nsdf_mux *mux, const nsdf_chunk_header *h, uint32_t before, const uint8_t *payload) {
    nsdf_loose_chunk *grown = realloc(mux->others, ((size_t)mux->other_count + 1) * sizeof *grown);
    if (!grown)
        return -1;
    mux->others = grown;
    nsdf_loose_chunk *c = &grown[mux->other_count++];
    *c = (nsdf_loose_chunk){h->type, h->flags, before, {NULL, 0, 0, 0}};
    nsdf_buffer_append(&c->payload, payload, (size_t)h->length);
    return c->payload.failed ? -1 : 0;
}

static int read_index(nsdf_mux *mux, const uint8_t *payload, size_t size) {
    uint64_t file_size;
    const uint32_t count = mux->header.segment_count;
    mux->header.segment_count = 0; /* grows with the segments */
    mux->entries = malloc(count * sizeof *mux->entries);
    mux->payloads = calloc(count, sizeof *mux->payloads);
    if (!mux->entries || !mux->payloads)
        return -1;
    nsdf_file_header whole = mux->header;
    whole.segment_count = count;
    return nsdf_read_index(payload, size, &whole, mux->entries, &file_size, NULL) == NSDF_PARSE_OK ? 0 : -1;
}

/* One chunk of a file that the decoder found sound.  Returns 0, or -1 when memory ran out. */
static int read_chunk(nsdf_mux *mux, const nsdf_chunk_header *h, const uint8_t *payload) {
    const size_t size = (size_t)h->length;
    switch (h->type) {
    case NSDF_CHUNK_HEAD:
        return nsdf_read_header(payload, size, &mux->header, NULL) == NSDF_PARSE_OK ? 0 : -1;
    case NSDF_CHUNK_INDX:
        return read_index(mux, payload, size);
    case NSDF_CHUNK_QUAL:
        mux->has_quality = 1;
        return nsdf_read_quality(payload, size, &mux->quality, NULL) == NSDF_PARSE_OK ? 0 : -1;
    case NSDF_CHUNK_META:
        mux->has_metadata = 1;
        nsdf_buffer_append(&mux->metadata, payload, size);
        return mux->metadata.failed ? -1 : 0;
    case NSDF_CHUNK_SEGM: {
        nsdf_buffer *segment = &mux->payloads[mux->header.segment_count++];
        nsdf_buffer_append(segment, payload, size);
        return segment->failed ? -1 : 0;
    }
    case NSDF_CHUNK_ENDF:
        return 0;
    default:
        return add_other(mux, h, mux->header.segment_count, payload);
    }
}

nsdf_status nsdf_mux_read(nsdf_mux *mux, const uint8_t *data, size_t size, nsdf_encoder_error *error) {
    const nsdf_status status = check_file(data, size, error);
    if (status != NSDF_OK)
        return status;
    for (size_t at = NSDF_PREAMBLE_SIZE; at < size;) {
        nsdf_chunk_header h;
        if (nsdf_read_chunk_header(data + at, size - at, &h, NULL) != NSDF_PARSE_OK ||
            read_chunk(mux, &h, data + at + NSDF_CHUNK_HEADER_SIZE) != 0)
            return nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory");
        at += (size_t)h.length + NSDF_CHUNK_OVERHEAD;
    }
    return NSDF_OK;
}
