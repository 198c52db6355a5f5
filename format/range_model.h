/* What the range coder's binary decisions are modelled by, the same in the decoder and the encoder (spec, section
 * "Range coder").  Integers only.  A residual is coded as magnitude class, sign and mantissa, as in DeepCABAC; class
 * and sign are decided by a logistic mix of models, each of which looks at other neighbours. */
#ifndef NSDF_RANGE_MODEL_H
#define NSDF_RANGE_MODEL_H

#include <string.h>

#include "format_desc.h"
#include "logistic.h"

enum {
    NSDF_RANGE_TOP = 1 << 24,  /* the range is kept at or above this */
    NSDF_RANGE_CLASSES = 32,   /* |residual| needs 26 bits at most */
    NSDF_RANGE_COLUMNS = 1024, /* no array has more */
    NSDF_RANGE_INPUTS = 4,     /* models that vote on a decision */
    NSDF_RANGE_LEVELS = 12,    /* of a quantised magnitude */
    NSDF_RANGE_PLACES = 16,    /* columns that are told apart */
    NSDF_RANGE_CONTEXTS = NSDF_RANGE_LEVELS * NSDF_RANGE_PLACES,
    NSDF_RANGE_NODES = 18,     /* decisions told apart: the sign, class above 0, above 1, ... above 16 and more */
    NSDF_RANGE_LARGE = 4095,   /* neighbours count as no larger than this */
    NSDF_RANGE_MEAN_SHIFT = 12 /* running means of magnitudes are in 1/4096 */
};

enum { NSDF_NODE_SIGN = 0, NSDF_NODE_CLASS = 1 };

_Static_assert((int)NSDF_MAX_WIDTH <= (int)NSDF_RANGE_COLUMNS, "columns fit");
_Static_assert(2 * (int)NSDF_MAX_FOURIER <= (int)NSDF_RANGE_COLUMNS, "columns fit");
_Static_assert((int)NSDF_RANGE_LEVELS <= (int)NSDF_RANGE_PLACES, "two levels are a context too");

/* A group is one array, or for an array predicted from the plane before, its plane 0 and the other planes.
 * About 60 KB, which readers and writers have on the stack. */
typedef struct nsdf_range_group {
    const nsdf_array_desc *array;
    uint32_t first_plane, end_plane;
    uint32_t largest;  /* class that a residual of the array may have */
    uint32_t row_mean; /* running means of magnitudes: of the row at hand, of each column */
    uint32_t column_mean[NSDF_RANGE_COLUMNS];
    int32_t weights[NSDF_RANGE_NODES][NSDF_RANGE_INPUTS];
    nsdf_bit_model models[NSDF_RANGE_INPUTS][NSDF_RANGE_CONTEXTS][NSDF_RANGE_NODES];
    nsdf_bit_model mantissa[NSDF_RANGE_CLASSES][4]; /* the two bits below the leading one, as a tree */
} nsdf_range_group;

/* Bits of v without leading zeros. */
static inline uint32_t nsdf_bit_length(uint32_t v) {
    uint32_t n = 0;
    for (uint32_t shift = 16; shift; shift >>= 1) {
        uint32_t more = v >> shift ? shift : 0;
        v >>= more;
        n += more;
    }
    return n + v;
}

static inline uint32_t nsdf_magnitude(int32_t v) {
    return v < 0 ? 0u - (uint32_t)v : (uint32_t)v;
}

static inline uint32_t nsdf_residual_class(int32_t r) {
    return nsdf_bit_length(nsdf_magnitude(r));
}

/* Largest residual that the description of an array allows; the smallest is residual_min. */
static inline int32_t nsdf_residual_max(const nsdf_array_desc *a) {
    return a->residual_min + (int32_t)((UINT32_C(1) << a->bits) - 1);
}

static inline uint32_t nsdf_largest_class(const nsdf_array_desc *a) {
    uint32_t low = nsdf_residual_class(a->residual_min), high = nsdf_residual_class(nsdf_residual_max(a));
    return low > high ? low : high;
}

