/* A network at one time: a static MLP over x, y, z, ready for the kernels.  Time, the sine's frequency and the input
 * encoding's time column have been folded into weights and biases. */
#ifndef NSDF_NETWORK_H
#define NSDF_NETWORK_H

#include "net_kernels.h"

typedef struct nsdf_net_layer {
    uint32_t inputs, outputs;
    nsdf_activation activation;
    float *weights;    /* packed [outputs][inputs] */
    float *transposed; /* packed [inputs][outputs], for the gradient */
    float *bias;
} nsdf_net_layer;

typedef struct nsdf_network {
    uint32_t layer_count;
    nsdf_net_layer layers[NSDF_MAX_LAYERS];
    nsdf_net_layer encoding; /* Fourier phases in half turns; no outputs when the input is plain */
    float *fourier;          /* B [count][4] when it comes from a seed */
    float value_scale, value_offset;
} nsdf_network;

/* Floats of storage that nsdf_network_init needs. */
uint64_t nsdf_network_storage(const nsdf_network_desc *desc);
/* Lays the network out in `storage`, which must stay; no weights yet. */
void nsdf_network_init(nsdf_network *network, const nsdf_network_desc *desc, float *storage);
/* Sets the weights from the parameters at time u in [0, 1]. */
void nsdf_network_compose(nsdf_network *network, const nsdf_network_desc *desc, const float *values, double u);

/* Floats of scratch memory that evaluating a tile needs. */
uint64_t nsdf_network_scratch(const nsdf_network *network);
/* Outputs (before value_scale and value_offset) of one tile: xyz [3][NSDF_TILE] -> value [NSDF_TILE] and, if not
 * NULL, gradient [3][NSDF_TILE]. */
void nsdf_network_evaluate(const nsdf_network *network, const nsdf_net_kernels *kernels, float *scratch,
                           const float *xyz, float *value, float *gradient);

#endif
