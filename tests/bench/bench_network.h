/* Networks as the encoder begins to fit them, and what they are fitted to, for benches of fitting. */
#ifndef BENCH_NETWORK_H
#define BENCH_NETWORK_H

#include <stdlib.h>

#include "bench_util.h"
#include "model.h"
#include "nsdf/encoder.h"
#include "random.h"

/* From -range to range, to be freed. */
static inline float *bench_random_floats(size_t count, float range, uint64_t seed) {
    nsdf_random random = nsdf_random_start(seed, 1);
    float *values = bench_floats(count);
    for (size_t i = 0; i < count; i++)
        values[i] = range * (2.0f * nsdf_random_unit(&random) - 1.0f);
    return values;
}

/* Describes a network of preset fast with so many layers and neurons, and composes its first values at the middle of
 * the time: [model->composed_size], to be freed. */
static inline float *bench_network(nsdf_model *model, uint32_t layers, uint32_t width, uint32_t frames) {
    nsdf_encoder_options options;
    nsdf_random random = nsdf_random_start(1, 2);
    nsdf_encoder_options_init(&options, NSDF_PRESET_FAST);
    options.layers = layers;
    options.width = width;
    nsdf_model_describe(model, &options, frames);
    float *parameters = bench_floats((size_t)model->parameter_count);
    nsdf_model_initialise(model, &random, parameters);
    float *composed = bench_floats(model->composed_size);
    nsdf_model_compose(model, parameters, 0.5, composed);
    free(parameters);
    return composed;
}

#endif
