/* The container as a stream of chunks: every length is checked against the file's size before anything is allocated
 * or read. */
#include "stream.h"
#include "status.h"

#include <string.h>

enum { CHECK_BLOCK = 1 << 16 };

/* Unlike in PNG the letters of a type have no meaning of their own: the flag decides. */
static int is_critical(const nsdf_chunk_header *header) {
    return (header->flags & NSDF_CHUNK_CRITICAL) != 0;
}

static nsdf_status fail_unknown(const nsdf_chunk_header *header, uint64_t offset, nsdf_error *error) {
    return nsdf_fail(error, NSDF_UNSUPPORTED_FEATURE, header->type, offset,
                     "unknown critical chunk: a newer decoder is needed");
}

static nsdf_status fail_misplaced(const nsdf_chunk_header *header, uint64_t offset, nsdf_error *error) {
    return nsdf_fail(error, NSDF_CORRUPT, header->type, offset, "a chunk of this type may not be here");
}

/* NSDF_TRUNCATED unless `size` bytes from `offset` on lie in the file. */
static nsdf_status expect_bytes(const nsdf_stream *stream, uint32_t type, uint64_t offset, uint64_t size,
                                nsdf_error *error) {
    const uint64_t end = stream->source.io.size;
    if (offset <= end && size <= end - offset)
        return NSDF_OK;
    return nsdf_fail(error, NSDF_TRUNCATED, type, end, "file ends at byte %llu, expected at least %llu bytes",
                     (unsigned long long)end, (unsigned long long)(offset + size));
}

/* Reads the header of the chunk at `offset`; the whole chunk lies in the file. */
static nsdf_status read_chunk_header(const nsdf_stream *stream, uint64_t offset, nsdf_chunk_header *header,
                                     nsdf_error *error) {
    uint8_t bytes[NSDF_CHUNK_HEADER_SIZE];
    nsdf_fault fault = {0, NULL};
    nsdf_status status = expect_bytes(stream, 0, offset, NSDF_CHUNK_OVERHEAD, error);
    if (status == NSDF_OK)
        status = nsdf_source_read(&stream->source, offset, bytes, sizeof bytes, error);
    if (status != NSDF_OK)
        return status;
    nsdf_parse parse = nsdf_read_chunk_header(bytes, sizeof bytes, header, &fault);
    if (parse != NSDF_PARSE_OK)
        return nsdf_fail_parse(error, parse, 0, offset, &fault);
    return expect_bytes(stream, header->type, offset, header->length + NSDF_CHUNK_OVERHEAD, error);
}

static nsdf_status read_body(const nsdf_stream *stream, nsdf_memory *memory, uint64_t offset, nsdf_chunk *chunk,
                             nsdf_error *error) {
    const uint64_t size = chunk->header.length + NSDF_CHUNK_OVERHEAD;
    const uint8_t *bytes = stream->source.memory ? stream->source.memory + offset : NULL;
    nsdf_fault fault = {0, NULL};
    if (!bytes) {
        nsdf_status status = nsdf_memory_take(memory, size, &chunk->owned);
        if (status != NSDF_OK)
            return nsdf_fail_memory(error, status, chunk->header.type, offset, size);
        status = nsdf_source_read(&stream->source, offset, chunk->owned, (size_t)size, error);
        if (status != NSDF_OK)
            return status;
        bytes = chunk->owned;
    }
    nsdf_parse parse = nsdf_check_chunk(bytes, &chunk->header, &fault);
    chunk->payload = bytes + NSDF_CHUNK_HEADER_SIZE;
    return parse == NSDF_PARSE_OK ? NSDF_OK : nsdf_fail_parse(error, parse, chunk->header.type, offset, &fault);
}

nsdf_status nsdf_stream_chunk(const nsdf_stream *stream, nsdf_memory *memory, uint64_t offset, nsdf_chunk *chunk,
                              nsdf_error *error) {
    nsdf_chunk read = {.owned = NULL};
    nsdf_status status = read_chunk_header(stream, offset, &read.header, error);
    if (status == NSDF_OK)
        status = read_body(stream, memory, offset, &read, error);
    if (status != NSDF_OK) {
        nsdf_chunk_free(memory, &read);
        return status;
    }
    *chunk = read;
    return NSDF_OK;
}

