/* The inner loops of network evaluation, one table per instruction set.
 *
 * Points are worked on in tiles of NSDF_TILE; activations lie as [neuron][NSDF_TILE].  Every lane of a tile gets the
 * same operations in the same order, so a point's result depends neither on its neighbours nor on its place.  The
 * tables use the same algorithms and differ by rounding only (fused or separate multiply and add).
 *
 * Sines take their argument in half turns: the frequency and 1 / pi are folded into the weights in front of them, and
 * the range reduction z - round(z) is exact. */
#ifndef NSDF_NET_KERNELS_H
#define NSDF_NET_KERNELS_H

#include "format_desc.h"

enum {
    NSDF_TILE = 48, /* three AVX-512 vectors, which times eight outputs fill the register file */
    NSDF_PANEL = 8  /* outputs that are worked on at once */
};

typedef struct nsdf_net_kernels {
    const char *name;
    /* out[o] = (bias[o] + sum_i W[o][i] in[i]) * gain[o].  weights: packed as nsdf_panel_index says; bias NULL = 0;
     * gain ([outputs][NSDF_TILE]) NULL = 1.  out overlaps none of the others. */
    void (*linear)(uint32_t outputs, uint32_t inputs, const float *weights, const float *bias, const float *in,
                   const float *gain, float *out);
    /* z = act(z) for a whole number of tiles; slope, if not NULL, gets act'.  NSDF_ACT_SINE is sin(pi z). */
    void (*activate)(nsdf_activation kind, size_t tiles, float *z, float *slope);
    /* cosine = cos(pi z), sine = sin(pi z). */
    void (*turn)(size_t tiles, const float *z, float *cosine, float *sine);
} nsdf_net_kernels;

/* The best table among those that `features` (NSDF_CPU_...) allows; plain C for 0. */
const nsdf_net_kernels *nsdf_net_kernels_choose(uint32_t features);

const nsdf_net_kernels *nsdf_net_kernels_c(void);
const nsdf_net_kernels *nsdf_net_kernels_avx2(void);   /* NULL where it cannot be built */
const nsdf_net_kernels *nsdf_net_kernels_avx512(void); /* the same */
const nsdf_net_kernels *nsdf_net_kernels_neon(void);

/* Outputs are grouped into panels: eights, then at most one of four, then ones.  The height of the panel that starts
 * at an output with `left` outputs to go. */
static inline uint32_t nsdf_panel_height(uint32_t left) {
    return left >= NSDF_PANEL ? NSDF_PANEL : left >= 4 ? 4 : 1;
}

/* Where W[output][input] lies among the packed weights: panel after panel, each [inputs][height]. */
static inline size_t nsdf_panel_index(uint32_t outputs, uint32_t inputs, uint32_t output, uint32_t input) {
    uint32_t eights = outputs / NSDF_PANEL * NSDF_PANEL;
    uint32_t start = output, height = 1;
    if (output < eights) {
        start = output / NSDF_PANEL * NSDF_PANEL;
        height = NSDF_PANEL;
    } else if (outputs - eights >= 4 && output < eights + 4) {
        start = eights;
        height = 4;
    }
    return (size_t)start * inputs + (size_t)input * height + (output - start);
}

/* Coefficients shared by all tables (minimax fits). */

/* sin(pi r) = r P(r^2), |r| <= 1/2, error below 7e-9 before rounding. */
#define NSDF_SIN_0 3.14159264f
#define NSDF_SIN_1 -5.167710077f
#define NSDF_SIN_2 2.550077387f
#define NSDF_SIN_3 -0.5982904113f
#define NSDF_SIN_4 0.07765591228f
/* cos(pi r) = Q(r^2), |r| <= 1/2, error below 3e-10 before rounding. */
#define NSDF_COS_0 1.0f
#define NSDF_COS_1 -4.934802137f
#define NSDF_COS_2 4.058709155f
#define NSDF_COS_3 -1.335211949f
#define NSDF_COS_4 0.2349370686f
#define NSDF_COS_5 -0.0243959321f
/* exp(r) = 1 + r + r^2 E(r), |r| <= ln(2) / 2, error below 8e-9 before rounding. */
#define NSDF_EXP_0 0.5f
#define NSDF_EXP_1 0.1666657703f
#define NSDF_EXP_2 0.04166655466f
#define NSDF_EXP_3 0.008363173075f
#define NSDF_EXP_4 0.001392617612f
#define NSDF_LOG2_E 1.44269504f
#define NSDF_LN2_HIGH 0.693359375f /* few bits: a multiple of it is exact */
#define NSDF_LN2_LOW -2.12194440e-4f
#define NSDF_TANH_LIMIT 20.0f /* of 2|x|, where tanh is 1 in float */
/* Adding 1.5 * 2^23 rounds a float below 2^22 to the nearest integer and leaves it in the low bits. */
#define NSDF_ROUNDER 12582912.0f

#endif
