#include "model.h"

#include "fourier.h"
#include "spline.h"

#include <math.h>
#include <string.h>

uint32_t nsdf_layer_inputs(const nsdf_model *model, uint32_t layer) {
    return layer == 0 ? nsdf_input_width(&model->desc) : model->desc.layers[layer - 1].width;
}

/* ---- Description ---------------------------------------------------------------------------------------- */

static uint32_t knot_count(double spacing, uint32_t frame_count) {
    double spans = ceil(((double)frame_count - 1.0) / (spacing > 0.25 ? spacing : 0.25));
    double most = NSDF_MAX_KNOTS - 3;
    return 3 + (uint32_t)(spans < 1.0 ? 1.0 : spans > most ? most : spans);
}

static uint8_t layer_activation(const nsdf_encoder_options *o, uint32_t layer) {
    static const uint8_t map[3] = {NSDF_ACT_SINE, NSDF_ACT_RELU, NSDF_ACT_TANH};
    if (layer == o->layers)
        return o->output_tanh ? NSDF_ACT_TANH : NSDF_ACT_IDENTITY;
    return map[o->activation];
}

static void describe_tensor(nsdf_tensor_desc *t, nsdf_tensor_time time, uint32_t rows, uint32_t cols, uint32_t knots,
                            uint32_t rank) {
    memset(t, 0, sizeof *t);
    t->kind = (uint8_t)time;
    t->rows = rows;
    t->cols = cols;
    t->knots = time == NSDF_TIME_CONSTANT ? 0 : knots;
    t->rank = time == NSDF_TIME_LOW_RANK ? rank : 0;
    nsdf_tensor_layout(t);
}

void nsdf_model_describe(nsdf_model *model, const nsdf_encoder_options *o, uint32_t frame_count) {
    nsdf_network_desc *d = &model->desc;
    memset(d, 0, sizeof *d);
    d->input = (uint8_t)o->input;
    d->list.entropy = (uint8_t)o->entropy;
    d->time_scale = 1.0f;
    d->value_scale = 1.0f;
    if (o->input == NSDF_MODEL_FOURIER) {
        d->fourier_source = o->fourier_trained ? NSDF_FOURIER_STORED : NSDF_FOURIER_SEED;
        d->fourier_count = o->fourier_features;
        d->fourier_seed = o->seed;
        d->fourier_sigma = (float)o->fourier_sigma;
        if (o->fourier_trained)
            describe_tensor(&d->list.tensors[d->list.count++], NSDF_TIME_CONSTANT, o->fourier_features, 4, 0, 0);
    }
    d->layer_count = o->layers + 1;
    uint32_t knots = knot_count(o->knot_spacing, frame_count);
    nsdf_tensor_time time = frame_count > 1 ? o->weight_time : NSDF_TIME_CONSTANT;
    for (uint32_t l = 0; l < d->layer_count; l++) {
        d->layers[l].width = l == o->layers ? 1 : o->width;
        d->layers[l].activation = layer_activation(o, l);
        d->layers[l].omega = (float)(l == 0 ? o->omega_first : o->omega_hidden);
        uint32_t rows = d->layers[l].width, cols = nsdf_layer_inputs(model, l);
        describe_tensor(&d->list.tensors[d->list.count++], l == 0 ? time : NSDF_TIME_CONSTANT, rows, cols, knots,
                        o->rank);
        describe_tensor(&d->list.tensors[d->list.count++], l < o->layers ? time : NSDF_TIME_CONSTANT, rows, 1, knots,
                        o->rank);
    }
    nsdf_model_layout(model);
}

void nsdf_model_layout(nsdf_model *model) {
    const nsdf_network_desc *d = &model->desc;
    uint64_t at = 0;
    for (uint32_t i = 0; i < d->list.count; i++)
        for (uint32_t k = 0; k < d->list.tensors[i].array_count; k++) {
            model->array_offset[i][k] = at;
            at += nsdf_array_size(&d->list.tensors[i].arrays[k]);
        }
    model->parameter_count = at;
    size_t composed = 0;
    model->widest = 0;
    for (uint32_t l = 0; l < d->layer_count; l++) {
        uint32_t in = nsdf_layer_inputs(model, l), out = d->layers[l].width;
        model->layer_offset[l] = composed;
        composed += (size_t)out * (in + 1);
        model->widest = in > model->widest ? in : model->widest;
        model->widest = out > model->widest ? out : model->widest;
    }
    model->fourier_offset = composed;
    model->composed_size = composed + 4 * (size_t)d->fourier_count;
}

/* ---- First values --------------------------------------------------------------------------------------- */