/* In one read, when the chunk's own header agrees; else its bytes are of no use. */
static nsdf_status read_segment(const nsdf_stream *stream, nsdf_memory *memory, const nsdf_index_entry *entry,
                                nsdf_chunk *chunk, nsdf_error *error) {
    nsdf_fault fault = {0, NULL};
    nsdf_status status = nsdf_memory_take(memory, entry->size, &chunk->owned);
    if (status != NSDF_OK)
        return nsdf_fail_memory(error, status, NSDF_CHUNK_SEGM, entry->offset, entry->size);
    status = nsdf_source_read(&stream->source, entry->offset, chunk->owned, (size_t)entry->size, error);
    if (status != NSDF_OK)
        return status;
    const uint8_t *bytes = chunk->owned;
    if (nsdf_read_chunk_header(bytes, NSDF_CHUNK_HEADER_SIZE, &chunk->header, &fault) != NSDF_PARSE_OK ||
        chunk->header.type != NSDF_CHUNK_SEGM || chunk->header.length + NSDF_CHUNK_OVERHEAD != entry->size) {
        nsdf_chunk_free(memory, chunk);
        return NSDF_OK;
    }
    chunk->payload = bytes + NSDF_CHUNK_HEADER_SIZE;
    const nsdf_parse parse = nsdf_check_chunk(bytes, &chunk->header, &fault);
    return parse == NSDF_PARSE_OK ? NSDF_OK : nsdf_fail_parse(error, parse, NSDF_CHUNK_SEGM, entry->offset, &fault);
}

nsdf_status nsdf_stream_segment(const nsdf_stream *stream, nsdf_memory *memory, uint32_t index, nsdf_chunk *chunk,
                                nsdf_error *error) {
    const nsdf_index_entry *entry = &stream->entries[index];
    nsdf_chunk read = {.owned = NULL};
    nsdf_status status = NSDF_OK;
    if (!stream->source.memory)
        status = read_segment(stream, memory, entry, &read, error);
    if (status == NSDF_OK && !read.owned)
        return nsdf_stream_chunk(stream, memory, entry->offset, chunk, error);
    if (status == NSDF_OK)
        *chunk = read;
    else
        nsdf_chunk_free(memory, &read);
    return status;
}

void nsdf_chunk_free(nsdf_memory *memory, nsdf_chunk *chunk) {
    nsdf_memory_give(memory, chunk->owned);
    memset(chunk, 0, sizeof *chunk);
}

static nsdf_status read_preamble(nsdf_stream *stream, nsdf_error *error) {
    uint8_t bytes[NSDF_PREAMBLE_SIZE];
    nsdf_fault fault = {0, NULL};
    const uint64_t end = stream->source.io.size;
    const size_t size = end < sizeof bytes ? (size_t)end : sizeof bytes;
    nsdf_status status = nsdf_source_read(&stream->source, 0, bytes, size, error);
    if (status != NSDF_OK)
        return status;
    nsdf_parse parse = nsdf_read_preamble(bytes, size, &stream->version, &fault);
    if (parse == NSDF_PARSE_TRUNCATED)
        return expect_bytes(stream, 0, 0, sizeof bytes, error);
    if (parse == NSDF_PARSE_VERSION)
        return nsdf_fail(error, NSDF_UNSUPPORTED_VERSION, 0, fault.offset,
                         "the file is of bitstream %u.%u, this library reads %u.%u", stream->version.major,
                         stream->version.minor, NSDF_FORMAT_MAJOR, NSDF_FORMAT_MINOR);
    return parse == NSDF_PARSE_OK ? NSDF_OK : nsdf_fail_parse(error, parse, 0, 0, &fault);
}

/* Reads the chunk at `offset`, which must be of this type and hold at least `least` bytes; later versions may add. */
static nsdf_status read_fixed_chunk(const nsdf_stream *stream, nsdf_memory *memory, uint64_t offset, uint32_t type,
                                    uint64_t least, nsdf_chunk *chunk, nsdf_error *error) {
    char name[8];
    nsdf_chunk_name(type, name);
    nsdf_status status = read_chunk_header(stream, offset, &chunk->header, error);
    if (status != NSDF_OK)
        return status;
    if (chunk->header.type != type)
        return nsdf_fail(error, NSDF_CORRUPT, chunk->header.type, offset, "found another chunk where %s must be", name);
    if (chunk->header.length < least)
        return nsdf_fail(error, NSDF_CORRUPT, type, offset + 8, "%s holds %llu bytes, expected at least %llu", name,
                         (unsigned long long)chunk->header.length, (unsigned long long)least);
    return read_body(stream, memory, offset, chunk, error);
}

