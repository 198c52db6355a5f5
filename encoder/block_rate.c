#include "block_rate.h"

#include "rate_term.h"

#include <math.h>

/* Of the differences between values of a tensor that are `apart` from each other; with 0, of the values. */
static void add_tensor(const nsdf_block_model *model, uint32_t tensor, size_t apart, float scale, const float *values,
                       float *gradient) {
    const nsdf_array_desc *a = &model->desc.list.tensors[tensor].arrays[0];
    const size_t count = (size_t)a->planes * a->rows * a->cols, at = nsdf_block_offset(&model->desc, tensor);
    nsdf_add_rate_term(values + at, count, apart, a->step, scale, gradient + at);
}

static size_t plane_size(const nsdf_block_model *model, uint32_t tensor) {
    const nsdf_array_desc *a = &model->desc.list.tensors[tensor].arrays[0];
    return (size_t)a->rows * a->cols;
}

void nsdf_block_add_rate(const nsdf_block_model *model, const float *values, double weight, float *gradient) {
    if (!(weight > 0.0))
        return;
    const size_t weights = (size_t)model->desc.block_count * model->desc.influences;
    const double numbers = (double)(model->pose_count + model->level_count + model->term_count + weights);
    const float scale = (float)(weight / (log(2.0) * numbers));
    add_tensor(model, NSDF_BLOCK_POSES, plane_size(model, NSDF_BLOCK_POSES), scale, values, gradient);
    if (model->level_knots > 0)
        add_tensor(model, NSDF_BLOCK_COEFFICIENTS, plane_size(model, NSDF_BLOCK_COEFFICIENTS), scale, values, gradient);
    add_tensor(model, NSDF_BLOCK_WEIGHTS, model->desc.influences, scale, values, gradient);
    for (uint32_t degree = 1; degree <= model->desc.degree; degree++)
        add_tensor(model, NSDF_BLOCK_COEFFICIENTS + degree, degree == 1 ? nsdf_degree_terms(1) : 0, scale, values,
                   gradient);
}
