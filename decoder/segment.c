/* Loading segments: bytes -> parameters -> networks without weights yet. */
#include "segment.h"
#include "status.h"

#include <string.h>

/* The account as the entropy back ends see it; remembers why it gave nothing. */
typedef struct codec_account {
    nsdf_memory *memory;
    nsdf_status status;
} codec_account;

static void *codec_allocate(void *user, size_t size) {
    codec_account *account = user;
    void *block = NULL;
    nsdf_status status = nsdf_memory_take(account->memory, size, &block);
    if (status != NSDF_OK)
        account->status = status;
    return block;
}

static void codec_release(void *user, void *pointer) {
    const codec_account *account = user;
    nsdf_memory_give(account->memory, pointer);
}

/* Where a part lies, for error messages. */
typedef struct part_place {
    const nsdf_part_ref *ref;
    uint64_t offset; /* in the file */
} part_place;

static nsdf_status take_floats(nsdf_memory *memory, uint64_t count, float **out, const part_place *place,
                               nsdf_error *error) {
    void *block;
    nsdf_status status = nsdf_memory_take(memory, count * sizeof **out, &block);
    if (status != NSDF_OK)
        return nsdf_fail_memory(error, status, NSDF_CHUNK_SEGM, place->offset, count * sizeof **out);
    *out = block;
    return NSDF_OK;
}

static nsdf_status read_values(const part_place *place, size_t coded, nsdf_memory *memory, nsdf_segment_part *part,
                               nsdf_error *error) {
    codec_account account = {memory, NSDF_OK};
    const nsdf_codec_memory hooks = {&account, codec_allocate, codec_release};
    const size_t scratch_size = nsdf_parameter_scratch_size(&part->desc);
    nsdf_fault fault = {0, NULL};
    void *scratch;
    nsdf_status status = nsdf_memory_take(memory, scratch_size, &scratch);
    if (status != NSDF_OK)
        return nsdf_fail_memory(error, status, NSDF_CHUNK_SEGM, place->offset, scratch_size);
    nsdf_parse parse = nsdf_read_parameters(place->ref->data, place->ref->size, coded, &part->desc, scratch, &hooks,
                                            part->values, &fault);
    nsdf_memory_give(memory, scratch);
    if (parse == NSDF_PARSE_NO_MEMORY && account.status == NSDF_LIMIT)
        return nsdf_fail(error, NSDF_LIMIT, NSDF_CHUNK_SEGM, place->offset,
                         "max_memory does not allow what decoding needs");
    return parse == NSDF_PARSE_OK ? NSDF_OK : nsdf_fail_parse(error, parse, NSDF_CHUNK_SEGM, place->offset, &fault);
}

static nsdf_status load_part(const part_place *place, nsdf_memory *memory, nsdf_segment_part *part, nsdf_error *error) {
    size_t coded = 0;
    nsdf_fault fault = {0, NULL};
    nsdf_parse parse = nsdf_read_network_desc(place->ref->data, place->ref->size, &part->desc, &coded, &fault);
    if (parse != NSDF_PARSE_OK)
        return nsdf_fail_parse(error, parse, NSDF_CHUNK_SEGM, place->offset, &fault);
    nsdf_status status = take_floats(memory, nsdf_parameter_count(&part->desc), &part->values, place, error);
    if (status == NSDF_OK)
        status = read_values(place, coded, memory, part, error);
    if (status == NSDF_OK)
        status = take_floats(memory, nsdf_network_storage(&part->desc), &part->storage, place, error);
    if (status == NSDF_OK)
        nsdf_network_init(&part->network, &part->desc, part->storage);
    return status;
}

static nsdf_status check_hash(const nsdf_segment *segment, const nsdf_index_entry *entry, nsdf_error *error) {
    uint64_t hash = NSDF_HASH_START;
    for (uint32_t i = 0; i < segment->part_count; i++)
        hash = nsdf_hash_floats(hash, segment->parts[i].values, (size_t)nsdf_parameter_count(&segment->parts[i].desc));
    if (hash == entry->parameter_hash)
        return NSDF_OK;
    return nsdf_fail(error, NSDF_CHECKSUM, NSDF_CHUNK_SEGM, entry->offset,
                     "hash of the parameters is %016llx, expected %016llx", (unsigned long long)hash,
                     (unsigned long long)entry->parameter_hash);
}

