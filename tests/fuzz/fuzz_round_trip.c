/* Residuals that the input spells come back from every back end as they were written. */
#include "entropy_read.h"
#include "entropy_write.h"
#include "fuzz_arrays.h"
#include "fuzz_target.h"

#include <stdlib.h>

/* Residuals within the arrays' ranges, out of bytes that start again at their end. */
static void spell_residuals(const nsdf_tensor_list *list, const uint8_t *data, size_t size, int32_t *residuals) {
    size_t at = 0;
    for (uint32_t t = 0; t < list->count; t++) {
        const nsdf_array_desc *a = &list->tensors[t].arrays[0];
        const uint32_t mask = ((uint32_t)1 << a->bits) - 1;
        for (uint64_t i = 0; i < nsdf_array_size(a); i++) {
            uint32_t value = 0;
            for (uint32_t shift = 0; shift < a->bits && size > 0; shift += 8)
                value |= (uint32_t)data[at++ % size] << shift;
            *residuals++ = a->residual_min + (int32_t)(value & mask);
        }
    }
}

static void check_back(const nsdf_tensor_list *list, const nsdf_buffer *coded, const int32_t *residuals) {
    static int32_t back[FUZZ_ARRAYS_MOST];
    static uint8_t planes[4 * FUZZ_ARRAYS_MOST];
    nsdf_residual_reader reader;
    const char *what = NULL;
    static const uint8_t nothing[1]; /* the stream of arrays of 0 bits has no bytes */
    if (nsdf_residuals_open(&reader, list, coded->data ? coded->data : nothing, coded->size, planes, NULL, &what) !=
        NSDF_PARSE_OK)
        abort();
    for (uint32_t t = 0; t < list->count; t++) {
        const nsdf_array_desc *a = &list->tensors[t].arrays[0];
        const size_t count = (size_t)nsdf_array_size(a);
        if (a->quantiser == NSDF_QUANT_UNIFORM && (nsdf_residuals_next(&reader, a, back, &what) != NSDF_PARSE_OK ||
                                                   memcmp(back, residuals, count * sizeof *back) != 0))
            abort();
        residuals += count;
    }
    if (nsdf_residuals_close(&reader, &what) != NSDF_PARSE_OK)
        abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static int32_t residuals[FUZZ_ARRAYS_MOST];
    nsdf_tensor_list list;
    nsdf_buffer coded = {0};
    if (size < FUZZ_ARRAYS_BYTES)
        return 0;
    fuzz_arrays(data, &list);
    spell_residuals(&list, data + FUZZ_ARRAYS_BYTES, size - FUZZ_ARRAYS_BYTES, residuals);
    if (nsdf_entropy_available((nsdf_entropy_kind)list.entropy)) {
        if (nsdf_write_residuals(&coded, &list, residuals) != 0)
            abort();
        check_back(&list, &coded, residuals);
    }
    nsdf_buffer_free(&coded);
    return 0;
}
