/* The decoder's networks and blocks, a tile of points after the other: values, and values with gradients.  Of networks
 * only the operations of matrix products count. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench_kernels.h"
#include "block_kernels.h"
#include "net_kernels.h"
#include "network.h"

enum { TILES = 64, HIDDEN = 3, BALLS = 64, PARTS = 3, DEGREE = 2 };

static const uint32_t widths[] = {16, 32, 64, 80, 128};
enum { WIDTHS = sizeof widths / sizeof *widths };

/* Operations at one point in one ball: the way from its centre and |u|^2; the value; its weight and their sums. */
enum { VALUE_FLOP = 3 + 15 + 21 + 5 };
/* What slopes add: those of |u|^2 and of the value, w and v, their sums. */
enum { SLOPE_FLOP = 9 + 12 + 4 + 9 + 6 };

/* Numbers between -1 and 1, the same on every machine. */
static float next(uint32_t *random) {
    *random = *random * 1664525u + 1013904223u;
    return (float)(*random >> 8) * 0x1p-23f - 1.0f;
}

static float *random_floats(size_t count, float range, uint32_t seed) {
    float *values = bench_floats(count);
    for (size_t i = 0; i < count; i++)
        values[i] = range * next(&seed);
    return values;
}

/* ---- Networks ---------------------------------------------------------------------------------------------- */

typedef struct net_subject {
    nsdf_network network;
    const nsdf_net_kernels *kernels;
    float *scratch, *xyz, *value, *gradient;
} net_subject;

static void set_layer(nsdf_net_layer *layer, uint32_t inputs, uint32_t outputs, nsdf_activation activation) {
    const size_t size = (size_t)inputs * outputs;
    layer->inputs = inputs;
    layer->outputs = outputs;
    layer->activation = activation;
    layer->weights = random_floats(size, 1.0f / sqrtf((float)inputs), inputs);
    layer->transposed = random_floats(size, 1.0f / sqrtf((float)outputs), outputs);
    layer->bias = random_floats(outputs, 0.5f, 7);
}

static net_subject *create_network(uint32_t width, const nsdf_net_kernels *kernels) {
    net_subject *s = bench_allocate_zeroed(1, sizeof *s);
    s->network.layer_count = HIDDEN + 1;
    for (uint32_t l = 0; l < HIDDEN; l++)
        set_layer(&s->network.layers[l], l > 0 ? width : 3, width, NSDF_ACT_SINE);
    set_layer(&s->network.layers[HIDDEN], width, 1, NSDF_ACT_IDENTITY);
    s->kernels = kernels;
    s->scratch = bench_floats((size_t)nsdf_network_scratch(&s->network));
    s->xyz = random_floats(3 * TILES * NSDF_TILE, 0.5f, 1);
    s->value = bench_floats(NSDF_TILE);
    s->gradient = bench_floats(3 * NSDF_TILE);
    return s;
}

static void run_network_value(void *data) {
    net_subject *s = data;
    for (size_t t = 0; t < TILES; t++)
        nsdf_network_evaluate(&s->network, s->kernels, s->scratch, s->xyz + 3 * t * NSDF_TILE, s->value, NULL);
}

static void run_network_gradient(void *data) {
    net_subject *s = data;
    for (size_t t = 0; t < TILES; t++)
        nsdf_network_evaluate(&s->network, s->kernels, s->scratch, s->xyz + 3 * t * NSDF_TILE, s->value, s->gradient);
}

static void add_network(kernels_list *list, uint32_t width, bench_isa isa, const nsdf_net_kernels *kernels) {
    net_subject *s = create_network(width, kernels);
    const double points = (double)TILES * NSDF_TILE, weights = width * (3.0 + (HIDDEN - 1) * width + 1.0);
    kernels_entry entry = {"decode", isa, KERNELS_FLOP, 2.0 * weights * points, points, "points", -1};
    char name[48];
    snprintf(name, sizeof name, "network 3 x %u: value", (unsigned)width);
    entry.compared = kernels_add(list, &entry, name, run_network_value, s);
    entry.work *= 2.0; /* each matrix once more, backwards */
    snprintf(name, sizeof name, "network 3 x %u: with gradient", (unsigned)width);
    kernels_add(list, &entry, name, run_network_gradient, s);
}