static inline void nsdf_bit_models_reset(nsdf_bit_model *models, size_t count) {
    for (size_t i = 0; i < count; i++)
        models[i] = (nsdf_bit_model){32768, 0};
}

static inline void nsdf_range_group_start(nsdf_range_group *g, const nsdf_array_desc *a, uint32_t first_plane,
                                          uint32_t end_plane) {
    g->array = a;
    g->first_plane = first_plane;
    g->end_plane = end_plane;
    g->largest = nsdf_largest_class(a);
    g->row_mean = 0;
    memset(g->column_mean, 0, sizeof g->column_mean);
    for (uint32_t i = 0; i < NSDF_RANGE_NODES * NSDF_RANGE_INPUTS; i++)
        g->weights[i / NSDF_RANGE_INPUTS][i % NSDF_RANGE_INPUTS] = NSDF_MIX_WEIGHT_START;
    nsdf_bit_models_reset(&g->models[0][0][0], NSDF_RANGE_INPUTS * NSDF_RANGE_CONTEXTS * NSDF_RANGE_NODES);
    nsdf_bit_models_reset(&g->mantissa[0][0], NSDF_RANGE_CLASSES * 4);
}

static inline uint32_t nsdf_neighbour_magnitude(int32_t r) {
    const uint32_t m = nsdf_magnitude(r);
    return m < NSDF_RANGE_LARGE ? m : NSDF_RANGE_LARGE;
}

/* Of a magnitude in sixteenths: the number of bounds below it. */
static inline uint32_t nsdf_magnitude_level(uint32_t sixteenths) {
    static const uint16_t bounds[NSDF_RANGE_LEVELS - 1] = {2, 6, 12, 22, 36, 60, 96, 160, 272, 480, 960};
    uint32_t level = 0;
    while (level < NSDF_RANGE_LEVELS - 1 && sixteenths > bounds[level])
        level++;
    return level;
}

static inline uint32_t nsdf_residual_level(int32_t r) {
    return r == 0 ? 0 : nsdf_magnitude_level(16 * nsdf_neighbour_magnitude(r));
}

/* 0 = zero, 1 = positive, 2 = negative. */
static inline uint32_t nsdf_residual_sign(int32_t r) {
    return r > 0 ? 1 : r < 0 ? 2 : 0;
}

/* The contexts of an element: of its class and of its sign, one for each model that votes. */
typedef struct nsdf_range_contexts {
    uint32_t class[NSDF_RANGE_INPUTS], sign[NSDF_RANGE_INPUTS];
} nsdf_range_contexts;

/* Residuals around an element; 0 where the group has none. */
typedef struct nsdf_range_neighbours {
    int32_t before[4]; /* in the planes before, nearest first; in plane 0, in the rows before */
    int32_t left, left4, above;
} nsdf_range_neighbours;

/* r points at the element (plane, row, col) among the array's residuals. */
static inline void nsdf_range_neighbours_find(const nsdf_range_group *g, const int32_t *r, uint32_t plane, uint32_t row,
                                              uint32_t col, nsdf_range_neighbours *n) {
    const size_t cols = g->array->cols, size = g->array->rows * cols;
    const uint32_t planes = plane - g->first_plane, have = planes > 0 ? planes : row;
    const size_t stride = planes > 0 ? size : cols;
    for (uint32_t i = 0; i < 4; i++)
        n->before[i] = i < have ? r[-(ptrdiff_t)((i + 1) * stride)] : 0;
    n->left = col > 0 ? r[-1] : 0;
    n->left4 = col > 3 ? r[-4] : 0;
    n->above = row > 0 ? r[-(ptrdiff_t)cols] : 0;
}

