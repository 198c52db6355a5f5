/* Codes the parameters of a file anew, for comparison: bench_recode FILE.nsdf OUT BACK_END [BITS].
 *
 * BACK_END is none, deflate, zstd or range.  Without BITS the integers stay the same, and so does the surface; with
 * BITS all arrays but numbers of bones and lives are quantised uniformly from their least to their largest value, with
 * 2^BITS - 1 steps, as the thesis does it.  Prints the bytes.
 *
 * BACK_END may also be integers: OUT then is no .nsdf file but what is left when nothing of the format is used, for any
 * compressor: of each array its integers less the least of them, in as few bytes as hold the largest, all low bytes
 * first. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "blocks_write.h"
#include "network_write.h"
#include "segment.h"

static void stop(const char *what) {
    fprintf(stderr, "bench_recode: %s\n", what);
    exit(EXIT_FAILURE);
}

/* How to code. */
typedef struct {
    nsdf_entropy_kind kind;
    int bits;
    nsdf_buffer *integers; /* gets them, or NULL */
} recoding;

static nsdf_entropy_kind back_end_of(const char *name) {
    static const char *const names[] = {"none", "deflate", "zstd", "range"};
    static const nsdf_entropy_kind kinds[] = {NSDF_ENTROPY_NONE, NSDF_ENTROPY_DEFLATE, NSDF_ENTROPY_ZSTD,
                                              NSDF_ENTROPY_RANGE};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (strcmp(name, names[i]) == 0)
            return kinds[i];
    stop("the back end is not none, deflate, zstd or range");
    return NSDF_ENTROPY_NONE;
}

/* Numbers of bones are whole, lives end exactly where they do. */
static int is_exact(const nsdf_segment_part *part, uint32_t tensor) {
    return part->kind == NSDF_PART_BLOCKS && (tensor == NSDF_BLOCK_BONES || tensor == NSDF_BLOCK_LIVES);
}

/* Quantises one array, and sets its values to what a decoder will see. */
static void quantise_array(nsdf_array_desc *array, float *values, int32_t *q) {
    const size_t count = (size_t)nsdf_array_size(array);
    if (array->quantiser == NSDF_QUANT_RAW) {
        memcpy(q, values, count * sizeof *q);
        return;
    }
    if (nsdf_quantise(values, count, array->step, array->offset, q) != 0)
        stop("a parameter is out of the quantiser's range");
    for (size_t i = 0; i < count; i++)
        values[i] = nsdf_dequantise(q[i], array->step, array->offset);
}

static void append_integers(nsdf_buffer *out, const int32_t *q, size_t count) {
    int32_t least = q[0], most = q[0];
    for (size_t i = 1; i < count; i++) {
        least = q[i] < least ? q[i] : least;
        most = q[i] > most ? q[i] : most;
    }
    const uint32_t range = (uint32_t)most - (uint32_t)least;
    for (uint32_t shift = 0; shift < 32 && range >> shift; shift += 8)
        for (size_t i = 0; i < count; i++)
            nsdf_buffer_u8(out, (uint8_t)(((uint32_t)q[i] - (uint32_t)least) >> shift));
}

static void recode_part(nsdf_segment_part *part, const recoding *how, nsdf_buffer *payload) {
    nsdf_tensor_list *list = part->kind == NSDF_PART_BLOCKS ? &part->desc.blocks.list : &part->desc.network.list;
    int32_t *const integers = malloc((size_t)nsdf_parameter_count(list) * sizeof *integers), *q = integers;
    float *values = part->values;
    if (!integers)
        stop("out of memory");
    list->entropy = (uint8_t)how->kind;
    for (uint32_t t = 0; t < list->count; t++)
        for (uint32_t a = 0; a < list->tensors[t].array_count; a++) {
            nsdf_array_desc *array = &list->tensors[t].arrays[a];
            const size_t count = (size_t)nsdf_array_size(array);
            if (how->bits > 0 && array->quantiser != NSDF_QUANT_RAW && !is_exact(part, t))
                nsdf_minmax_quantiser(values, count, how->bits, &array->step, &array->offset);
            quantise_array(array, values, q);
            if (how->integers && count > 0)
                append_integers(how->integers, q, count);
            q += count;
            values += count;
        }
    const int failed = part->kind == NSDF_PART_BLOCKS ? nsdf_write_blocks_part(payload, &part->desc.blocks, integers)
                                                      : nsdf_write_network_part(payload, &part->desc.network, integers);
    if (failed)
        stop("the back end is not in this build");
    free(integers);
}

static void recode_segment(const nsdf_stream *stream, nsdf_memory *memory, uint32_t index, const recoding *how,
                           nsdf_buffer *payload) {
    nsdf_segment segment;
    nsdf_error error;
    if (nsdf_segment_load(stream, index, memory, &segment, &error) != NSDF_OK)
        stop(error.message);
    uint64_t hash = NSDF_HASH_START;
    nsdf_write_segment_start(payload, segment.part_count);
    for (uint32_t i = 0; i < segment.part_count; i++) {
        nsdf_segment_part *part = &segment.parts[i];
        recode_part(part, how, payload);
        hash = nsdf_hash_floats(hash, part->values, (size_t)nsdf_parameter_count(nsdf_segment_tensors(part)));
    }
    stream->entries[index].parameter_hash = hash;
    nsdf_segment_free(memory, &segment);
}

static void write_out(const char *path, const nsdf_buffer *file) {
    FILE *out = fopen(path, "wb");
    if (!out || fwrite(file->data, 1, file->size, out) != file->size || fclose(out) != 0)
        stop("the output cannot be written");
}

int main(int argc, char **argv) {
    if (argc < 4) {
        fprintf(stderr, "usage: bench_recode FILE.nsdf OUT none|deflate|zstd|range|integers [BITS]\n");
        return 2;
    }
    nsdf_buffer integers = {NULL, 0, 0, 0};
    const int only_integers = strcmp(argv[3], "integers") == 0;
    const recoding how = {only_integers ? NSDF_ENTROPY_NONE : back_end_of(argv[3]),
                          argc > 4 ? (int)strtol(argv[4], NULL, 10) : 0, only_integers ? &integers : NULL};
    nsdf_memory memory;
    nsdf_stream stream = {0};
    nsdf_error error = {0};
    nsdf_memory_init(&memory, NULL, (uint64_t)1 << 30);
    if (nsdf_source_file(&stream.source, argv[1], &error) != NSDF_OK ||
        nsdf_stream_open(&stream, &memory, &error) != NSDF_OK)
        stop(error.message);
    const uint32_t count = stream.header.segment_count;
    nsdf_buffer *segments = calloc(count, sizeof *segments), metadata = {NULL, 0, 0, 0}, file = {NULL, 0, 0, 0};
    if (!segments)
        stop("out of memory");
    for (uint32_t i = 0; i < count; i++)
        recode_segment(&stream, &memory, i, &how, &segments[i]);
    nsdf_file_parts parts = {stream.header, segments, stream.entries, &metadata, NULL, NULL, 0};
    if (nsdf_write_file(&file, &parts) != 0 || integers.failed)
        stop("out of memory");
    const nsdf_buffer *out = only_integers ? &integers : &file;
    write_out(argv[2], out);
    printf("%zu\n", out->size);
    for (uint32_t i = 0; i < count; i++)
        nsdf_buffer_free(&segments[i]);
    free(segments);
    nsdf_buffer_free(&file);
    nsdf_buffer_free(&integers);
    nsdf_stream_close(&stream, &memory);
    return EXIT_SUCCESS;
}
