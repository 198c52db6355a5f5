/* Loading segments: bytes -> parameters -> networks without weights yet. */
#include "blocks_read.h"
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

const nsdf_tensor_list *nsdf_segment_tensors(const nsdf_segment_part *part) {
    return part->kind == NSDF_PART_BLOCKS ? &part->desc.blocks.list : &part->desc.network.list;
}

static nsdf_status take_bytes(nsdf_memory *memory, uint64_t size, void **out, const part_place *place,
                              nsdf_error *error) {
    nsdf_status status = nsdf_memory_take(memory, size, out);
    return status == NSDF_OK ? status : nsdf_fail_memory(error, status, NSDF_CHUNK_SEGM, place->offset, size);
}

static nsdf_status read_values(const part_place *place, size_t coded, nsdf_memory *memory, nsdf_segment_part *part,
                               nsdf_error *error) {
    codec_account account = {memory, NSDF_OK};
    const nsdf_codec_memory hooks = {&account, codec_allocate, codec_release};
    const nsdf_tensor_list *list = nsdf_segment_tensors(part);
    const size_t scratch_size = nsdf_parameter_scratch_size(list);
    nsdf_fault fault = {0, NULL};
    void *scratch;
    nsdf_status status = nsdf_memory_take(memory, scratch_size, &scratch);
    if (status != NSDF_OK)
        return nsdf_fail_memory(error, status, NSDF_CHUNK_SEGM, place->offset, scratch_size);
    nsdf_parse parse =
        nsdf_read_parameters(place->ref->data, place->ref->size, coded, list, scratch, &hooks, part->values, &fault);
    nsdf_memory_give(memory, scratch);
    if (parse == NSDF_PARSE_NO_MEMORY && account.status == NSDF_LIMIT)
        return nsdf_fail(error, NSDF_LIMIT, NSDF_CHUNK_SEGM, place->offset,
                         "max_memory does not allow what decoding needs");
    return parse == NSDF_PARSE_OK ? NSDF_OK : nsdf_fail_parse(error, parse, NSDF_CHUNK_SEGM, place->offset, &fault);
}

static nsdf_parse read_desc(const part_place *place, nsdf_segment_part *part, size_t *coded, nsdf_fault *fault) {
    const nsdf_part_ref *ref = place->ref;
    part->kind = ref->kind;
    if (ref->kind == NSDF_PART_BLOCKS)
        return nsdf_read_blocks_desc(ref->data, ref->size, &part->desc.blocks, coded, fault);
    return nsdf_read_network_desc(ref->data, ref->size, &part->desc.network, coded, fault);
}

static nsdf_status make_network(const part_place *place, nsdf_memory *memory, nsdf_segment_part *part,
                                nsdf_error *error) {
    const uint64_t size = nsdf_network_storage(&part->desc.network) * sizeof(float);
    nsdf_status status = take_bytes(memory, size, &part->storage, place, error);
    if (status == NSDF_OK)
        nsdf_network_init(&part->at.network, &part->desc.network, part->storage);
    return status;
}

static nsdf_status make_blocks(const part_place *place, nsdf_memory *memory, nsdf_segment_part *part,
                               nsdf_error *error) {
    nsdf_fault fault = {0, NULL};
    nsdf_parse parse = nsdf_check_blocks(&part->desc.blocks, part->values, &fault);
    if (parse != NSDF_PARSE_OK)
        return nsdf_fail_parse(error, parse, NSDF_CHUNK_SEGM, place->offset, &fault);
    nsdf_status status = take_bytes(memory, nsdf_blocks_storage(&part->desc.blocks), &part->storage, place, error);
    if (status == NSDF_OK)
        nsdf_blocks_init(&part->at.blocks, &part->desc.blocks, part->values, part->storage);
    return status;
}

/* Parameters that a coder may make out of hardly any bytes: as many as this part of the memory limit holds, and these
 * bytes of them for each byte of the part.  Real parts have fewer than ten. */
enum { SMALL_PART_OF_LIMIT = 64, MOST_EXPANSION = 1024 };

/* A small file must not ask for all memory, nor for the time that it takes to fill it. */
static nsdf_status check_expansion(const part_place *place, const nsdf_memory *memory, uint64_t size,
                                   nsdf_error *error) {
    if (size <= memory->limit / SMALL_PART_OF_LIMIT ||
        size - memory->limit / SMALL_PART_OF_LIMIT <= (uint64_t)MOST_EXPANSION * place->ref->size)
        return NSDF_OK;
    return nsdf_fail(error, NSDF_LIMIT, NSDF_CHUNK_SEGM, place->offset,
                     "%llu bytes of parameters in a part of %llu bytes: more than max_memory / 64 and 1,024 for a byte",
                     (unsigned long long)size, (unsigned long long)place->ref->size);
}

static nsdf_status load_part(const part_place *place, nsdf_memory *memory, nsdf_segment_part *part, nsdf_error *error) {
    size_t coded = 0;
    nsdf_fault fault = {0, NULL};
    nsdf_parse parse = read_desc(place, part, &coded, &fault);
    if (parse != NSDF_PARSE_OK)
        return nsdf_fail_parse(error, parse, NSDF_CHUNK_SEGM, place->offset, &fault);
    void *values = NULL;
    const uint64_t size = nsdf_parameter_count(nsdf_segment_tensors(part)) * sizeof(float);
    nsdf_status status = check_expansion(place, memory, size, error);
    if (status == NSDF_OK)
        status = take_bytes(memory, size, &values, place, error);
    part->values = values;
    if (status == NSDF_OK)
        status = read_values(place, coded, memory, part, error);
    if (status != NSDF_OK)
        return status;
    return part->kind == NSDF_PART_BLOCKS ? make_blocks(place, memory, part, error)
                                          : make_network(place, memory, part, error);
}

static nsdf_status check_hash(const nsdf_segment *segment, const nsdf_index_entry *entry, nsdf_error *error) {
    uint64_t hash = NSDF_HASH_START;
    for (uint32_t i = 0; i < segment->part_count; i++)
        hash = nsdf_hash_floats(hash, segment->parts[i].values,
                                (size_t)nsdf_parameter_count(nsdf_segment_tensors(&segment->parts[i])));
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
        status = load_part(&place, memory, &segment->parts[i], error);
        if (status == NSDF_OK)
            segment->parameter_count += nsdf_parameter_count(nsdf_segment_tensors(&segment->parts[i]));
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
    nsdf_status status = nsdf_stream_segment(stream, memory, index, &chunk, error);
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

void nsdf_segment_compose(nsdf_segment *segment, double u, nsdf_tasks *tasks) {
    if (segment->composed == u)
        return;
    for (uint32_t i = 0; i < segment->part_count; i++) {
        nsdf_segment_part *part = &segment->parts[i];
        if (part->kind == NSDF_PART_BLOCKS)
            nsdf_blocks_compose(&part->at.blocks, u, tasks);
        else
            nsdf_network_compose(&part->at.network, &part->desc.network, part->values, u);
    }
    segment->composed = u;
}

uint64_t nsdf_segment_scratch(const nsdf_segment *segment) {
    uint64_t most = 0;
    for (uint32_t i = 0; i < segment->part_count; i++) {
        const nsdf_segment_part *part = &segment->parts[i];
        const uint64_t size = part->kind == NSDF_PART_NETWORK ? nsdf_network_scratch(&part->at.network) : 0;
        most = size > most ? size : most;
    }
    return most;
}