static inline void nsdf_range_look(const nsdf_range_group *g, const int32_t *r, uint32_t plane, uint32_t row,
                                   uint32_t col, nsdf_range_contexts *c) {
    nsdf_range_neighbours n;
    nsdf_range_neighbours_find(g, r, plane, row, col, &n);
    const uint32_t place = col < NSDF_RANGE_PLACES ? col : NSDF_RANGE_PLACES - 1;
    const uint32_t first = nsdf_residual_level(n.before[0]), second = nsdf_residual_level(n.before[1]);
    const uint32_t history =
        nsdf_magnitude_level(6 * nsdf_neighbour_magnitude(n.before[0]) + 4 * nsdf_neighbour_magnitude(n.before[1]) +
                             3 * nsdf_neighbour_magnitude(n.before[2]) + 3 * nsdf_neighbour_magnitude(n.before[3]));
    const uint32_t near = nsdf_magnitude_level(g->row_mean >> (NSDF_RANGE_MEAN_SHIFT - 4));
    const uint32_t column = nsdf_magnitude_level(g->column_mean[col] >> (NSDF_RANGE_MEAN_SHIFT - 4));
    c->class[0] = first * NSDF_RANGE_LEVELS + second;
    c->class[1] = history * NSDF_RANGE_PLACES + place;
    c->class[2] = nsdf_residual_level(n.left4) * NSDF_RANGE_LEVELS + nsdf_residual_level(n.left);
    c->class[3] = column * NSDF_RANGE_LEVELS + near;
    const uint32_t s = nsdf_residual_sign(n.before[0]), above = nsdf_residual_sign(n.above);
    c->sign[0] = 3 * s + nsdf_residual_sign(n.before[1]);
    c->sign[1] = NSDF_RANGE_PLACES * s + place;
    c->sign[2] = 3 * first + s;
    c->sign[3] = 3 * nsdf_residual_sign(n.left4) + above;
}

/* Votes on one decision. */
typedef struct nsdf_range_votes {
    nsdf_bit_model *models[NSDF_RANGE_INPUTS];
    int32_t votes[NSDF_RANGE_INPUTS];
    int32_t *weights;
    uint32_t zero; /* what they come to: the probability of 0 in 1/65536 */
} nsdf_range_votes;

static inline void nsdf_range_vote(nsdf_range_group *g, const uint32_t *contexts, uint32_t node,
                                   const nsdf_logistic_tables *t, nsdf_range_votes *v) {
    for (uint32_t i = 0; i < NSDF_RANGE_INPUTS; i++) {
        v->models[i] = &g->models[i][contexts[i]][node];
        v->votes[i] = nsdf_bit_vote(v->models[i], t);
    }
    v->weights = g->weights[node];
    v->zero = nsdf_squash(nsdf_mix(v->votes, v->weights, NSDF_RANGE_INPUTS));
}

static inline void nsdf_range_learn(nsdf_range_votes *v, uint32_t bit, const nsdf_logistic_tables *t) {
    nsdf_mix_learn(v->votes, v->weights, NSDF_RANGE_INPUTS, v->zero, bit);
    for (uint32_t i = 0; i < NSDF_RANGE_INPUTS; i++)
        nsdf_bit_update(v->models[i], bit, t);
}

/* Node of the decision whether the class is above `class`. */
static inline uint32_t nsdf_class_node(uint32_t class) {
    const uint32_t node = NSDF_NODE_CLASS + class;
    return node < NSDF_RANGE_NODES ? node : NSDF_RANGE_NODES - 1;
}

/* Means follow the element (plane, row, col), which is r. */
static inline void nsdf_range_means_update(nsdf_range_group *g, uint32_t plane, uint32_t row, uint32_t col, int32_t r) {
    const uint32_t magnitude = nsdf_neighbour_magnitude(r) << NSDF_RANGE_MEAN_SHIFT;
    const uint32_t count = (plane - g->first_plane) * g->array->rows + row; /* in its column before it */
    const uint32_t shift = count < 1 ? 0 : count < 2 ? 1 : count < 6 ? 2 : 3;
    g->row_mean = (5 * g->row_mean + 3 * magnitude) >> 3;
    g->column_mean[col] = g->column_mean[col] - (g->column_mean[col] >> shift) + (magnitude >> shift);
}

/* Groups of an array: one, or two when planes are predicted. */
static inline uint32_t nsdf_range_first_group_end(const nsdf_array_desc *a) {
    const int by_planes = a->predict == NSDF_PREDICT_PLANE || a->predict == NSDF_PREDICT_LINEAR;
    return by_planes && a->planes > 1 ? 1 : a->planes;
}

#endif
