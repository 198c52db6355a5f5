/* Descriptions of arrays out of the first bytes of an input, for the targets of the entropy coder. */
#ifndef NSDF_FUZZ_ARRAYS_H
#define NSDF_FUZZ_ARRAYS_H

#include <string.h>

#include "format_desc.h"

enum { FUZZ_ARRAYS_BYTES = 14, FUZZ_ARRAYS_MOST = 2 * 9 * 16 * 16 };

/* Reads FUZZ_ARRAYS_BYTES: the back end, then planes, rows, cols, bits, residual_min and prediction of two arrays. */
static inline void fuzz_arrays(const uint8_t *data, nsdf_tensor_list *list) {
    memset(list, 0, sizeof *list);
    list->entropy = data[0] % NSDF_ENTROPY_COUNT;
    list->count = 2;
    for (uint32_t t = 0; t < 2; t++) {
        const uint8_t *d = data + 1 + 6 * t;
        list->tensors[t].kind = NSDF_TENSOR_SPLINE;
        list->tensors[t].array_count = 1;
        list->tensors[t].rows = 1 + d[1] % 16u;
        list->tensors[t].cols = 1 + d[2] % 16u;
        list->tensors[t].knots = 1 + d[0] % 9u;
        nsdf_tensor_layout(&list->tensors[t]);
        nsdf_array_desc *a = &list->tensors[t].arrays[0];
        a->quantiser = d[5] >> 2 & 1 ? NSDF_QUANT_RAW : NSDF_QUANT_UNIFORM;
        a->predict = d[5] & 3;
        a->bits = d[3] % 25;
        a->residual_min = -(int32_t)((uint32_t)d[4] << a->bits >> 8);
    }
}

#endif
