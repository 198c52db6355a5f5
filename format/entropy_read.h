/* Residuals out of the coded stream of a network part, array after array (spec, section "Coded residuals"). */
#ifndef NSDF_ENTROPY_READ_H
#define NSDF_ENTROPY_READ_H

#include "network_read.h"
#include "range_model.h"

typedef struct nsdf_range_decoder {
    const uint8_t *data, *end;
    uint32_t range, code;
    uint32_t missing; /* bytes asked for behind the end; 0 were given */
    nsdf_logistic_tables tables;
} nsdf_range_decoder;

typedef struct nsdf_residual_reader {
    nsdf_entropy_kind kind;
    nsdf_range_decoder range;
    const uint8_t *bytes; /* the stream (none), or the byte planes after inflating it (deflate, zstd) */
    uint64_t bit;         /* position of the packed reader */
} nsdf_residual_reader;

/* Bytes of the symbols of one array as byte planes. */
static inline uint64_t nsdf_plane_bytes(const nsdf_array_desc *a) {
    return a->quantiser == NSDF_QUANT_UNIFORM ? nsdf_array_size(a) * ((a->bits + 7u) / 8u) : 0;
}

/* The same summed over all arrays; 0 means that the coded stream is empty. */
uint64_t nsdf_all_plane_bytes(const nsdf_tensor_list *list);

/* `planes` has room for nsdf_all_plane_bytes(list) when the back end is deflate or zstd. */
nsdf_parse nsdf_residuals_open(nsdf_residual_reader *reader, const nsdf_tensor_list *list, const uint8_t *data,
                               size_t size, uint8_t *planes, const nsdf_codec_memory *memory, const char **what);
/* Residuals of the next uniform array, each within residual_min + [0, 2^bits). */
nsdf_parse nsdf_residuals_next(nsdf_residual_reader *reader, const nsdf_array_desc *array, int32_t *residuals,
                               const char **what);
/* After the last array: all bytes must have been used. */
nsdf_parse nsdf_residuals_close(const nsdf_residual_reader *reader, const char **what);

/* The back ends. */
void nsdf_range_open(nsdf_range_decoder *d, const uint8_t *data, size_t size);
nsdf_parse nsdf_range_array(nsdf_range_decoder *d, const nsdf_array_desc *array, int32_t *residuals, const char **what);
nsdf_parse nsdf_range_close(const nsdf_range_decoder *d, const char **what);
nsdf_parse nsdf_inflate(const uint8_t *data, size_t size, uint8_t *out, size_t out_size,
                        const nsdf_codec_memory *memory, const char **what);
nsdf_parse nsdf_unzstd(const uint8_t *data, size_t size, uint8_t *out, size_t out_size, const nsdf_codec_memory *memory,
                       const char **what);

#endif