static void fill_uniform(nsdf_random *random, float *values, uint64_t count, double range) {
    for (uint64_t i = 0; i < count; i++)
        values[i] = (float)(range * (2.0 * (double)nsdf_random_unit(random) - 1.0));
}

static double weight_range(const nsdf_model *model, uint32_t layer) {
    const nsdf_network_desc *d = &model->desc;
    double in = (double)nsdf_layer_inputs(model, layer);
    /* The last layer of a sine network sums sines: it starts like a hidden one without the frequency, and ten times
     * smaller, since distances in the domain are well below 1. */
    uint8_t act =
        layer + 1 == d->layer_count && layer > 0 ? d->layers[layer - 1].activation : d->layers[layer].activation;
    if (act == NSDF_ACT_SINE && layer == 0)
        return 1.0 / in;
    double omega = layer + 1 == d->layer_count ? 1.0 : (double)d->layers[layer].omega;
    double last = layer + 1 == d->layer_count ? 0.1 : 1.0;
    return act == NSDF_ACT_SINE ? last * sqrt(6.0 / in) / omega : sqrt(6.0 / in);
}

/* Low-rank factors start small, so that the network starts constant in time. */
static void initialise_tensor(const nsdf_tensor_desc *t, const uint64_t offset[3], double range, nsdf_random *random,
                              float *parameters) {
    uint64_t plane = (uint64_t)t->rows * t->cols;
    float *first = parameters + offset[0];
    fill_uniform(random, first, plane, range);
    for (uint32_t k = 1; k < t->arrays[0].planes; k++)
        memcpy(first + k * plane, first, plane * sizeof *first);
    if (t->kind != NSDF_TENSOR_LOW_RANK)
        return;
    fill_uniform(random, parameters + offset[1], t->rank * plane, 0.3 * range);
    fill_uniform(random, parameters + offset[2], (uint64_t)t->rank * t->knots, 0.3);
}

void nsdf_model_initialise(const nsdf_model *model, nsdf_random *random, float *parameters) {
    const nsdf_network_desc *d = &model->desc;
    if (d->input == NSDF_INPUT_FOURIER && d->fourier_source == NSDF_FOURIER_STORED)
        nsdf_fourier_matrix(d->fourier_seed, d->fourier_sigma, d->fourier_count, parameters);
    for (uint32_t l = 0; l < d->layer_count; l++) {
        uint32_t w = nsdf_weight_index(d, l);
        double in = (double)nsdf_layer_inputs(model, l), range = weight_range(model, l);
        double bias = d->layers[l].activation == NSDF_ACT_SINE ? 1.0 / sqrt(in) : 0.0;
        if (d->layers[l].activation == NSDF_ACT_SINE && l > 0)
            bias /= (double)d->layers[l].omega;
        initialise_tensor(&d->list.tensors[w], model->array_offset[w], range, random, parameters);
        initialise_tensor(&d->list.tensors[w + 1], model->array_offset[w + 1], bias, random, parameters);
    }
}

/* ---- Time ----------------------------------------------------------------------------------------------- */

typedef struct {
    uint32_t first;
    float weight[4];
} knot_weights;

static float control_value(const float *control, const knot_weights *k) {
    const float *c = control + k->first;
    return k->weight[0] * c[0] + k->weight[1] * c[1] + k->weight[2] * c[2] + k->weight[3] * c[3];
}

/* out[row * stride + col] = tensor at the time of `k`. */
static void compose_tensor(const nsdf_tensor_desc *t, const uint64_t offset[3], const float *parameters,
                           const knot_weights *k, float *out, size_t stride) {
    size_t plane = (size_t)t->rows * t->cols;
    const float *a = parameters + offset[0];
    for (uint32_t r = 0; r < t->rows; r++)
        for (uint32_t c = 0; c < t->cols; c++) {
            size_t i = (size_t)r * t->cols + c;
            if (t->kind == NSDF_TENSOR_SPLINE) {
                const float *p = a + k->first * plane + i;
                out[r * stride + c] = k->weight[0] * p[0] + k->weight[1] * p[plane] + k->weight[2] * p[2 * plane] +
                                      k->weight[3] * p[3 * plane];
            } else {
                out[r * stride + c] = a[i];
            }
        }
    if (t->kind != NSDF_TENSOR_LOW_RANK)
        return;
    for (uint32_t q = 0; q < t->rank; q++) {
        float v = control_value(parameters + offset[2] + (size_t)q * t->knots, k);
        const float *m = parameters + offset[1] + q * plane;
        for (uint32_t r = 0; r < t->rows; r++)
            for (uint32_t c = 0; c < t->cols; c++)
                out[r * stride + c] += v * m[(size_t)r * t->cols + c];
    }
}