static nsdf_status read_head(nsdf_stream *stream, nsdf_memory *memory, nsdf_error *error) {
    nsdf_chunk chunk = {.owned = NULL};
    nsdf_fault fault = {0, NULL};
    const uint64_t at = NSDF_PREAMBLE_SIZE;
    nsdf_status status = read_fixed_chunk(stream, memory, at, NSDF_CHUNK_HEAD, NSDF_HEADER_PAYLOAD_SIZE, &chunk, error);
    if (status == NSDF_OK) {
        nsdf_parse parse = nsdf_read_header(chunk.payload, (size_t)chunk.header.length, &stream->header, &fault);
        if (parse != NSDF_PARSE_OK)
            status = nsdf_fail_parse(error, parse, NSDF_CHUNK_HEAD, at + NSDF_CHUNK_HEADER_SIZE, &fault);
    }
    stream->rest = at + chunk.header.length + NSDF_CHUNK_OVERHEAD;
    nsdf_chunk_free(memory, &chunk);
    return status;
}

static nsdf_status check_file_size(const nsdf_stream *stream, uint64_t expected, nsdf_error *error) {
    const uint64_t size = stream->source.io.size;
    if (size < expected)
        return nsdf_fail(error, NSDF_TRUNCATED, 0, size, "file ends at byte %llu, expected %llu bytes",
                         (unsigned long long)size, (unsigned long long)expected);
    if (size > expected)
        return nsdf_fail(error, NSDF_CORRUPT, 0, expected, "%llu bytes after the end, expected a file of %llu bytes",
                         (unsigned long long)(size - expected), (unsigned long long)expected);
    return NSDF_OK;
}

static nsdf_status parse_index(nsdf_stream *stream, nsdf_memory *memory, const nsdf_chunk *chunk, uint64_t at,
                               nsdf_error *error) {
    const uint64_t size = (uint64_t)stream->header.segment_count * sizeof *stream->entries;
    nsdf_fault fault = {0, NULL};
    uint64_t file_size = 0;
    void *entries;
    nsdf_status status = nsdf_memory_take(memory, size, &entries);
    if (status != NSDF_OK)
        return nsdf_fail_memory(error, status, NSDF_CHUNK_INDX, at, size);
    stream->entries = entries;
    nsdf_parse parse = nsdf_read_index(chunk->payload, (size_t)chunk->header.length, &stream->header, stream->entries,
                                       &file_size, &fault);
    if (parse != NSDF_PARSE_OK)
        return nsdf_fail_parse(error, parse, NSDF_CHUNK_INDX, at + NSDF_CHUNK_HEADER_SIZE, &fault);
    return check_file_size(stream, file_size, error);
}

static nsdf_status read_index(nsdf_stream *stream, nsdf_memory *memory, nsdf_error *error) {
    nsdf_chunk chunk = {.owned = NULL};
    const uint64_t at = stream->rest;
    nsdf_status status = read_fixed_chunk(stream, memory, at, NSDF_CHUNK_INDX,
                                          nsdf_index_payload_size(stream->header.segment_count), &chunk, error);
    if (status == NSDF_OK)
        status = parse_index(stream, memory, &chunk, at, error);
    stream->rest = at + chunk.header.length + NSDF_CHUNK_OVERHEAD;
    nsdf_chunk_free(memory, &chunk);
    return status;
}

static nsdf_status read_quality(nsdf_stream *stream, nsdf_memory *memory, uint64_t offset, nsdf_error *error) {
    nsdf_chunk chunk;
    nsdf_fault fault = {0, NULL};
    nsdf_status status = nsdf_stream_chunk(stream, memory, offset, &chunk, error);
    if (status != NSDF_OK)
        return status;
    nsdf_parse parse = nsdf_read_quality(chunk.payload, (size_t)chunk.header.length, &stream->quality, &fault);
    if (parse != NSDF_PARSE_OK)
        status = nsdf_fail_parse(error, parse, NSDF_CHUNK_QUAL, offset + NSDF_CHUNK_HEADER_SIZE, &fault);
    stream->has_quality = 1;
    nsdf_chunk_free(memory, &chunk);
    return status;
}