static nsdf_status take_parts(nsdf_memory *memory, uint32_t count, uint64_t offset, nsdf_segment *segment,
                              nsdf_error *error) {
    const size_t size = count * sizeof *segment->parts;
    void *parts;
    nsdf_status status = nsdf_memory_take(memory, size, &parts);
    if (status != NSDF_OK)
        return nsdf_fail_memory(error, status, NSDF_CHUNK_SEGM, offset, size);
    if (size > 0)
        memset(parts, 0, size);
    segment->parts = parts;
    segment->part_count = count;
    return NSDF_OK;
}

static nsdf_status load_parts(const nsdf_chunk *chunk, const nsdf_index_entry *entry, nsdf_memory *memory,
                              nsdf_segment *segment, nsdf_error *error) {
    const uint64_t base = entry->offset + NSDF_CHUNK_HEADER_SIZE;
    nsdf_part_ref refs[NSDF_MAX_PARTS];
    nsdf_fault fault = {0, NULL};
    uint32_t count = 0;
    nsdf_parse parse = nsdf_read_parts(chunk->payload, (size_t)chunk->header.length, refs, &count, &fault);
    if (parse != NSDF_PARSE_OK)
        return nsdf_fail_parse(error, parse, NSDF_CHUNK_SEGM, base, &fault);
    nsdf_status status = take_parts(memory, count, base, segment, error);
    for (uint32_t i = 0; status == NSDF_OK && i < count; i++) {
        const part_place place = {&refs[i], base + (uint64_t)(refs[i].data - chunk->payload)};
        if (refs[i].kind == NSDF_PART_NETWORK)
            status = load_part(&place, memory, &segment->parts[i], error);
        else
            status = nsdf_fail(error, NSDF_UNSUPPORTED_FEATURE, NSDF_CHUNK_SEGM, place.offset,
                               "a part of kind %lu: a newer decoder is needed", (unsigned long)refs[i].kind);
        if (status == NSDF_OK)
            segment->parameter_count += nsdf_parameter_count(&segment->parts[i].desc);
    }
    return status == NSDF_OK ? check_hash(segment, entry, error) : status;
}

static nsdf_status check_chunk(const nsdf_chunk *chunk, const nsdf_index_entry *entry, nsdf_error *error) {
    if (chunk->header.type != NSDF_CHUNK_SEGM)
        return nsdf_fail(error, NSDF_CORRUPT, chunk->header.type, entry->offset,
                         "found another chunk where the index has a segment");
    if (chunk->header.length + NSDF_CHUNK_OVERHEAD != entry->size)
        return nsdf_fail(
            error, NSDF_CORRUPT, NSDF_CHUNK_SEGM, entry->offset + 8, "the chunk is %llu bytes long, expected %llu",
            (unsigned long long)(chunk->header.length + NSDF_CHUNK_OVERHEAD), (unsigned long long)entry->size);
    return NSDF_OK;
}

nsdf_status nsdf_segment_load(const nsdf_stream *stream, uint32_t index, nsdf_memory *memory, nsdf_segment *segment,
                              nsdf_error *error) {
    const nsdf_index_entry *entry = &stream->entries[index];
    nsdf_segment loaded = {.composed = -1.0};
    nsdf_chunk chunk;
    nsdf_status status = nsdf_stream_chunk(stream, memory, entry->offset, &chunk, error);
    if (status != NSDF_OK)
        return status;
    status = check_chunk(&chunk, entry, error);
    if (status == NSDF_OK)
        status = load_parts(&chunk, entry, memory, &loaded, error);
    nsdf_chunk_free(memory, &chunk);
    if (status == NSDF_OK)
        *segment = loaded;
    else
        nsdf_segment_free(memory, &loaded);
    return status;
}

void nsdf_segment_free(nsdf_memory *memory, nsdf_segment *segment) {
    for (uint32_t i = 0; i < segment->part_count; i++) {
        nsdf_memory_give(memory, segment->parts[i].values);
        nsdf_memory_give(memory, segment->parts[i].storage);
    }
    nsdf_memory_give(memory, segment->parts);
    memset(segment, 0, sizeof *segment);
}

void nsdf_segment_compose(nsdf_segment *segment, double u) {
    if (segment->composed == u)
        return;
    for (uint32_t i = 0; i < segment->part_count; i++)
        nsdf_network_compose(&segment->parts[i].network, &segment->parts[i].desc, segment->parts[i].values, u);
    segment->composed = u;
}

uint64_t nsdf_segment_scratch(const nsdf_segment *segment) {
    uint64_t most = 0;
    for (uint32_t i = 0; i < segment->part_count; i++) {
        const uint64_t size = nsdf_network_scratch(&segment->parts[i].network);
        most = size > most ? size : most;
    }
    return most;
}
