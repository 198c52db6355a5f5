#include "entropy_read.h"

int nsdf_entropy_available(nsdf_entropy_kind kind) {
    switch (kind) {
    case NSDF_ENTROPY_NONE:
    case NSDF_ENTROPY_RANGE:
        return 1;
    case NSDF_ENTROPY_DEFLATE:
#ifdef NSDF_HAVE_ZLIB
        return 1;
#else
        return 0;
#endif
    case NSDF_ENTROPY_ZSTD:
#ifdef NSDF_HAVE_ZSTD
        return 1;
#else
        return 0;
#endif
    }
    return 0;
}

const char *nsdf_entropy_name(nsdf_entropy_kind kind) {
    switch (kind) {
    case NSDF_ENTROPY_NONE:
        return "none";
    case NSDF_ENTROPY_DEFLATE:
        return "deflate";
    case NSDF_ENTROPY_ZSTD:
        return "zstd";
    case NSDF_ENTROPY_RANGE:
        return "range";
    }
    return NULL;
}

uint64_t nsdf_all_plane_bytes(const nsdf_tensor_list *list) {
    uint64_t bytes = 0;
    for (uint32_t t = 0; t < list->count; t++)
        for (uint32_t k = 0; k < list->tensors[t].array_count; k++)
            bytes += nsdf_plane_bytes(&list->tensors[t].arrays[k]);
    return bytes;
}

/* Bytes of the packed stream of all arrays. */
static uint64_t packed_size(const nsdf_tensor_list *list) {
    uint64_t bits = 0;
    for (uint32_t t = 0; t < list->count; t++)
        for (uint32_t k = 0; k < list->tensors[t].array_count; k++) {
            const nsdf_array_desc *a = &list->tensors[t].arrays[k];
            bits += a->quantiser == NSDF_QUANT_UNIFORM ? nsdf_array_size(a) * a->bits : 0;
        }
    return (bits + 7) / 8;
}

static nsdf_parse check_size(size_t size, uint64_t expected, const char **what) {
    if (size == expected)
        return NSDF_PARSE_OK;
    *what =
        size < expected ? "fewer coded bytes than the parameters need" : "more coded bytes than the parameters need";
    return size < expected ? NSDF_PARSE_TRUNCATED : NSDF_PARSE_CORRUPT;
}

nsdf_parse nsdf_residuals_open(nsdf_residual_reader *reader, const nsdf_tensor_list *list, const uint8_t *data,
                               size_t size, uint8_t *planes, const nsdf_codec_memory *memory, const char **what) {
    uint64_t plane_bytes = nsdf_all_plane_bytes(list);
    nsdf_residual_reader fresh = {.kind = (nsdf_entropy_kind)list->entropy, .bytes = data};
    *reader = fresh;
    if (plane_bytes == 0) {
        reader->kind = NSDF_ENTROPY_NONE;
        return check_size(size, 0, what);
    }
    switch (reader->kind) {
    case NSDF_ENTROPY_NONE:
        return check_size(size, packed_size(list), what);
    case NSDF_ENTROPY_DEFLATE:
        reader->bytes = planes;
        return nsdf_inflate(data, size, planes, (size_t)plane_bytes, memory, what);
    case NSDF_ENTROPY_ZSTD:
        reader->bytes = planes;
        return nsdf_unzstd(data, size, planes, (size_t)plane_bytes, memory, what);
    case NSDF_ENTROPY_RANGE:
        nsdf_range_open(&reader->range, data, size);
        break;
    }
    return NSDF_PARSE_OK;
}

/* `bits` bits from the packed stream, lowest first.  Touches no byte without such a bit. */
static uint32_t take_bits(nsdf_residual_reader *reader, uint32_t bits) {
    uint32_t shift = (uint32_t)(reader->bit & 7), value = 0;
    const uint8_t *p = reader->bytes + (reader->bit >> 3);
    for (uint32_t have = 0; have < bits + shift; have += 8)
        value |= (uint32_t)*p++ << have;
    reader->bit += bits;
    return value >> shift & ((UINT32_C(1) << bits) - 1);
}

static void unpack_array(nsdf_residual_reader *reader, const nsdf_array_desc *a, int32_t *residuals) {
    size_t count = (size_t)nsdf_array_size(a);
    for (size_t i = 0; i < count; i++)
        residuals[i] = a->residual_min + (int32_t)take_bits(reader, a->bits);
}

static void join_planes(nsdf_residual_reader *reader, const nsdf_array_desc *a, int32_t *residuals) {
    size_t count = (size_t)nsdf_array_size(a);
    for (size_t i = 0; i < count; i++)
        residuals[i] = a->residual_min;
    for (uint32_t shift = 0; shift < a->bits; shift += 8, reader->bytes += count)
        for (size_t i = 0; i < count; i++)
            residuals[i] += (int32_t)((uint32_t)reader->bytes[i] << shift);
}

/* The highest plane's byte may have more bits than the description allows. */
static int planes_in_range(const nsdf_array_desc *a, const int32_t *residuals) {
    int32_t high = nsdf_residual_max(a), inside = 1;
    for (size_t i = 0, count = (size_t)nsdf_array_size(a); i < count; i++)
        inside &= residuals[i] <= high;
    return inside;
}

nsdf_parse nsdf_residuals_next(nsdf_residual_reader *reader, const nsdf_array_desc *a, int32_t *residuals,
                               const char **what) {
    if (a->bits == 0 || reader->kind == NSDF_ENTROPY_NONE) {
        unpack_array(reader, a, residuals);
        return NSDF_PARSE_OK;
    }
    if (reader->kind == NSDF_ENTROPY_RANGE)
        return nsdf_range_array(&reader->range, a, residuals, what);
    join_planes(reader, a, residuals);
    if (!planes_in_range(a, residuals)) {
        *what = "a symbol with more bits than its array's description gives";
        return NSDF_PARSE_CORRUPT;
    }
    return NSDF_PARSE_OK;
}

nsdf_parse nsdf_residuals_close(const nsdf_residual_reader *reader, const char **what) {
    if (reader->kind == NSDF_ENTROPY_RANGE)
        return nsdf_range_close(&reader->range, what);
    uint32_t used = (uint32_t)(reader->bit & 7);
    if (reader->kind == NSDF_ENTROPY_NONE && used && reader->bytes[reader->bit >> 3] >> used) {
        *what = "padding bits that are not 0";
        return NSDF_PARSE_CORRUPT;
    }
    return NSDF_PARSE_OK;
}
