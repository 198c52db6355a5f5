#include "fit_network.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { TILE_PANELS = 16, TILE = TILE_PANELS * NSDF_PANEL };

struct nsdf_fit_scratch {
    float *block; /* everything below is cut from it */
    float
        *input[NSDF_MAX_LAYERS + 1]; /* [panel][inputs + 1][PANEL], the last row is ones; [layer_count] is the output */
    float *slope[NSDF_MAX_LAYERS];   /* [panel][outputs][PANEL]: act' */
    float *dz[2];                    /* [panel][widest][PANEL] */
    float *transposed;               /* of the widest layer */
    float *point, *projection, *projection_slope; /* Fourier: [panel][4], [panel][count], [panel][count] */
    float f[TILE], d[TILE], df[TILE];
};

/* ---- Scratch -------------------------------------------------------------------------------------------- */

/* Offsets first (block NULL), then pointers: the same walk serves both. */
static float *take(float *block, size_t *at, size_t rows) {
    float *p = block ? block + *at : NULL;
    *at += rows * TILE;
    return p;
}

static size_t cut_scratch(const nsdf_model *model, nsdf_fit_scratch *s) {
    const nsdf_network_desc *d = &model->desc;
    size_t at = 0, transposed = 0;
    for (uint32_t l = 0; l < d->layer_count; l++) {
        size_t in = nsdf_layer_inputs(model, l), out = d->layers[l].width;
        s->input[l] = take(s->block, &at, in + 1);
        s->slope[l] = take(s->block, &at, out);
        transposed = in * out > transposed ? in * out : transposed;
    }
    s->input[d->layer_count] = take(s->block, &at, 2);
    s->dz[0] = take(s->block, &at, model->widest);
    s->dz[1] = take(s->block, &at, model->widest);
    s->transposed = take(s->block, &at, (transposed + TILE - 1) / TILE);
    if (d->input == NSDF_INPUT_FOURIER) {
        s->point = take(s->block, &at, 4);
        s->projection = take(s->block, &at, d->fourier_count);
        s->projection_slope = take(s->block, &at, d->fourier_count);
    }
    return at;
}

static void set_row(float *matrix, size_t rows, size_t row, uint32_t panels, const float *values, size_t count,
                    float fill) {
    for (uint32_t k = 0; k < panels; k++)
        for (size_t p = 0; p < NSDF_PANEL; p++) {
            size_t i = k * (size_t)NSDF_PANEL + p;
            matrix[(k * rows + row) * NSDF_PANEL + p] = values && i < count ? values[i] : fill;
        }
}

nsdf_fit_scratch *nsdf_fit_scratch_create(const nsdf_model *model) {
    nsdf_fit_scratch *s = calloc(1, sizeof *s);
    if (!s)
        return NULL;
    size_t bytes = cut_scratch(model, s) * sizeof(float);
    void *block = NULL;
    if (posix_memalign(&block, 64, bytes) != 0) {
        free(s);
        return NULL;
    }
    memset(block, 0, bytes);
    s->block = block;
    cut_scratch(model, s);
    for (uint32_t l = 0; l < model->desc.layer_count; l++) {
        size_t in = nsdf_layer_inputs(model, l);
        set_row(s->input[l], in + 1, in, TILE_PANELS, NULL, 0, 1.0f);
    }
    return s;
}

void nsdf_fit_scratch_free(nsdf_fit_scratch *scratch) {
    if (scratch)
        free(scratch->block);
    free(scratch);
}

/* ---- Forward -------------------------------------------------------------------------------------------- */

static void set_position(float *matrix, size_t rows, uint32_t panels, const nsdf_fit_points *points, int with_time) {
    set_row(matrix, rows, 0, panels, points->x, points->count, 0.0f);
    set_row(matrix, rows, 1, panels, points->y, points->count, 0.0f);
    set_row(matrix, rows, 2, panels, points->z, points->count, 0.0f);
    if (with_time)
        set_row(matrix, rows, 3, panels, NULL, 0, points->time);
}

