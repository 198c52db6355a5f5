/* Small random .nsdf files in memory, and a slow evaluation of them in double written from the format's definition. */
#ifndef NSDF_TESTS_MAKE_FILE_H
#define NSDF_TESTS_MAKE_FILE_H

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fourier.h"
#include "network_write.h"

/* Shapes of networks that make_network knows. */
enum {
    MAKE_SPLINE = 0,         /* xyz, sine; first weights and all biases spline */
    MAKE_TIME = 1,           /* xyzt, relu and a tanh output; all constant (the thesis's network, small) */
    MAKE_LOW_RANK = 2,       /* xyz, tanh; low-rank hidden weights, spline biases */
    MAKE_FOURIER_SEED = 3,   /* Fourier features from a seed, relu */
    MAKE_FOURIER_STORED = 4, /* Fourier features stored, sine and low-rank */
    MAKE_SHAPES = 5
};

enum { MAKE_MAX_SEGMENTS = 8 };

typedef struct made_file {
    uint8_t *data;
    size_t size;
    nsdf_file_header header;
    nsdf_index_entry entries[MAKE_MAX_SEGMENTS];
    nsdf_network_desc desc[MAKE_MAX_SEGMENTS];
    float *values[MAKE_MAX_SEGMENTS]; /* dequantised parameters, what a decoder must see */
} made_file;

