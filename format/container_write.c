#include <assert.h>
#include <string.h>

#include "container_write.h"

void nsdf_write_preamble(nsdf_buffer *b) {
    static const uint8_t start[12] = {
        0x89, 'N', 'S', 'D', 'F', 0x0d, 0x0a, 0x1a, 0x0a, NSDF_FORMAT_MAJOR, NSDF_FORMAT_MINOR, 0};
    nsdf_buffer_append(b, start, sizeof start);
    nsdf_buffer_u32(b, nsdf_crc32(0, start, sizeof start));
}

void nsdf_write_chunk(nsdf_buffer *b, uint32_t type, uint32_t flags, const void *payload, size_t size) {
    size_t start = b->size;
    nsdf_buffer_u32(b, type);
    nsdf_buffer_u32(b, flags);
    nsdf_buffer_u64(b, size);
    nsdf_buffer_append(b, payload, size);
    if (!b->failed)
        nsdf_buffer_u32(b, nsdf_crc32(0, b->data + start, b->size - start));
}

static void append_doubles(nsdf_buffer *b, const double *v, size_t count) {
    for (size_t i = 0; i < count; i++)
        nsdf_buffer_f64(b, v[i]);
}

void nsdf_write_header(nsdf_buffer *payload, const nsdf_file_header *header) {
    nsdf_buffer_u32(payload, header->rate_num);
    nsdf_buffer_u32(payload, header->rate_den);
    nsdf_buffer_u32(payload, header->frame_count);
    nsdf_buffer_u32(payload, header->segment_count);
    append_doubles(payload, header->box_min, 3);
    append_doubles(payload, header->box_max, 3);
    append_doubles(payload, header->centre, 3);
    nsdf_buffer_f64(payload, header->scale);
    for (int i = 0; i < 3; i++)
        nsdf_buffer_f32(payload, header->domain_min[i]);
    for (int i = 0; i < 3; i++)
        nsdf_buffer_f32(payload, header->domain_max[i]);
    nsdf_buffer_u32(payload, header->default_resolution);
    nsdf_buffer_f32(payload, header->extraction_bound);
}

void nsdf_write_quality(nsdf_buffer *payload, const nsdf_quality_record *quality) {
    append_doubles(payload, quality->mean, 2);
    append_doubles(payload, quality->rms, 2);
    append_doubles(payload, quality->max, 2);
    nsdf_buffer_u32(payload, quality->resolution);
    nsdf_buffer_u32(payload, quality->frames);
}

void nsdf_write_metadata(nsdf_buffer *payload, const char *key, const char *value) {
    size_t key_size = strlen(key), value_size = strlen(value);
    assert(key_size > 0 && key_size <= UINT16_MAX && value_size <= UINT32_MAX);
    nsdf_buffer_u16(payload, (uint16_t)key_size);
    nsdf_buffer_u32(payload, (uint32_t)value_size);
    nsdf_buffer_append(payload, key, key_size + 1);
    nsdf_buffer_append(payload, value, value_size + 1);
}

static void write_index(nsdf_buffer *payload, const nsdf_file_parts *parts, uint64_t file_size) {
    nsdf_buffer_u64(payload, file_size);
    for (uint32_t i = 0; i < parts->header.segment_count; i++) {
        const nsdf_index_entry *e = &parts->entries[i];
        nsdf_buffer_u32(payload, e->first_frame);
        nsdf_buffer_u32(payload, e->last_frame);
        nsdf_buffer_u32(payload, (uint32_t)e->lead);
        nsdf_buffer_u32(payload, (uint32_t)e->trail);
        nsdf_buffer_u32(payload, e->fade);
        nsdf_buffer_f32(payload, e->smallest_piece);
        nsdf_buffer_u64(payload, e->offset);
        nsdf_buffer_u64(payload, e->size);
        nsdf_buffer_u64(payload, e->parameter_hash);
    }
}