/* Thesis (5.14): cos(2 pi B v) in the first rows, sin(2 pi B v) in the others. */
static void fourier_features(const nsdf_model *model, const nsdf_fit_kernels *kernels, nsdf_fit_scratch *s,
                             const float *composed, const nsdf_fit_points *points, uint32_t panels) {
    const float two_pi = 6.28318530718f;
    size_t count = model->desc.fourier_count, row = NSDF_PANEL;
    set_position(s->point, 4, panels, points, 1);
    kernels->multiply(composed + model->fourier_offset, 4, (uint32_t)count, 4, s->point, 4 * row, s->projection,
                      count * row, panels);
    kernels->sine(s->projection, s->projection_slope, panels * count * row, two_pi);
    for (uint32_t k = 0; k < panels; k++) {
        float *x = s->input[0] + k * (2 * count + 1) * row;
        const float *sine = s->projection + k * count * row, *slope = s->projection_slope + k * count * row;
        for (size_t i = 0; i < count * row; i++)
            x[i] = slope[i] * (1.0f / two_pi);
        memcpy(x + count * row, sine, count * row * sizeof *x);
    }
}

static void activate(const nsdf_layer_desc *layer, const nsdf_fit_kernels *kernels, float *z, float *slope,
                     size_t count) {
    if (layer->activation == NSDF_ACT_SINE)
        kernels->sine(z, slope, count, layer->omega);
    else if (layer->activation == NSDF_ACT_RELU)
        kernels->relu(z, slope, count);
    else if (layer->activation == NSDF_ACT_TANH)
        kernels->tanh(z, slope, count);
    else
        for (size_t i = 0; i < count; i++)
            slope[i] = 1.0f;
}

/* The products of a layer.  Between hidden layers factors are sines or the like, which fit as well when they are
 * rounded to bf16; positions and the distance itself want all their bits. */
typedef struct {
    nsdf_fit_multiply *multiply;
    nsdf_fit_outer *outer;
} layer_products;

static layer_products products_of(const nsdf_network_desc *d, uint32_t layer, const nsdf_fit_kernels *kernels) {
    if (layer > 0 && layer + 1 < d->layer_count)
        return (layer_products){kernels->multiply_short, kernels->outer_short};
    return (layer_products){kernels->multiply, kernels->outer};
}

/* Runs one tile; leaves every layer's inputs and slopes in the scratch memory, and values in s->f. */
static void forward_tile(const nsdf_model *model, const nsdf_fit_kernels *kernels, nsdf_fit_scratch *s,
                         const float *composed, const nsdf_fit_points *points, uint32_t panels) {
    const nsdf_network_desc *d = &model->desc;
    size_t first = nsdf_input_width(d);
    if (d->input == NSDF_INPUT_FOURIER)
        fourier_features(model, kernels, s, composed, points, panels);
    else
        set_position(s->input[0], first + 1, panels, points, d->input == NSDF_INPUT_XYZT);
    for (uint32_t l = 0; l < d->layer_count; l++) {
        size_t in = nsdf_layer_inputs(model, l), out = d->layers[l].width;
        const layer_products product = products_of(d, l, kernels);
        product.multiply(composed + model->layer_offset[l], in + 1, (uint32_t)out, (uint32_t)in + 1, s->input[l],
                         (in + 1) * NSDF_PANEL, s->input[l + 1], (out + 1) * NSDF_PANEL, panels);
        for (uint32_t k = 0; k < panels; k++) {
            activate(&d->layers[l], kernels, s->input[l + 1] + k * (out + 1) * NSDF_PANEL,
                     s->slope[l] + k * out * NSDF_PANEL, out * NSDF_PANEL);
        }
    }
    const float *y = s->input[d->layer_count];
    for (uint32_t k = 0; k < panels; k++)
        for (size_t p = 0; p < NSDF_PANEL; p++)
            s->f[k * NSDF_PANEL + p] = d->value_scale * y[2 * k * NSDF_PANEL + p] + d->value_offset;
}

static nsdf_fit_points tile_of(const nsdf_fit_points *points, size_t from) {
    size_t left = points->count - from;
    nsdf_fit_points tile = {points->x + from,          points->y + from,
                            points->z + from,          points->d ? points->d + from : NULL,
                            left < TILE ? left : TILE, points->time};
    return tile;
}

void nsdf_fit_forward(const nsdf_model *model, const nsdf_fit_kernels *kernels, nsdf_fit_scratch *scratch,
                      const float *composed, const nsdf_fit_points *points, float *f) {
    for (size_t i = 0; i < points->count; i += TILE) {
        nsdf_fit_points tile = tile_of(points, i);
        forward_tile(model, kernels, scratch, composed, &tile, (uint32_t)((tile.count + NSDF_PANEL - 1) / NSDF_PANEL));
        memcpy(f + i, scratch->f, tile.count * sizeof *f);
    }
}