static knot_weights weights_for(const nsdf_tensor_desc *t, double u) {
    knot_weights k = {0, {0, 0, 0, 0}};
    if (t->kind != NSDF_TENSOR_CONSTANT)
        k.first = nsdf_spline_weights(u, t->knots, k.weight);
    return k;
}

void nsdf_model_compose(const nsdf_model *model, const float *parameters, double u, float *composed) {
    const nsdf_network_desc *d = &model->desc;
    for (uint32_t l = 0; l < d->layer_count; l++) {
        uint32_t w = nsdf_weight_index(d, l);
        size_t in = nsdf_layer_inputs(model, l);
        float *matrix = composed + model->layer_offset[l];
        knot_weights k = weights_for(&d->list.tensors[w], u);
        compose_tensor(&d->list.tensors[w], model->array_offset[w], parameters, &k, matrix, in + 1);
        k = weights_for(&d->list.tensors[w + 1], u);
        compose_tensor(&d->list.tensors[w + 1], model->array_offset[w + 1], parameters, &k, matrix + in, in + 1);
    }
    if (d->input != NSDF_INPUT_FOURIER)
        return;
    float *b = composed + model->fourier_offset;
    if (d->fourier_source == NSDF_FOURIER_STORED)
        memcpy(b, parameters, 4 * (size_t)d->fourier_count * sizeof *b);
    else
        nsdf_fourier_matrix(d->fourier_seed, d->fourier_sigma, d->fourier_count, b);
}

static void scatter_low_rank(const nsdf_tensor_desc *t, const uint64_t offset[3], const float *parameters,
                             const knot_weights *k, const float *g, size_t stride, float *gradient) {
    size_t plane = (size_t)t->rows * t->cols;
    for (uint32_t q = 0; q < t->rank; q++) {
        const float *m = parameters + offset[1] + q * plane;
        float *gm = gradient + offset[1] + q * plane, dot = 0.0f;
        float v = control_value(parameters + offset[2] + (size_t)q * t->knots, k);
        for (uint32_t r = 0; r < t->rows; r++)
            for (uint32_t c = 0; c < t->cols; c++) {
                size_t i = (size_t)r * t->cols + c;
                gm[i] += v * g[r * stride + c];
                dot += m[i] * g[r * stride + c];
            }
        float *gv = gradient + offset[2] + (size_t)q * t->knots + k->first;
        for (int j = 0; j < 4; j++)
            gv[j] += k->weight[j] * dot;
    }
}

static void scatter_tensor(const nsdf_tensor_desc *t, const uint64_t offset[3], const float *parameters,
                           const knot_weights *k, const float *g, size_t stride, float *gradient) {
    size_t plane = (size_t)t->rows * t->cols;
    float *out = gradient + offset[0];
    int spline = t->kind == NSDF_TENSOR_SPLINE;
    for (int j = 0; j < (spline ? 4 : 1); j++) {
        float weight = spline ? k->weight[j] : 1.0f;
        float *o = spline ? out + (k->first + (size_t)j) * plane : out;
        for (uint32_t r = 0; r < t->rows; r++)
            for (uint32_t c = 0; c < t->cols; c++)
                o[(size_t)r * t->cols + c] += weight * g[r * stride + c];
    }
    if (t->kind == NSDF_TENSOR_LOW_RANK)
        scatter_low_rank(t, offset, parameters, k, g, stride, gradient);
}

void nsdf_model_scatter(const nsdf_model *model, const float *parameters, double u, const float *composed_gradient,
                        float *gradient) {
    const nsdf_network_desc *d = &model->desc;
    for (uint32_t l = 0; l < d->layer_count; l++) {
        uint32_t w = nsdf_weight_index(d, l);
        size_t in = nsdf_layer_inputs(model, l);
        const float *g = composed_gradient + model->layer_offset[l];
        knot_weights k = weights_for(&d->list.tensors[w], u);
        scatter_tensor(&d->list.tensors[w], model->array_offset[w], parameters, &k, g, in + 1, gradient);
        k = weights_for(&d->list.tensors[w + 1], u);
        scatter_tensor(&d->list.tensors[w + 1], model->array_offset[w + 1], parameters, &k, g + in, in + 1, gradient);
    }
    if (d->input == NSDF_INPUT_FOURIER && d->fourier_source == NSDF_FOURIER_STORED)
        for (size_t i = 0; i < 4 * (size_t)d->fourier_count; i++)
            gradient[i] += composed_gradient[model->fourier_offset + i];
}
