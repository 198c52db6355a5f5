#include "entropy_write.h"

#include <stdlib.h>

#ifdef NSDF_HAVE_ZLIB
#include <zlib.h>
#endif
#ifdef NSDF_HAVE_ZSTD
#include <zstd.h>
#endif

/* Calls visit for every uniform array. */
typedef void (*array_visitor)(void *user, const nsdf_array_desc *a, const int32_t *residuals);

static void visit_uniform(const nsdf_tensor_list *list, const int32_t *residuals, array_visitor visit, void *user) {
    for (uint32_t t = 0; t < list->count; t++)
        for (uint32_t k = 0; k < list->tensors[t].array_count; k++) {
            const nsdf_array_desc *a = &list->tensors[t].arrays[k];
            if (a->quantiser == NSDF_QUANT_UNIFORM)
                visit(user, a, residuals);
            residuals += nsdf_array_size(a);
        }
}

typedef struct bit_packer {
    nsdf_buffer *out;
    uint32_t pending, count; /* bits that do not fill a byte yet */
} bit_packer;

static void pack_array(void *user, const nsdf_array_desc *a, const int32_t *residuals) {
    bit_packer *packer = user;
    for (size_t i = 0, n = (size_t)nsdf_array_size(a); i < n; i++) {
        packer->pending |= (uint32_t)(residuals[i] - a->residual_min) << packer->count;
        for (packer->count += a->bits; packer->count >= 8; packer->count -= 8, packer->pending >>= 8)
            nsdf_buffer_u8(packer->out, (uint8_t)packer->pending);
    }
}

static void split_array(void *user, const nsdf_array_desc *a, const int32_t *residuals) {
    nsdf_buffer *planes = user;
    for (uint32_t shift = 0; shift < a->bits; shift += 8)
        for (size_t i = 0, n = (size_t)nsdf_array_size(a); i < n; i++)
            nsdf_buffer_u8(planes, (uint8_t)((uint32_t)(residuals[i] - a->residual_min) >> shift));
}

static int write_packed(nsdf_buffer *out, const nsdf_tensor_list *list, const int32_t *residuals) {
    bit_packer packer = {out, 0, 0};
    visit_uniform(list, residuals, pack_array, &packer);
    if (packer.count > 0)
        nsdf_buffer_u8(out, (uint8_t)packer.pending);
    return 0;
}

#ifdef NSDF_HAVE_ZLIB
static int write_deflate(nsdf_buffer *out, const nsdf_buffer *planes) {
    uLongf size = compressBound((uLong)planes->size);
    uint8_t *room = malloc(size);
    int code = room ? compress2(room, &size, planes->data, (uLong)planes->size, 9) : Z_MEM_ERROR;
    if (code == Z_OK)
        nsdf_buffer_append(out, room, size);
    free(room);
    return code == Z_OK ? 0 : -1;
}
#else
static int write_deflate(nsdf_buffer *out, const nsdf_buffer *planes) {
    (void)out, (void)planes;
    return -1;
}
#endif

#ifdef NSDF_HAVE_ZSTD
static int write_zstd(nsdf_buffer *out, const nsdf_buffer *planes) {
    size_t bound = ZSTD_compressBound(planes->size);
    uint8_t *room = malloc(bound);
    size_t size = room ? ZSTD_compress(room, bound, planes->data, planes->size, 19) : 0;
    int failed = !room || ZSTD_isError(size);
    if (!failed)
        nsdf_buffer_append(out, room, size);
    free(room);
    return failed ? -1 : 0;
}
#else
static int write_zstd(nsdf_buffer *out, const nsdf_buffer *planes) {
    (void)out, (void)planes;
    return -1;
}
#endif

static int write_planes(nsdf_buffer *out, const nsdf_tensor_list *list, const int32_t *residuals) {
    nsdf_buffer planes = {0};
    visit_uniform(list, residuals, split_array, &planes);
    int failed = planes.failed;
    if (!failed)
        failed = list->entropy == NSDF_ENTROPY_DEFLATE ? write_deflate(out, &planes) : write_zstd(out, &planes);
    nsdf_buffer_free(&planes);
    return failed ? -1 : 0;
}

static void note_bits(void *user, const nsdf_array_desc *a, const int32_t *residuals) {
    (void)residuals;
    *(uint32_t *)user |= a->bits;
}

int nsdf_write_residuals(nsdf_buffer *out, const nsdf_tensor_list *list, const int32_t *residuals) {
    uint32_t bits = 0;
    visit_uniform(list, residuals, note_bits, &bits);
    if (bits == 0) /* nothing to say: the stream is empty for every back end */
        return 0;
    switch (list->entropy) {
    case NSDF_ENTROPY_NONE:
        return write_packed(out, list, residuals);
    case NSDF_ENTROPY_DEFLATE:
    case NSDF_ENTROPY_ZSTD:
        return write_planes(out, list, residuals);
    case NSDF_ENTROPY_RANGE:
        nsdf_range_write(out, list, residuals);
        return 0;
    default:
        return -1;
    }
}