/* ---- Backward ------------------------------------------------------------------------------------------- */

/* W^T [in][out] without the bias column. */
static void transpose(const float *matrix, size_t out, size_t in, float *transposed) {
    for (size_t o = 0; o < out; o++)
        for (size_t i = 0; i < in; i++)
            transposed[i * out + o] = matrix[o * (in + 1) + i];
}

/* Gradient of B from that of the features, which is in `dx`. */
static void fourier_backward(const nsdf_model *model, const nsdf_fit_kernels *kernels, nsdf_fit_scratch *s, float *dx,
                             float *gradient, uint32_t panels) {
    const float two_pi = 6.28318530718f;
    size_t half = (size_t)model->desc.fourier_count * NSDF_PANEL;
    for (uint32_t k = 0; k < panels; k++) {
        const float *dcos = dx + k * 2 * half, *dsin = dcos + half;
        float *sine = s->projection + k * half, *slope = s->projection_slope + k * half;
        for (size_t i = 0; i < half; i++)
            slope[i] = dsin[i] * slope[i] - two_pi * dcos[i] * sine[i];
    }
    kernels->outer(s->projection_slope, half, model->desc.fourier_count, s->point, 4 * NSDF_PANEL, 4,
                   gradient + model->fourier_offset, 4, panels);
}

static void backward_tile(const nsdf_model *model, const nsdf_fit_kernels *kernels, nsdf_fit_scratch *s,
                          const float *composed, float *gradient, uint32_t panels) {
    const nsdf_network_desc *d = &model->desc;
    int train_b = d->input == NSDF_INPUT_FOURIER && d->fourier_source == NSDF_FOURIER_STORED;
    float *dz = s->dz[0], *dx = s->dz[1];
    for (size_t i = 0; i < (size_t)panels * NSDF_PANEL; i++)
        dz[i] = s->df[i] * d->value_scale * s->slope[d->layer_count - 1][i];
    for (uint32_t l = d->layer_count; l-- > 0;) {
        size_t in = nsdf_layer_inputs(model, l), out = d->layers[l].width;
        const layer_products product = products_of(d, l, kernels);
        product.outer(dz, out * NSDF_PANEL, (uint32_t)out, s->input[l], (in + 1) * NSDF_PANEL, (uint32_t)in + 1,
                      gradient + model->layer_offset[l], in + 1, panels);
        if (l == 0 && !train_b)
            break;
        transpose(composed + model->layer_offset[l], out, in, s->transposed);
        product.multiply(s->transposed, out, (uint32_t)in, (uint32_t)out, dz, out * NSDF_PANEL, dx, in * NSDF_PANEL,
                         panels);
        if (l == 0)
            fourier_backward(model, kernels, s, dx, gradient, panels);
        else
            kernels->scale(dx, s->slope[l - 1], panels * in * NSDF_PANEL);
        float *t = dz;
        dz = dx;
        dx = t;
    }
}

static void add_near_error(const float *f, const float *d, size_t count, nsdf_fit_sums *sums) {
    for (size_t i = 0; i < count; i++)
        if (fabsf(d[i]) < NSDF_NEAR_LIMIT) {
            sums->near_error += (double)fabsf(f[i] - d[i]);
            sums->near_count++;
        }
}

void nsdf_fit_backward(const nsdf_model *model, const nsdf_fit_kernels *kernels, nsdf_fit_scratch *s,
                       const float *composed, const nsdf_fit_points *points, const nsdf_loss_params *loss,
                       float gradient_scale, float *gradient, float *losses, nsdf_fit_sums *sums) {
    for (size_t i = 0; i < points->count; i += TILE) {
        nsdf_fit_points tile = tile_of(points, i);
        uint32_t panels = (uint32_t)((tile.count + NSDF_PANEL - 1) / NSDF_PANEL);
        forward_tile(model, kernels, s, composed, &tile, panels);
        sums->loss +=
            nsdf_loss_batch(loss, s->f, tile.d, tile.count, gradient_scale, s->df, losses ? losses + i : NULL);
        for (size_t p = tile.count; p < (size_t)panels * NSDF_PANEL; p++)
            s->df[p] = 0.0f;
        add_near_error(s->f, tile.d, tile.count, sums);
        backward_tile(model, kernels, s, composed, gradient, panels);
    }
}
