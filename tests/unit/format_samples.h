/* Random networks and a small whole file for the tests of format/. */
#ifndef NSDF_FORMAT_SAMPLES_H
#define NSDF_FORMAT_SAMPLES_H

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "network_write.h"

/* SplitMix64; *state is the seed. */
static inline uint64_t sample_next(uint64_t *state) {
    uint64_t z = *state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

static inline uint32_t sample_below(uint64_t *state, uint32_t count) {
    return (uint32_t)(sample_next(state) >> 32) % count;
}

/* In (0, 1). */
static inline double sample_unit(uint64_t *state) {
    return ((double)(sample_next(state) >> 11) + 0.5) / 9007199254740992.0;
}

static inline double sample_gauss(uint64_t *state) {
    return sqrt(-2.0 * log(sample_unit(state))) * cos(6.283185307179586 * sample_unit(state));
}

/* Laplace distribution of variance 1. */
static inline double sample_laplace(uint64_t *state) {
    double u = sample_unit(state) - 0.5;
    return (u < 0.0 ? 1.0 : -1.0) * log(1.0 - 2.0 * fabs(u)) / sqrt(2.0);
}

static inline void sample_tensor(uint64_t *rng, nsdf_tensor_desc *t, uint32_t kind, uint32_t rows, uint32_t cols) {
    t->kind = (uint8_t)kind;
    t->rows = rows;
    t->cols = cols;
    t->knots = kind == NSDF_TENSOR_CONSTANT ? 0 : 4 + sample_below(rng, 5);
    t->rank = kind == NSDF_TENSOR_LOW_RANK ? 1 + sample_below(rng, 3) : 0;
    nsdf_tensor_layout(t);
    for (uint32_t k = 0; k < t->array_count; k++) {
        nsdf_array_desc *a = &t->arrays[k];
        a->quantiser = sample_below(rng, 4) ? NSDF_QUANT_UNIFORM : NSDF_QUANT_RAW;
        a->step = a->quantiser == NSDF_QUANT_UNIFORM ? 0.001f * (float)(1 + sample_below(rng, 50)) : 0.0f;
        a->offset = a->quantiser == NSDF_QUANT_UNIFORM ? 0.1f * (float)sample_below(rng, 10) : 0.0f;
    }
}

/* A valid description of random shape, with every kind of input, activation and tensor. */
static inline void sample_network(uint64_t *rng, nsdf_network_desc *d, nsdf_entropy_kind entropy) {
    memset(d, 0, sizeof *d);
    d->input = (uint8_t)sample_below(rng, 3);
    d->list.entropy = (uint8_t)entropy;
    if (d->input == NSDF_INPUT_FOURIER) {
        d->fourier_source = (uint8_t)sample_below(rng, 2);
        d->fourier_count = 1 + sample_below(rng, 6);
        d->fourier_seed = d->fourier_source == NSDF_FOURIER_SEED ? sample_next(rng) : 0;
        d->fourier_sigma = d->fourier_source == NSDF_FOURIER_SEED ? 2.5f : 0.0f;
    }
    d->time_scale = 1.5f;
    d->value_scale = 0.75f;
    d->value_offset = -0.125f;
    d->layer_count = 1 + sample_below(rng, 4);
    d->list.count = nsdf_weight_index(d, d->layer_count);
    if (nsdf_weight_index(d, 0) == 1)
        sample_tensor(rng, &d->list.tensors[0], NSDF_TENSOR_CONSTANT, d->fourier_count, 4);
    uint32_t inputs = nsdf_input_width(d);
    for (uint32_t i = 0; i < d->layer_count; i++) {
        nsdf_layer_desc *layer = &d->layers[i];
        layer->width = i + 1 < d->layer_count ? 1 + sample_below(rng, 20) : 1;
        layer->activation = (uint8_t)sample_below(rng, 4);
        layer->omega = layer->activation == NSDF_ACT_SINE ? 30.0f : 0.0f;
        uint32_t w = nsdf_weight_index(d, i);
        sample_tensor(rng, &d->list.tensors[w], sample_below(rng, 3), layer->width, inputs);
        sample_tensor(rng, &d->list.tensors[w + 1], sample_below(rng, 3), layer->width, 1);
        inputs = layer->width;
    }
}

/* Quantised parameters of all arrays, sometimes alike from plane to plane, sometimes constant. */
static inline int32_t *sample_parameters(uint64_t *rng, const nsdf_network_desc *d) {
    int32_t *q = malloc((size_t)nsdf_parameter_count(&d->list) * sizeof *q), *out = q;
    assert_non_null(q);
    for (uint32_t t = 0; t < d->list.count; t++)
        for (uint32_t k = 0; k < d->list.tensors[t].array_count; k++) {
            const nsdf_array_desc *a = &d->list.tensors[t].arrays[k];
            size_t plane = (size_t)a->rows * a->cols;
            double spread = pow(10.0, 5.0 * sample_unit(rng) - 1.0), change = spread * pow(sample_unit(rng), 4.0);
            for (size_t i = 0; i < plane * a->planes; i++, out++) {
                float raw = (float)sample_gauss(rng);
                *out = i < plane ? (int32_t)lrint(spread * sample_gauss(rng))
                                 : *(out - plane) + (int32_t)lrint(change * sample_gauss(rng));
                if (a->quantiser == NSDF_QUANT_RAW)
                    memcpy(out, &raw, sizeof raw);
            }
        }
    return q;
}

/* What a decoder must give for q. */
static inline float *sample_expected(const nsdf_network_desc *d, const int32_t *q) {
    float *values = malloc((size_t)nsdf_parameter_count(&d->list) * sizeof *values), *out = values;
    assert_non_null(values);
    for (uint32_t t = 0; t < d->list.count; t++)
        for (uint32_t k = 0; k < d->list.tensors[t].array_count; k++) {
            const nsdf_array_desc *a = &d->list.tensors[t].arrays[k];
            for (uint64_t i = 0; i < nsdf_array_size(a); i++, out++, q++) {
                if (a->quantiser == NSDF_QUANT_RAW)
                    memcpy(out, q, sizeof *out);
                else
                    *out = nsdf_dequantise(*q, a->step, a->offset);
            }
        }
    return values;
}

/* The part alone, as a heap block of exactly its size, so that ASan sees any read beyond. */
static inline uint8_t *sample_part(nsdf_network_desc *d, const int32_t *q, size_t *size) {
    nsdf_buffer payload = {0};
    nsdf_part_ref parts[NSDF_MAX_PARTS];
    uint32_t count = 0;
    nsdf_write_segment_start(&payload, 1);
    assert_int_equal(nsdf_write_network_part(&payload, d, q), 0);
    assert_int_equal(nsdf_read_parts(payload.data, payload.size, parts, &count, NULL), NSDF_PARSE_OK);
    assert_int_equal(count, 1);
    uint8_t *part = malloc(parts[0].size);
    assert_non_null(part);
    memcpy(part, parts[0].data, parts[0].size);
    *size = parts[0].size;
    nsdf_buffer_free(&payload);
    return part;
}

/* Description and parameters together; *values is allocated on success. */
static inline nsdf_parse sample_decode(const uint8_t *part, size_t size, float **values, nsdf_fault *fault) {
    nsdf_network_desc *d = malloc(sizeof *d);
    size_t coded = 0;
    assert_non_null(d);
    *values = NULL;
    nsdf_parse status = nsdf_read_network_desc(part, size, d, &coded, fault);
    if (status == NSDF_PARSE_OK && nsdf_parameter_count(&d->list) > 1u << 22)
        status = NSDF_PARSE_NO_MEMORY;
    if (status == NSDF_PARSE_OK) {
        size_t scratch_size = nsdf_parameter_scratch_size(&d->list);
        void *scratch = malloc(scratch_size ? scratch_size : 1);
        *values = malloc((size_t)nsdf_parameter_count(&d->list) * sizeof **values);
        assert_true(scratch && *values);
        status = nsdf_read_parameters(part, size, coded, &d->list, scratch, NULL, *values, fault);
        free(scratch);
    }
    if (status != NSDF_PARSE_OK) {
        free(*values);
        *values = NULL;
    }
    free(d);
    return status;
}

#endif