/* ---- Blocks ------------------------------------------------------------------------------------------------ */

typedef struct block_subject {
    const nsdf_block_kernels *kernels;
    nsdf_block blocks[BALLS];
    nsdf_near_blocks near;
    float x[3][NSDF_BLOCK_POINTS];
    nsdf_block_sums sums;
} block_subject;

/* Balls that hold all points, so that nothing is computed in vain. */
static block_subject *create_blocks(const nsdf_block_kernels *kernels) {
    block_subject *s = bench_allocate_zeroed(1, sizeof *s);
    uint32_t random = 5;
    s->kernels = kernels;
    for (int axis = 0; axis < 3; axis++)
        for (int p = 0; p < NSDF_BLOCK_POINTS; p++)
            s->x[axis][p] = 0.1f * next(&random);
    for (int k = 0; k < BALLS; k++) {
        for (int i = 0; i < 3; i++)
            s->blocks[k].centre[i] = 0.2f * next(&random);
        for (int i = 0; i < 6; i++)
            s->blocks[k].shape[i] = 0.2f * next(&random) + (i == 0 || i == 3 || i == 5 ? 1.0f : 0.0f);
        for (int i = 0; i < NSDF_BLOCK_TERMS; i++)
            s->blocks[k].terms[i] = next(&random);
        s->blocks[k].radius = s->blocks[k].life = 1.0f;
        s->near.number[k] = (uint32_t)k;
        s->near.reach[k] = 1.0f;
    }
    s->near.count = BALLS;
    return s;
}

static void add_balls(block_subject *s, int slopes) {
    for (int i = 0; i < PARTS; i++)
        s->kernels->sum(s->blocks, &s->near, DEGREE, slopes, (const float(*)[NSDF_BLOCK_POINTS])s->x, &s->sums);
}

static void run_blocks_value(void *data) {
    add_balls(data, 0);
}

static void run_blocks_gradient(void *data) {
    add_balls(data, 1);
}

static void add_blocks(kernels_list *list, bench_isa isa, const nsdf_block_kernels *kernels) {
    block_subject *s = create_blocks(kernels);
    const double hits = (double)BALLS * PARTS * NSDF_BLOCK_POINTS;
    kernels_entry entry = {"decode", isa, KERNELS_FLOP, VALUE_FLOP * hits, hits, "hits", -1};
    entry.compared = kernels_add(list, &entry, "blocks: value", run_blocks_value, s);
    entry.work += SLOPE_FLOP * hits;
    kernels_add(list, &entry, "blocks: with gradient", run_blocks_gradient, s);
}

/* ---- Cases ------------------------------------------------------------------------------------------------- */

void kernels_add_decode(kernels_list *list) {
    const nsdf_net_kernels *const nets[BENCH_ISA_COUNT] = {nsdf_net_kernels_c(), nsdf_net_kernels_avx2(),
                                                           nsdf_net_kernels_avx512()};
    const nsdf_block_kernels *const blocks[BENCH_ISA_COUNT] = {nsdf_block_kernels_c(), nsdf_block_kernels_avx2(),
                                                               nsdf_block_kernels_avx512()};
    for (int isa = BENCH_ISA_COUNT - 1; isa >= 0; isa--) {
        if (!bench_isa_is_here((bench_isa)isa))
            continue;
        for (int i = 0; i < WIDTHS; i++)
            if (!list->quick || widths[i] == 64)
                add_network(list, widths[i], (bench_isa)isa, nets[isa]);
        add_blocks(list, (bench_isa)isa, blocks[isa]);
    }
}