/* Bytes of the other chunks from *next on that stand in front of a segment; moves *next behind them. */
static uint64_t others_size(const nsdf_file_parts *parts, uint32_t segment, uint32_t *next) {
    uint64_t size = 0;
    for (; *next < parts->other_count && parts->others[*next].before <= segment; ++*next)
        size += parts->others[*next].payload.size + NSDF_CHUNK_OVERHEAD;
    return size;
}

static void write_others(nsdf_buffer *out, const nsdf_file_parts *parts, uint32_t segment, uint32_t *next) {
    for (; *next < parts->other_count && parts->others[*next].before <= segment; ++*next) {
        const nsdf_loose_chunk *other = &parts->others[*next];
        nsdf_write_chunk(out, other->type, other->flags, other->payload.data, other->payload.size);
        out->failed |= other->payload.failed;
    }
}

/* Fills in where the segments go, the first one at `offset`; returns the size of the file. */
static uint64_t place_segments(nsdf_file_parts *parts, uint64_t offset) {
    uint32_t other = 0;
    for (uint32_t i = 0; i < parts->header.segment_count; i++) {
        offset += others_size(parts, i, &other);
        parts->entries[i].offset = offset;
        parts->entries[i].size = parts->segments[i].size + NSDF_CHUNK_OVERHEAD;
        offset += parts->entries[i].size;
    }
    return offset + others_size(parts, parts->header.segment_count, &other) + NSDF_CHUNK_OVERHEAD;
}

/* The ancillary chunks between INDX and the first segment. */
static void write_notes(nsdf_buffer *out, const nsdf_file_parts *parts) {
    if (parts->quality) {
        nsdf_buffer payload = {0};
        nsdf_write_quality(&payload, parts->quality);
        nsdf_write_chunk(out, NSDF_CHUNK_QUAL, 0, payload.data, payload.size);
        out->failed |= payload.failed;
        nsdf_buffer_free(&payload);
    }
    if (parts->metadata) {
        nsdf_write_chunk(out, NSDF_CHUNK_META, 0, parts->metadata->data, parts->metadata->size);
        out->failed |= parts->metadata->failed;
    }
}

int nsdf_write_file(nsdf_buffer *out, nsdf_file_parts *parts) {
    nsdf_buffer notes = {0}, payload = {0};
    size_t index_size = (size_t)nsdf_index_payload_size(parts->header.segment_count);
    write_notes(&notes, parts);
    uint64_t front = NSDF_PREAMBLE_SIZE + NSDF_HEADER_PAYLOAD_SIZE + 2 * NSDF_CHUNK_OVERHEAD + index_size;
    uint64_t file_size = place_segments(parts, front + notes.size);

    nsdf_write_preamble(out);
    nsdf_write_header(&payload, &parts->header);
    nsdf_write_chunk(out, NSDF_CHUNK_HEAD, NSDF_CHUNK_CRITICAL, payload.data, payload.size);
    payload.size = 0;
    write_index(&payload, parts, file_size);
    nsdf_write_chunk(out, NSDF_CHUNK_INDX, NSDF_CHUNK_CRITICAL, payload.data, payload.size);
    nsdf_buffer_append(out, notes.data, notes.size);
    uint32_t other = 0;
    for (uint32_t i = 0; i < parts->header.segment_count; i++) {
        const nsdf_buffer *segment = &parts->segments[i];
        write_others(out, parts, i, &other);
        nsdf_write_chunk(out, NSDF_CHUNK_SEGM, NSDF_CHUNK_CRITICAL, segment->data, segment->size);
        out->failed |= segment->failed;
    }
    write_others(out, parts, parts->header.segment_count, &other);
    nsdf_write_chunk(out, NSDF_CHUNK_ENDF, NSDF_CHUNK_CRITICAL, NULL, 0);
    out->failed |= notes.failed | payload.failed;
    nsdf_buffer_free(&notes);
    nsdf_buffer_free(&payload);
    return out->failed ? -1 : 0;
}
