/* Parameters at one time: every kind of tensor is a weighted sum of planes of its parameters. */
#ifndef NSDF_COMPOSE_H
#define NSDF_COMPOSE_H

#include "format_desc.h"

/* tensor(u) = sum_k weights[k] * planes[k], each plane [rows][cols]. */
typedef struct nsdf_blend {
    uint32_t rows, cols, count;
    const float *planes[1 + NSDF_MAX_RANK];
    double weights[1 + NSDF_MAX_RANK];
} nsdf_blend;

/* values: the tensor's parameters, its arrays in the order of the file.  u in [0, 1] over the segment. */
void nsdf_blend_tensor(nsdf_blend *blend, const nsdf_tensor_desc *tensor, const float *values, double u);
/* `count` rows of the sum in double, `cols` numbers each. */
void nsdf_blend_rows(const nsdf_blend *blend, uint32_t first, uint32_t count, double *out);
static inline void nsdf_blend_row(const nsdf_blend *blend, uint32_t row, double *out) {
    nsdf_blend_rows(blend, row, 1, out);
}

/* Parameters of one tensor: how far it is to the next one's values. */
uint64_t nsdf_tensor_size(const nsdf_tensor_desc *tensor);

#endif
