/* Small models, meshes and files for the tests of fitting. */
#ifndef FIT_SAMPLES_H
#define FIT_SAMPLES_H

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "container.h"
#include "geometry_shapes.h"
#include "model.h"
#include "nsdf/encoder.h"

/* Options of a network that fits in a test's time. */
static inline nsdf_encoder_options sample_options(uint32_t layers, uint32_t width) {
    nsdf_encoder_options o;
    nsdf_encoder_options_init(&o, NSDF_PRESET_FAST);
    o.layers = layers;
    o.width = width;
    o.blocks = 0;
    o.threads = 1;
    return o;
}

/* Every combination of input and tensor kinds that the encoder makes: bit 0 of `kind` turns the output's tanh on. */
enum { SAMPLE_MODELS = 12 };
static inline nsdf_encoder_options sample_model_options(int kind, uint32_t layers, uint32_t width) {
    static const nsdf_tensor_time times[3] = {NSDF_TIME_CONSTANT, NSDF_TIME_SPLINE, NSDF_TIME_LOW_RANK};
    nsdf_encoder_options o = sample_options(layers, width);
    const int shape = kind / 2;
    o.output_tanh = kind % 2;
    o.rank = 3;
    o.knot_spacing = 2.0;
    o.fourier_features = 5;
    o.fourier_sigma = 0.6;
    o.omega_first = 5.0;
    o.omega_hidden = 1.5;
    o.weight_time = shape < 3 ? times[shape] : NSDF_TIME_CONSTANT;
    o.input = shape < 3 ? NSDF_MODEL_XYZ : shape == 3 ? NSDF_MODEL_XYZT : NSDF_MODEL_FOURIER;
    o.fourier_trained = shape == 5;
    o.activation = (nsdf_model_activation)(kind % 3);
    return o;
}

/* `count` floats, uniform in +-range. */
static inline float *random_floats(size_t count, float range, uint64_t seed) {
    nsdf_random random = nsdf_random_start(seed, 77);
    float *values = malloc(count * sizeof *values + 1);
    assert(values);
    for (size_t i = 0; i < count; i++)
        values[i] = range * (2.0f * nsdf_random_unit(&random) - 1.0f);
    return values;
}

/* First values of a model, moved a little at random so that no two knots agree. */
static inline float *random_parameters(const nsdf_model *model, uint64_t seed) {
    nsdf_random random = nsdf_random_start(seed, 78);
    float *values = random_floats((size_t)model->parameter_count, 0.1f, seed);
    float *first = malloc((size_t)model->parameter_count * sizeof *first + 1);
    assert(first);
    nsdf_model_initialise(model, &random, first);
    for (uint64_t i = 0; i < model->parameter_count; i++)
        values[i] += first[i];
    free(first);
    return values;
}

/* A file of `frames` frames at one a second, whose world units are the normalised ones; domain +-0.5. */
static inline nsdf_file_header unit_header(uint32_t frames) {
    nsdf_file_header h;
    memset(&h, 0, sizeof h);
    h.rate_num = h.rate_den = 1;
    h.frame_count = frames;
    h.segment_count = 1;
    h.scale = 1.0;
    for (int k = 0; k < 3; k++) {
        h.box_min[k] = -0.25;
        h.box_max[k] = 0.25;
        h.domain_min[k] = -0.5f;
        h.domain_max[k] = 0.5f;
    }
    h.default_resolution = 16;
    h.extraction_bound = 100.0f;
    return h;
}

/* Doubles for the encoder: surface * scale + offset.  Free positions. */
static inline nsdf_input_mesh mesh_of(const nsdf_surface *s, double scale, double x, double y, double z) {
    const double offset[3] = {x, y, z};
    double *p = malloc(3 * sizeof *p * ((size_t)s->vertex_count + 1));
    assert(p);
    for (size_t i = 0; i < 3 * (size_t)s->vertex_count; i++)
        p[i] = (double)s->positions[i] * scale + offset[i % 3];
    nsdf_input_mesh mesh = {p, s->indices, s->vertex_count, s->triangle_count};
    return mesh;
}

#endif
