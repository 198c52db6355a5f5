/* Composing and evaluating a network.  The gradient is reverse mode: one more pass over transposed weights, which costs
 * about as much as the value itself, where forward mode would cost three times that. */
#include "network.h"
#include "compose.h"
#include "fourier.h"

#include <string.h>

static const double pi = 3.14159265358979323846;

static uint32_t static_inputs(const nsdf_network_desc *desc) {
    return desc->input == NSDF_INPUT_FOURIER ? 2 * desc->fourier_count : 3;
}

static uint32_t encoding_outputs(const nsdf_network_desc *desc) {
    return desc->input == NSDF_INPUT_FOURIER ? desc->fourier_count : 0;
}

static int has_seeded_fourier(const nsdf_network_desc *desc) {
    return desc->input == NSDF_INPUT_FOURIER && desc->fourier_source == NSDF_FOURIER_SEED;
}

static uint64_t layer_storage(uint64_t inputs, uint64_t outputs) {
    return 2 * inputs * outputs + outputs;
}

uint64_t nsdf_network_storage(const nsdf_network_desc *desc) {
    uint64_t total = layer_storage(3, encoding_outputs(desc));
    uint64_t inputs = static_inputs(desc);
    for (uint32_t l = 0; l < desc->layer_count; l++) {
        total += layer_storage(inputs, desc->layers[l].width);
        inputs = desc->layers[l].width;
    }
    return total + (has_seeded_fourier(desc) ? 4 * (uint64_t)desc->fourier_count : 0);
}

static float *init_layer(nsdf_net_layer *layer, uint32_t inputs, uint32_t outputs, float *storage) {
    const size_t size = (size_t)inputs * outputs;
    layer->inputs = inputs;
    layer->outputs = outputs;
    layer->weights = storage;
    layer->transposed = storage + size;
    layer->bias = storage + 2 * size;
    return layer->bias + outputs;
}

void nsdf_network_init(nsdf_network *network, const nsdf_network_desc *desc, float *storage) {
    memset(network, 0, sizeof *network);
    network->layer_count = desc->layer_count;
    network->value_scale = desc->value_scale;
    network->value_offset = desc->value_offset;
    storage = init_layer(&network->encoding, 3, encoding_outputs(desc), storage);
    uint32_t inputs = static_inputs(desc);
    for (uint32_t l = 0; l < desc->layer_count; l++) {
        network->layers[l].activation = (nsdf_activation)desc->layers[l].activation;
        storage = init_layer(&network->layers[l], inputs, desc->layers[l].width, storage);
        inputs = desc->layers[l].width;
    }
    if (has_seeded_fourier(desc)) {
        network->fourier = storage;
        nsdf_fourier_matrix(desc->fourier_seed, desc->fourier_sigma, desc->fourier_count, network->fourier);
    }
}

/* Packs factor * W.  A column beyond the layer's inputs belongs to time, which is the same for all points: it goes to
 * bias[row] instead. */
static void set_weights(nsdf_net_layer *layer, const nsdf_blend *weights, double factor, double time, double *bias) {
    double row[2 * NSDF_MAX_FOURIER > NSDF_MAX_WIDTH ? 2 * NSDF_MAX_FOURIER : NSDF_MAX_WIDTH];
    const uint32_t inputs = layer->inputs, outputs = layer->outputs;
    for (uint32_t o = 0; o < outputs; o++) {
        nsdf_blend_row(weights, o, row);
        for (uint32_t i = 0; i < inputs; i++) {
            const float w = (float)(factor * row[i]);
            layer->weights[nsdf_panel_index(outputs, inputs, o, i)] = w;
            layer->transposed[nsdf_panel_index(inputs, outputs, i, o)] = w;
        }
        bias[o] = weights->cols > inputs ? row[inputs] * time : 0.0;
    }
}

/* Phases in half turns: 2 B v, so that cos(pi z) = cos(2 pi B v) (thesis 5.14). */
static void compose_encoding(nsdf_network *network, const nsdf_blend *b, double time) {
    double bias[NSDF_MAX_FOURIER];
    set_weights(&network->encoding, b, 2.0, time, bias);
    for (uint32_t o = 0; o < network->encoding.outputs; o++)
        network->encoding.bias[o] = (float)(2.0 * bias[o]);
}

/* sin(omega (W x + b)) = sin(pi (W' x + b')) with W' = W omega / pi. */
static void compose_layer(nsdf_net_layer *layer, const nsdf_layer_desc *desc, const nsdf_blend *weights,
                          const nsdf_blend *biases, double time) {
    const double factor = desc->activation == NSDF_ACT_SINE ? (double)desc->omega / pi : 1.0;
    double bias[NSDF_MAX_WIDTH], own;
    set_weights(layer, weights, factor, time, bias);
    for (uint32_t o = 0; o < layer->outputs; o++) {
        nsdf_blend_row(biases, o, &own);
        layer->bias[o] = (float)(factor * (bias[o] + own));
    }
}

static void blend_seeded_fourier(nsdf_blend *blend, const nsdf_network *network) {
    blend->rows = network->encoding.outputs;
    blend->cols = 4;
    blend->count = 1;
    blend->planes[0] = network->fourier;
    blend->weights[0] = 1.0;
}

