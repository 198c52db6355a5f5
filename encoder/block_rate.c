#include "block_rate.h"

#include <math.h>

void nsdf_block_add_rate(const nsdf_block_model *model, const float *values, double weight, float *gradient) {
    if (model->knots == 0 || !(weight > 0.0))
        return;
    const size_t columns = model->pose_count / model->knots;
    const float step = model->desc.list.tensors[NSDF_BLOCK_POSES].arrays[0].step, square = step * step;
    const float scale = (float)(weight / (log(2.0) * (double)model->pose_count));
    const float *now = values + model->pose_offset;
    float *slope = gradient + model->pose_offset;
    for (size_t i = columns; i < model->pose_count; i++) {
        const float r = now[i] - now[i - columns], d = scale * r / (r * r + square);
        slope[i] += d;
        slope[i - columns] -= d;
    }
}