/* Walks over the pairs; stores them when `strings` is not NULL. */
static nsdf_status walk_metadata(const nsdf_chunk *chunk, uint64_t offset, const char **strings, uint32_t *count,
                                 nsdf_error *error) {
    size_t cursor = 0;
    for (*count = 0;; ++*count) {
        const char *key = NULL, *value = NULL;
        nsdf_fault fault = {0, NULL};
        nsdf_parse parse =
            nsdf_read_metadata(chunk->payload, (size_t)chunk->header.length, &cursor, &key, &value, &fault);
        if (parse != NSDF_PARSE_OK)
            return nsdf_fail_parse(error, parse, NSDF_CHUNK_META, offset + NSDF_CHUNK_HEADER_SIZE, &fault);
        if (!key)
            return NSDF_OK;
        if (*count == UINT32_MAX / 2)
            return nsdf_fail(error, NSDF_LIMIT, NSDF_CHUNK_META, offset, "more than 2^31 pairs of metadata");
        if (strings) {
            strings[2 * (size_t)*count] = key;
            strings[2 * (size_t)*count + 1] = value;
        }
    }
}

static nsdf_status read_metadata(nsdf_stream *stream, nsdf_memory *memory, uint64_t offset, nsdf_error *error) {
    uint32_t count;
    void *strings;
    nsdf_status status = nsdf_stream_chunk(stream, memory, offset, &stream->metadata, error);
    if (status == NSDF_OK)
        status = walk_metadata(&stream->metadata, offset, NULL, &count, error);
    if (status != NSDF_OK)
        return status;
    const uint64_t size = 2 * (uint64_t)count * sizeof *stream->strings;
    status = nsdf_memory_take(memory, size, &strings);
    if (status != NSDF_OK)
        return nsdf_fail_memory(error, status, NSDF_CHUNK_META, offset, size);
    stream->strings = strings;
    stream->has_metadata = 1;
    return walk_metadata(&stream->metadata, offset, stream->strings, &stream->pair_count, error);
}

static nsdf_status read_front_chunk(nsdf_stream *stream, nsdf_memory *memory, uint64_t offset,
                                    const nsdf_chunk_header *header, nsdf_error *error) {
    switch (header->type) {
    case NSDF_CHUNK_QUAL:
        return stream->has_quality ? fail_misplaced(header, offset, error)
                                   : read_quality(stream, memory, offset, error);
    case NSDF_CHUNK_META:
        return stream->has_metadata ? fail_misplaced(header, offset, error)
                                    : read_metadata(stream, memory, offset, error);
    case NSDF_CHUNK_HEAD:
    case NSDF_CHUNK_INDX:
    case NSDF_CHUNK_SEGM:
    case NSDF_CHUNK_ENDF:
        return fail_misplaced(header, offset, error);
    default:
        return is_critical(header) ? fail_unknown(header, offset, error) : NSDF_OK;
    }
}

/* The chunks between INDX and the first segment. */
static nsdf_status read_front(nsdf_stream *stream, nsdf_memory *memory, nsdf_error *error) {
    const uint64_t end = stream->entries[0].offset;
    uint64_t offset = stream->rest;
    while (offset < end) {
        nsdf_chunk_header header;
        nsdf_status status = read_chunk_header(stream, offset, &header, error);
        if (status == NSDF_OK)
            status = read_front_chunk(stream, memory, offset, &header, error);
        if (status != NSDF_OK)
            return status;
        offset += header.length + NSDF_CHUNK_OVERHEAD;
    }
    if (offset == end)
        return NSDF_OK;
    return nsdf_fail(error, NSDF_CORRUPT, NSDF_CHUNK_INDX, offset,
                     "chunks end at byte %llu, the index has the first segment at byte %llu",
                     (unsigned long long)offset, (unsigned long long)end);
}

nsdf_status nsdf_stream_open(nsdf_stream *stream, nsdf_memory *memory, nsdf_error *error) {
    nsdf_status status = read_preamble(stream, error);
    if (status == NSDF_OK)
        status = read_head(stream, memory, error);
    if (status == NSDF_OK)
        status = read_index(stream, memory, error);
    if (status == NSDF_OK)
        status = read_front(stream, memory, error);
    return status;
}

void nsdf_stream_close(nsdf_stream *stream, nsdf_memory *memory) {
    nsdf_memory_give(memory, stream->entries);
    nsdf_memory_give(memory, (void *)stream->strings);
    nsdf_chunk_free(memory, &stream->metadata);
    nsdf_source_close(&stream->source);
    memset(stream, 0, sizeof *stream);
}