void nsdf_network_compose(nsdf_network *network, const nsdf_network_desc *desc, const float *values, double u) {
    const nsdf_tensor_desc *tensor = desc->list.tensors;
    const double time = (double)desc->time_scale * u;
    nsdf_blend weights, biases;
    if (desc->input == NSDF_INPUT_FOURIER) {
        if (network->fourier) {
            blend_seeded_fourier(&weights, network);
        } else {
            nsdf_blend_tensor(&weights, tensor, values, u);
            values += nsdf_tensor_size(tensor++);
        }
        compose_encoding(network, &weights, time);
    }
    for (uint32_t l = 0; l < desc->layer_count; l++, tensor += 2) {
        nsdf_blend_tensor(&weights, &tensor[0], values, u);
        values += nsdf_tensor_size(&tensor[0]);
        nsdf_blend_tensor(&biases, &tensor[1], values, u);
        values += nsdf_tensor_size(&tensor[1]);
        compose_layer(&network->layers[l], &desc->layers[l], &weights, &biases, time);
    }
}

/* Scratch memory: two activation buffers, the Fourier features, the slopes of all layers. */
typedef struct workspace {
    float *even, *odd, *features, *slopes;
} workspace;

static uint64_t widest(const nsdf_network *network) {
    uint64_t width = 3;
    for (uint32_t l = 0; l < network->layer_count; l++) {
        const nsdf_net_layer *layer = &network->layers[l];
        width = layer->outputs > width ? layer->outputs : width;
        width = layer->inputs > width ? layer->inputs : width;
    }
    return width;
}

uint64_t nsdf_network_scratch(const nsdf_network *network) {
    uint64_t rows = 2 * widest(network) + 2 * (uint64_t)network->encoding.outputs;
    for (uint32_t l = 0; l < network->layer_count; l++)
        rows += network->layers[l].outputs;
    return rows * NSDF_TILE;
}

static workspace divide_scratch(const nsdf_network *network, float *scratch) {
    const size_t buffer = (size_t)widest(network) * NSDF_TILE;
    workspace w = {scratch, scratch + buffer, scratch + 2 * buffer, NULL};
    w.slopes = w.features + (size_t)2 * network->encoding.outputs * NSDF_TILE;
    return w;
}

static const float *encode(const nsdf_network *network, const nsdf_net_kernels *kernels, const workspace *space,
                           const float *xyz) {
    const nsdf_net_layer *e = &network->encoding;
    if (e->outputs == 0)
        return xyz;
    kernels->linear(e->outputs, 3, e->weights, e->bias, xyz, NULL, space->even);
    kernels->turn(e->outputs, space->even, space->features, space->features + (size_t)e->outputs * NSDF_TILE);
    return space->features;
}

/* g: gradient with respect to the features [2 count][TILE]; to the phases -> out [count][TILE]. */
static void encode_backward(const nsdf_network *network, const float *features, const float *g, float *out) {
    const size_t size = (size_t)network->encoding.outputs * NSDF_TILE;
    const float *cosine = features, *sine = features + size;
    for (size_t i = 0; i < size; i++)
        out[i] = NSDF_SIN_0 * (cosine[i] * g[size + i] - sine[i] * g[i]);
}

static void backward(const nsdf_network *network, const nsdf_net_kernels *kernels, const workspace *space,
                     const float *slopes_end, float *gradient) {
    const nsdf_net_layer *e = &network->encoding;
    const float *slope = slopes_end - NSDF_TILE, *g = slope;
    float *out = space->even;
    for (uint32_t l = network->layer_count; l-- > 0;) {
        const nsdf_net_layer *layer = &network->layers[l];
        const int last = l == 0 && e->outputs == 0;
        slope -= l > 0 ? (size_t)layer->inputs * NSDF_TILE : 0;
        if (last)
            out = gradient;
        kernels->linear(layer->inputs, layer->outputs, layer->transposed, NULL, g, l > 0 ? slope : NULL, out);
        g = out;
        out = out == space->even ? space->odd : space->even;
    }
    if (e->outputs > 0) {
        encode_backward(network, space->features, g, out);
        kernels->linear(3, e->outputs, e->transposed, NULL, out, NULL, gradient);
    }
}

void nsdf_network_evaluate(const nsdf_network *network, const nsdf_net_kernels *kernels, float *scratch,
                           const float *xyz, float *value, float *gradient) {
    const workspace space = divide_scratch(network, scratch);
    const float *in = encode(network, kernels, &space, xyz);
    float *out = space.odd, *slope = space.slopes;
    for (uint32_t l = 0; l < network->layer_count; l++) {
        const nsdf_net_layer *layer = &network->layers[l];
        kernels->linear(layer->outputs, layer->inputs, layer->weights, layer->bias, in, NULL, out);
        kernels->activate(layer->activation, layer->outputs, out, gradient ? slope : NULL);
        slope += (size_t)layer->outputs * NSDF_TILE;
        in = out;
        out = out == space.even ? space.odd : space.even;
    }
    memcpy(value, in, NSDF_TILE * sizeof *value);
    if (gradient)
        backward(network, kernels, &space, slope, gradient);
}
