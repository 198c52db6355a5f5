#include "block_rate.h"

#include <math.h>

static void add_differences(const nsdf_block_model *model, uint32_t tensor, float scale, const float *values,
                            float *gradient) {
    const nsdf_array_desc *a = &model->desc.list.tensors[tensor].arrays[0];
    const size_t columns = (size_t)a->rows * a->cols, at = nsdf_block_offset(&model->desc, tensor);
    const float *now = values + at;
    const float square = a->step * a->step;
    float *slope = gradient + at;
    for (size_t i = columns; i < columns * a->planes; i++) {
        const float r = now[i] - now[i - columns], d = scale * r / (r * r + square);
        slope[i] += d;
        slope[i - columns] -= d;
    }
}

void nsdf_block_add_rate(const nsdf_block_model *model, const float *values, double weight, float *gradient) {
    if (model->knots == 0 || !(weight > 0.0))
        return;
    const float scale = (float)(weight / (log(2.0) * (double)model->pose_count));
    add_differences(model, NSDF_BLOCK_POSES, scale, values, gradient);
    if (model->level_knots > 0)
        add_differences(model, NSDF_BLOCK_COEFFICIENTS, scale, values, gradient);
}