/* Compares the CRC-32 behind a chunk with that of its bytes, block by block. */
static nsdf_status check_crc(const nsdf_stream *stream, uint64_t offset, const nsdf_chunk_header *header,
                             uint8_t *block, nsdf_error *error) {
    uint64_t at = offset, left = header->length + NSDF_CHUNK_HEADER_SIZE;
    uint32_t crc = 0;
    while (left > 0) {
        const size_t size = left < CHECK_BLOCK ? (size_t)left : CHECK_BLOCK;
        nsdf_status status = nsdf_source_read(&stream->source, at, block, size, error);
        if (status != NSDF_OK)
            return status;
        crc = nsdf_crc32(crc, block, size);
        at += size;
        left -= size;
    }
    uint8_t end[4];
    nsdf_status status = nsdf_source_read(&stream->source, at, end, sizeof end, error);
    if (status != NSDF_OK)
        return status;
    const uint32_t stored = end[0] | (uint32_t)end[1] << 8 | (uint32_t)end[2] << 16 | (uint32_t)end[3] << 24;
    if (stored == crc)
        return NSDF_OK;
    return nsdf_fail(error, NSDF_CHECKSUM, header->type, at, "CRC-32 is %08lx, expected %08lx", (unsigned long)stored,
                     (unsigned long)crc);
}

/* Whether a chunk behind INDX is where the index and the format want it; counts the segments met. */
static nsdf_status check_place(const nsdf_stream *stream, uint64_t offset, const nsdf_chunk_header *header,
                               uint32_t *segments, nsdf_error *error) {
    const nsdf_index_entry *next = *segments < stream->header.segment_count ? &stream->entries[*segments] : NULL;
    switch (header->type) {
    case NSDF_CHUNK_SEGM:
        if (!next || next->offset != offset || next->size != header->length + NSDF_CHUNK_OVERHEAD)
            return nsdf_fail(error, NSDF_CORRUPT, header->type, offset, "a segment that is not in the index");
        ++*segments;
        return NSDF_OK;
    case NSDF_CHUNK_HEAD:
    case NSDF_CHUNK_INDX:
        return fail_misplaced(header, offset, error);
    case NSDF_CHUNK_ENDF:
        if (next)
            return nsdf_fail(error, NSDF_CORRUPT, header->type, offset, "the file's end before its last segment");
        if (header->length != 0)
            return nsdf_fail(error, NSDF_CORRUPT, header->type, offset + 8, "ENDF holds %llu bytes, expected none",
                             (unsigned long long)header->length);
        return NSDF_OK;
    case NSDF_CHUNK_QUAL:
    case NSDF_CHUNK_META:
        return *segments > 0 ? fail_misplaced(header, offset, error) : NSDF_OK;
    default:
        return is_critical(header) ? fail_unknown(header, offset, error) : NSDF_OK;
    }
}

static nsdf_status check_chunks(const nsdf_stream *stream, uint8_t *block, nsdf_error *error) {
    const uint64_t end = stream->source.io.size;
    uint64_t offset = stream->rest;
    uint32_t segments = 0;
    nsdf_chunk_header header = {.type = 0};
    while (offset < end && header.type != NSDF_CHUNK_ENDF) {
        nsdf_status status = read_chunk_header(stream, offset, &header, error);
        if (status == NSDF_OK)
            status = check_crc(stream, offset, &header, block, error);
        if (status == NSDF_OK)
            status = check_place(stream, offset, &header, &segments, error);
        if (status != NSDF_OK)
            return status;
        offset += header.length + NSDF_CHUNK_OVERHEAD;
    }
    if (header.type != NSDF_CHUNK_ENDF)
        return nsdf_fail(error, NSDF_TRUNCATED, NSDF_CHUNK_ENDF, end, "file ends at byte %llu without its ENDF chunk",
                         (unsigned long long)end);
    if (offset < end)
        return nsdf_fail(error, NSDF_CORRUPT, NSDF_CHUNK_ENDF, offset, "%llu bytes after the end",
                         (unsigned long long)(end - offset));
    return NSDF_OK;
}

nsdf_status nsdf_stream_check_all(const nsdf_stream *stream, nsdf_memory *memory, nsdf_error *error) {
    void *block;
    nsdf_status status = nsdf_memory_take(memory, CHECK_BLOCK, &block);
    if (status != NSDF_OK)
        return nsdf_fail_memory(error, status, 0, 0, CHECK_BLOCK);
    status = check_chunks(stream, block, error);
    nsdf_memory_give(memory, block);
    return status;
}