/* SplitMix64. */
static inline uint64_t make_random(uint64_t *state) {
    uint64_t z = *state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

/* Uniform in [-1, 1). */
static inline double make_uniform(uint64_t *state) {
    return (double)(make_random(state) >> 11) / 4503599627370496.0 - 1.0;
}

static inline void make_tensor(nsdf_tensor_desc *tensor, nsdf_tensor_kind kind, uint32_t rows, uint32_t cols) {
    tensor->kind = (uint8_t)kind;
    tensor->rows = rows;
    tensor->cols = cols;
    tensor->knots = kind == NSDF_TENSOR_CONSTANT ? 0 : 6;
    tensor->rank = kind == NSDF_TENSOR_LOW_RANK ? 3 : 0;
    nsdf_tensor_layout(tensor);
    for (uint32_t i = 0; i < tensor->array_count; i++) {
        nsdf_array_desc *array = &tensor->arrays[i];
        array->quantiser = cols == 1 && rows == 1 ? NSDF_QUANT_RAW : NSDF_QUANT_UNIFORM;
        array->step = array->quantiser == NSDF_QUANT_UNIFORM ? 0.5f / 256.0f : 0.0f;
        array->offset = array->quantiser == NSDF_QUANT_UNIFORM ? 0.25f / 256.0f : 0.0f;
    }
}

static inline nsdf_tensor_kind make_weight_kind(int shape, uint32_t layer) {
    if (shape == MAKE_SPLINE && layer == 0)
        return NSDF_TENSOR_SPLINE;
    if ((shape == MAKE_LOW_RANK || shape == MAKE_FOURIER_STORED) && layer == 1)
        return NSDF_TENSOR_LOW_RANK;
    return NSDF_TENSOR_CONSTANT;
}

static inline void make_layer(int shape, nsdf_layer_desc *layer, uint32_t width, int last) {
    layer->width = width;
    if (shape == MAKE_SPLINE || shape == MAKE_FOURIER_STORED)
        layer->activation = last ? NSDF_ACT_IDENTITY : NSDF_ACT_SINE;
    else if (shape == MAKE_LOW_RANK)
        layer->activation = last ? NSDF_ACT_IDENTITY : NSDF_ACT_TANH;
    else
        layer->activation = last ? NSDF_ACT_TANH : NSDF_ACT_RELU;
    layer->omega = layer->activation == NSDF_ACT_SINE ? 3.0f : 0.0f;
}

/* `layers` layers, the hidden ones `width` wide. */
static inline void make_network(nsdf_network_desc *desc, int shape, uint32_t layers, uint32_t width,
                                nsdf_entropy_kind entropy) {
    const int fourier = shape == MAKE_FOURIER_SEED || shape == MAKE_FOURIER_STORED;
    memset(desc, 0, sizeof *desc);
    desc->input = shape == MAKE_TIME ? NSDF_INPUT_XYZT : fourier ? NSDF_INPUT_FOURIER : NSDF_INPUT_XYZ;
    desc->list.entropy = (uint8_t)entropy;
    desc->time_scale = 0.75f;
    desc->value_scale = 0.125f;
    desc->value_offset = 0.0625f;
    if (fourier) {
        desc->fourier_count = 7;
        desc->fourier_source = shape == MAKE_FOURIER_STORED ? NSDF_FOURIER_STORED : NSDF_FOURIER_SEED;
        desc->fourier_seed = shape == MAKE_FOURIER_SEED ? 99 : 0;
        desc->fourier_sigma = shape == MAKE_FOURIER_SEED ? 0.5f : 0.0f;
    }
    desc->layer_count = layers;
    desc->list.count = nsdf_weight_index(desc, layers);
    if (shape == MAKE_FOURIER_STORED)
        make_tensor(&desc->list.tensors[0], NSDF_TENSOR_CONSTANT, desc->fourier_count, 4);
    uint32_t inputs = nsdf_input_width(desc);
    for (uint32_t l = 0; l < layers; l++) {
        const int last = l + 1 == layers;
        const uint32_t outputs = last ? 1 : width, at = nsdf_weight_index(desc, l);
        const int moves = shape != MAKE_TIME && shape != MAKE_FOURIER_SEED;
        make_layer(shape, &desc->layers[l], outputs, last);
        make_tensor(&desc->list.tensors[at], make_weight_kind(shape, l), outputs, inputs);
        make_tensor(&desc->list.tensors[at + 1], moves ? NSDF_TENSOR_SPLINE : NSDF_TENSOR_CONSTANT, outputs, 1);
        inputs = outputs;
    }
}

/* Random parameters, uniform in +-2 / sqrt(inputs): *q for the writer, *values as a decoder sees them. */
static inline void make_parameters(const nsdf_network_desc *desc, uint64_t *random, int32_t **q, float **values) {
    const size_t count = (size_t)nsdf_parameter_count(&desc->list);
    int32_t *out = *q = malloc(count * sizeof **q);
    float *value = *values = malloc(count * sizeof **values);
    assert(out && value);
    for (uint32_t t = 0; t < desc->list.count; t++) {
        const double range = 2.0 / sqrt((double)desc->list.tensors[t].cols);
        for (uint32_t a = 0; a < desc->list.tensors[t].array_count; a++) {
            const nsdf_array_desc *array = &desc->list.tensors[t].arrays[a];
            for (uint64_t i = 0; i < nsdf_array_size(array); i++, out++, value++) {
                *value = (float)(range * make_uniform(random));
                if (array->quantiser == NSDF_QUANT_RAW) {
                    memcpy(out, value, sizeof *out);
                    continue;
                }
                const int failed = nsdf_quantise(value, 1, array->step, array->offset, out);
                assert(!failed);
                (void)failed;
                *value = nsdf_dequantise(*out, array->step, array->offset);
            }
        }
    }
}

static inline void make_header(nsdf_file_header *header, uint32_t frames, uint32_t segments) {
    memset(header, 0, sizeof *header);
    header->rate_num = 24000;
    header->rate_den = 1001;
    header->frame_count = frames;
    header->segment_count = segments;
    header->scale = 20.0;
    for (int axis = 0; axis < 3; axis++) {
        header->centre[axis] = 1.0 + axis;
        header->box_min[axis] = header->centre[axis] - 5.0;
        header->box_max[axis] = header->centre[axis] + 5.0;
        header->domain_min[axis] = -0.375f;
        header->domain_max[axis] = 0.375f - 0.0625f * (float)axis;
    }
    header->default_resolution = 12;
    header->extraction_bound = 100.0f;
}

/* The segment of file->desc[index], with random parameters. */
static inline void make_segment_of(made_file *file, uint32_t index, uint64_t *random, nsdf_buffer *payload) {
    int32_t *q;
    make_parameters(&file->desc[index], random, &q, &file->values[index]);
    nsdf_write_segment_start(payload, 1);
    const int failed = nsdf_write_network_part(payload, &file->desc[index], q);
    assert(!failed);
    (void)failed;
    file->entries[index].parameter_hash =
        nsdf_hash_floats(NSDF_HASH_START, file->values[index], (size_t)nsdf_parameter_count(&file->desc[index].list));
    file->entries[index].first_frame = 4 * index;
    file->entries[index].last_frame = 4 * index + 4;
    free(q);
}

static inline void make_segment(made_file *file, uint32_t index, int shape, nsdf_entropy_kind entropy, uint32_t layers,
                                uint32_t width, uint64_t *random, nsdf_buffer *payload) {
    if (!nsdf_entropy_available(entropy))
        entropy = NSDF_ENTROPY_RANGE;
    make_network(&file->desc[index], shape, layers, width, entropy);
    make_segment_of(file, index, random, payload);
}

/* Puts the file, whose header is set, together and frees the payloads. */
static inline void make_container_with_header(made_file *file, uint32_t segments, nsdf_buffer *payloads) {
    nsdf_buffer metadata = {NULL, 0, 0, 0}, out = {NULL, 0, 0, 0};
    const nsdf_quality_record quality = {{1e-4, 2e-4}, {3e-4, 4e-4}, {5e-4, 6e-4}, 128, segments * 4 + 1};
    nsdf_write_metadata(&metadata, "title", "small");
    nsdf_write_metadata(&metadata, "empty", "");
    nsdf_file_parts parts = {file->header, payloads, file->entries, &metadata, &quality, NULL, 0};
    const int failed = nsdf_write_file(&out, &parts);
    assert(!failed);
    (void)failed;
    for (uint32_t i = 0; i < segments; i++)
        nsdf_buffer_free(&payloads[i]);
    nsdf_buffer_free(&metadata);
    file->data = malloc(out.size); /* exactly as large, so that a read behind the end is caught */
    assert(file->data);
    memcpy(file->data, out.data, out.size);
    file->size = out.size;
    nsdf_buffer_free(&out);
}

static inline void make_container(made_file *file, uint32_t segments, nsdf_buffer *payloads) {
    make_header(&file->header, segments * 4 + 1, segments);
    make_container_with_header(file, segments, payloads);
}

/* A file of `segments` segments of four frame steps each; shapes and entropy back ends take turns from `shape` and
 * `entropy` on.  free_file frees it. */
static inline void make_sized_file(made_file *file, uint32_t segments, int shape, nsdf_entropy_kind entropy,
                                   uint32_t layers, uint32_t width, uint64_t seed) {
    nsdf_buffer payloads[MAKE_MAX_SEGMENTS] = {{NULL, 0, 0, 0}};
    assert(segments <= MAKE_MAX_SEGMENTS);
    memset(file, 0, sizeof *file);
    for (uint32_t i = 0; i < segments; i++)
        make_segment(file, i, (shape + (int)i) % MAKE_SHAPES, (nsdf_entropy_kind)((entropy + i) % NSDF_ENTROPY_COUNT),
                     layers, width, &seed, &payloads[i]);
    make_container(file, segments, payloads);
}

static inline void make_file(made_file *file, uint32_t segments, int shape, nsdf_entropy_kind entropy, uint64_t seed) {
    make_sized_file(file, segments, shape, entropy, 3, 12, seed);
}

static inline void free_file(made_file *file) {
    free(file->data);
    for (int i = 0; i < MAKE_MAX_SEGMENTS; i++)
        free(file->values[i]);
    memset(file, 0, sizeof *file);
}

/* ---- Evaluation from the definition --------------------------------------------------------------------- */

/* The cubic cardinal B-spline around 0, support (-2, 2). */
static inline double reference_basis(double x) {
    const double a = fabs(x);
    if (a < 1.0)
        return 2.0 / 3.0 - a * a + a * a * a / 2.0;
    return a < 2.0 ? (2.0 - a) * (2.0 - a) * (2.0 - a) / 6.0 : 0.0;
}

/* sum_k point_k B(s - k + 1) at s = u (knots - 3), points `stride` apart. */
static inline double reference_spline(const float *points, uint32_t knots, size_t stride, double u) {
    double sum = 0.0;
    for (uint32_t k = 0; k < knots; k++)
        sum += (double)points[k * stride] * reference_basis(u * (double)(knots - 3) - (double)k + 1.0);
    return sum;
}

/* Element `e` of a tensor at u. */
static inline double reference_element(const nsdf_tensor_desc *tensor, const float *values, size_t e, double u) {
    const size_t plane = (size_t)tensor->rows * tensor->cols;
    if (tensor->kind == NSDF_TENSOR_CONSTANT)
        return (double)values[e];
    if (tensor->kind == NSDF_TENSOR_SPLINE)
        return reference_spline(values + e, tensor->knots, plane, u);
    const float *points = values + (1 + (size_t)tensor->rank) * plane;
    double sum = (double)values[e];
    for (size_t r = 0; r < tensor->rank; r++)
        sum += reference_spline(points + r * tensor->knots, tensor->knots, 1, u) * (double)values[(1 + r) * plane + e];
    return sum;
}

static inline const float *reference_values(const nsdf_network_desc *desc, const float *values, uint32_t tensor) {
    for (uint32_t t = 0; t < tensor; t++)
        for (uint32_t a = 0; a < desc->list.tensors[t].array_count; a++)
            values += nsdf_array_size(&desc->list.tensors[t].arrays[a]);
    return values;
}

static inline double reference_activation(const nsdf_layer_desc *layer, double z) {
    switch (layer->activation) {
    case NSDF_ACT_RELU:
        return z > 0.0 ? z : 0.0;
    case NSDF_ACT_SINE:
        return sin((double)layer->omega * z);
    case NSDF_ACT_TANH:
        return tanh(z);
    default:
        return z;
    }
}

static inline void reference_fourier(const nsdf_network_desc *desc, const float *values, const double v[4],
                                     double *features) {
    float seeded[4 * NSDF_MAX_FOURIER];
    const float *b = values;
    if (desc->fourier_source == NSDF_FOURIER_SEED) {
        nsdf_fourier_matrix(desc->fourier_seed, desc->fourier_sigma, desc->fourier_count, seeded);
        b = seeded;
    }
    for (uint32_t i = 0; i < desc->fourier_count; i++) {
        double phase = 0.0;
        for (int k = 0; k < 4; k++)
            phase += 2.0 * 3.14159265358979323846 * (double)b[4 * i + (uint32_t)k] * v[k];
        features[i] = cos(phase);
        features[desc->fourier_count + i] = sin(phase);
    }
}

/* Normalised signed distance at a normalised position, u in [0, 1] over the segment. */
static inline double reference_value(const nsdf_network_desc *desc, const float *values, double u,
                                     const double xyz[3]) {
    double in[2 * NSDF_MAX_WIDTH] = {xyz[0], xyz[1], xyz[2], (double)desc->time_scale * u}, out[NSDF_MAX_WIDTH];
    uint32_t inputs = nsdf_input_width(desc);
    if (desc->input == NSDF_INPUT_FOURIER) {
        const double v[4] = {in[0], in[1], in[2], in[3]};
        reference_fourier(desc, values, v, in);
    }
    for (uint32_t l = 0; l < desc->layer_count; l++) {
        const uint32_t at = nsdf_weight_index(desc, l);
        const float *weights = reference_values(desc, values, at), *biases = reference_values(desc, values, at + 1);
        for (uint32_t o = 0; o < desc->layers[l].width; o++) {
            double z = reference_element(&desc->list.tensors[at + 1], biases, o, u);
            for (uint32_t i = 0; i < inputs; i++)
                z += in[i] * reference_element(&desc->list.tensors[at], weights, (size_t)o * inputs + i, u);
            out[o] = reference_activation(&desc->layers[l], z);
        }
        inputs = desc->layers[l].width;
        memcpy(in, out, inputs * sizeof *in);
    }
    return (double)desc->value_scale * in[0] + (double)desc->value_offset;
}

#endif
