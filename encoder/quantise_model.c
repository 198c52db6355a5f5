#include "quantise_model.h"

#include "network_write.h"

#include <math.h>
#include <string.h>

static double root_mean_square(const float *values, uint64_t count) {
    double sum = 0.0;
    for (uint64_t i = 0; i < count; i++)
        sum += (double)values[i] * (double)values[i];
    return count ? sqrt(sum / (double)count) : 0.0;
}

static void choose_quantiser(nsdf_array_desc *a, const nsdf_quantise_params *params, const float *values) {
    uint64_t count = nsdf_array_size(a);
    a->quantiser = params->bits >= 32.0 ? NSDF_QUANT_RAW : NSDF_QUANT_UNIFORM;
    if (a->quantiser == NSDF_QUANT_RAW)
        return;
    if (params->minmax) {
        nsdf_minmax_quantiser(values, (size_t)count, (int)lround(params->bits), &a->step, &a->offset);
        return;
    }
    double step = 6.0 * root_mean_square(values, count) / exp2(params->bits);
    a->step = step > 1e-30 ? (float)step : 1.0f;
    a->offset = 0.0f;
}

void nsdf_choose_quantisers(nsdf_model *model, const nsdf_quantise_params *params, const float *parameters) {
    for (uint32_t i = 0; i < model->desc.list.count; i++)
        for (uint32_t k = 0; k < model->desc.list.tensors[i].array_count; k++)
            choose_quantiser(&model->desc.list.tensors[i].arrays[k], params, parameters + model->array_offset[i][k]);
}

static void round_array(const nsdf_array_desc *a, const float *values, float *rounded) {
    uint64_t count = nsdf_array_size(a);
    if (a->quantiser == NSDF_QUANT_RAW || a->step <= 0.0f) {
        if (a->quantiser == NSDF_QUANT_RAW)
            memcpy(rounded, values, count * sizeof *values);
        else
            for (uint64_t i = 0; i < count; i++)
                rounded[i] = a->offset;
        return;
    }
    /* The operations of nsdf_quantise and nsdf_dequantise: a product with 1 / step would part from them at ties. */
    double offset = (double)a->offset, step = (double)a->step;
    for (uint64_t i = 0; i < count; i++)
        rounded[i] = (float)(offset + step * rint(((double)values[i] - offset) / step));
}

void nsdf_round_parameters(const nsdf_model *model, const float *parameters, float *rounded) {
    for (uint32_t i = 0; i < model->desc.list.count; i++)
        for (uint32_t k = 0; k < model->desc.list.tensors[i].array_count; k++) {
            uint64_t at = model->array_offset[i][k];
            round_array(&model->desc.list.tensors[i].arrays[k], parameters + at, rounded + at);
        }
}

int nsdf_quantise_parameters(const nsdf_model *model, const float *parameters, int32_t *q) {
    for (uint32_t i = 0; i < model->desc.list.count; i++)
        for (uint32_t k = 0; k < model->desc.list.tensors[i].array_count; k++) {
            const nsdf_array_desc *a = &model->desc.list.tensors[i].arrays[k];
            uint64_t at = model->array_offset[i][k], count = nsdf_array_size(a);
            if (a->quantiser == NSDF_QUANT_RAW)
                memcpy(q + at, parameters + at, count * sizeof *q);
            else if (nsdf_quantise(parameters + at, (size_t)count, a->step, a->offset, q + at) != 0)
                return -1;
        }
    return 0;
}
