/* The entropy decoder alone: residuals of two arrays out of any bytes stay within their ranges. */
#include "entropy_read.h"
#include "fuzz_arrays.h"
#include "fuzz_target.h"

#include <stdlib.h>

static void check_range(const nsdf_array_desc *a, const int32_t *residuals) {
    for (uint64_t i = 0; i < nsdf_array_size(a); i++)
        if (residuals[i] < a->residual_min || (uint32_t)(residuals[i] - a->residual_min) >> a->bits)
            abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static int32_t residuals[FUZZ_ARRAYS_MOST];
    static uint8_t planes[4 * FUZZ_ARRAYS_MOST];
    nsdf_tensor_list list;
    nsdf_residual_reader reader;
    const char *what = NULL;
    if (size < FUZZ_ARRAYS_BYTES)
        return 0;
    fuzz_arrays(data, &list);
    nsdf_parse status =
        nsdf_residuals_open(&reader, &list, data + FUZZ_ARRAYS_BYTES, size - FUZZ_ARRAYS_BYTES, planes, NULL, &what);
    for (uint32_t t = 0; t < list.count && status == NSDF_PARSE_OK; t++) {
        const nsdf_array_desc *a = &list.tensors[t].arrays[0];
        if (a->quantiser != NSDF_QUANT_UNIFORM)
            continue;
        status = nsdf_residuals_next(&reader, a, residuals, &what);
        if (status == NSDF_PARSE_OK)
            check_range(a, residuals);
    }
    if (status == NSDF_PARSE_OK)
        status = nsdf_residuals_close(&reader, &what);
    if (status != NSDF_PARSE_OK && !what)
        abort();
    return 0;
}
