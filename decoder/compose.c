/* Composition of tensors in time: constant, cubic B-spline, low-rank (ResFields, Mihajlovic et al., ICLR 2024). */
#include "compose.h"
#include "spline.h"

uint64_t nsdf_tensor_size(const nsdf_tensor_desc *tensor) {
    uint64_t size = 0;
    for (uint32_t i = 0; i < tensor->array_count; i++)
        size += nsdf_array_size(&tensor->arrays[i]);
    return size;
}

static void add_plane(nsdf_blend *blend, const float *plane, double weight) {
    blend->planes[blend->count] = plane;
    blend->weights[blend->count++] = weight;
}

static void blend_spline(nsdf_blend *blend, uint32_t knots, const float *values, double u) {
    float weight[4];
    const uint32_t first = nsdf_spline_weights(u, knots, weight);
    const size_t plane = (size_t)blend->rows * blend->cols;
    for (uint32_t j = 0; j < 4; j++)
        add_plane(blend, values + (first + j) * plane, (double)weight[j]);
}

/* M_0, then M_r, then the control points of v_r. */
static void blend_low_rank(nsdf_blend *blend, const nsdf_tensor_desc *tensor, const float *values, double u) {
    float weight[4];
    const uint32_t first = nsdf_spline_weights(u, tensor->knots, weight);
    const size_t plane = (size_t)blend->rows * blend->cols;
    const float *points = values + (1 + tensor->rank) * plane + first;
    add_plane(blend, values, 1.0);
    for (uint32_t r = 0; r < tensor->rank; r++, points += tensor->knots) {
        double v = 0.0;
        for (uint32_t j = 0; j < 4; j++)
            v += (double)weight[j] * (double)points[j];
        add_plane(blend, values + (1 + r) * plane, v);
    }
}

void nsdf_blend_tensor(nsdf_blend *blend, const nsdf_tensor_desc *tensor, const float *values, double u) {
    blend->rows = tensor->rows;
    blend->cols = tensor->cols;
    blend->count = 0;
    if (tensor->kind == NSDF_TENSOR_SPLINE)
        blend_spline(blend, tensor->knots, values, u);
    else if (tensor->kind == NSDF_TENSOR_LOW_RANK)
        blend_low_rank(blend, tensor, values, u);
    else
        add_plane(blend, values, 1.0);
}

void nsdf_blend_rows(const nsdf_blend *blend, uint32_t first, uint32_t count, double *out) {
    const size_t at = (size_t)first * blend->cols, size = (size_t)count * blend->cols;
    for (size_t i = 0; i < size; i++)
        out[i] = 0.0;
    for (uint32_t k = 0; k < blend->count; k++) {
        const float *plane = blend->planes[k] + at;
        for (size_t i = 0; i < size; i++)
            out[i] += blend->weights[k] * (double)plane[i];
    }
}
