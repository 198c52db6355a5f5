#include "network_rate.h"

#include <math.h>

/* Of the differences between values that are `apart` from each other; with 0, of the values. */
static void add_array(const nsdf_array_desc *a, size_t apart, float scale, const float *now, float *slope) {
    const size_t count = (size_t)a->planes * a->rows * a->cols;
    const float square = a->step * a->step;
    for (size_t i = apart; i < count; i++) {
        const float r = now[i] - (apart > 0 ? now[i - apart] : 0.0f), d = scale * r / (r * r + square);
        slope[i] += d;
        if (apart > 0)
            slope[i - apart] -= d;
    }
}

void nsdf_network_add_rate(const nsdf_model *model, const float *parameters, double weight, float *gradient) {
    const float scale = (float)(weight / (log(2.0) * (double)model->parameter_count));
    for (uint32_t i = 0; i < model->desc.list.count; i++) {
        const nsdf_tensor_desc *t = &model->desc.list.tensors[i];
        for (uint32_t k = 0; k < t->array_count; k++) {
            const nsdf_array_desc *a = &t->arrays[k];
            const uint64_t at = model->array_offset[i][k];
            const size_t apart = t->kind == NSDF_TENSOR_SPLINE ? (size_t)a->rows * a->cols : 0;
            if (a->quantiser == NSDF_QUANT_UNIFORM && a->step > 0.0f)
                add_array(a, apart, scale, parameters + at, gradient + at);
        }
    }
}
