#include "network_rate.h"

#include "rate_term.h"

#include <math.h>

void nsdf_network_add_rate(const nsdf_model *model, const float *parameters, double weight, float *gradient) {
    const float scale = (float)(weight / (log(2.0) * (double)model->parameter_count));
    for (uint32_t i = 0; i < model->desc.list.count; i++) {
        const nsdf_tensor_desc *t = &model->desc.list.tensors[i];
        for (uint32_t k = 0; k < t->array_count; k++) {
            const nsdf_array_desc *a = &t->arrays[k];
            const uint64_t at = model->array_offset[i][k];
            const size_t apart = t->kind == NSDF_TENSOR_SPLINE ? (size_t)a->rows * a->cols : 0;
            if (a->quantiser == NSDF_QUANT_UNIFORM && a->step > 0.0f)
                nsdf_add_rate_term(parameters + at, (size_t)nsdf_array_size(a), apart, a->step, scale, gradient + at);
        }
    }
}
