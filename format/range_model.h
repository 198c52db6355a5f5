/* The adaptive model behind the range coder's binary decisions, the same in the decoder and the encoder (spec,
 * section "Range coder").  Integers only.  The idea is that of DeepCABAC: residuals of network parameters are coded
 * as magnitude class, sign and mantissa, with contexts from the magnitudes of neighbours. */
#ifndef NSDF_RANGE_MODEL_H
#define NSDF_RANGE_MODEL_H

#include <string.h>

#include "format_desc.h"

enum {
    NSDF_RANGE_TOP = 1 << 24,       /* the range is kept at or above this */
    NSDF_RANGE_CONTEXTS = 3,        /* of the magnitude class: neighbours about, below and above the mean */
    NSDF_RANGE_CLASSES = 32,        /* leaves of the largest class tree; |residual| needs 26 bits at most */
    NSDF_RANGE_MIN_VALUES = 192,    /* smaller groups use one context only: they could not learn three */
    NSDF_RANGE_COLUMNS = 1024,      /* no array has more */
    NSDF_RANGE_MEAN_RATE = 6,       /* the running mean of all classes follows with 2^-6 */
    NSDF_RANGE_CLASS_SHIFT = 16,    /* means are fixed-point: one class is 1 << 16 */
    NSDF_RANGE_MEAN_BAND = 1 << 14, /* neighbours this close to the mean count as equal to it */
    NSDF_RANGE_FAST_LIMIT = 30,     /* rates fall as 1 / (seen + 2) down to 1/32 ... */
    NSDF_RANGE_SLOW_LIMIT = 254     /* ... and 1/256 */
};

_Static_assert((int)NSDF_MAX_WIDTH <= (int)NSDF_RANGE_COLUMNS, "columns fit");
_Static_assert(2 * (int)NSDF_MAX_FOURIER <= (int)NSDF_RANGE_COLUMNS, "columns fit");

/* Two estimates, in 1/65536, of the probability that a decision is 0; their mean is used. */
typedef struct nsdf_bit_model {
    uint16_t fast, slow;
    uint16_t seen; /* decisions so far, at most NSDF_RANGE_SLOW_LIMIT */
} nsdf_bit_model;

/* A group is one array, or for an array predicted from the plane before, its plane 0 and the other planes. */
typedef struct nsdf_range_group {
    const nsdf_array_desc *array;
    uint32_t first_plane, end_plane;
    uint32_t depth;    /* of the class tree */
    uint32_t contexts; /* 1 or NSDF_RANGE_CONTEXTS */
    uint32_t mean;     /* running means of the classes: of all, of the row at hand, of each column */
    uint32_t row_mean;
    uint32_t column_mean[NSDF_RANGE_COLUMNS];
    nsdf_bit_model tree[NSDF_RANGE_CONTEXTS][NSDF_RANGE_CLASSES];
    nsdf_bit_model sign[3];                         /* by the sign of the residual in the plane before */
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

/* Probability of 0, 1 to 65535. */
static inline uint32_t nsdf_bit_probability(const nsdf_bit_model *m) {
    return ((uint32_t)m->fast + m->slow) >> 1;
}

/* Moves p towards 65536 (bit 0) or 0 (bit 1) by the fraction rate / 65536.  rate <= 32768, so that p stays inside. */
static inline uint16_t nsdf_probability_step(uint32_t p, uint32_t bit, uint32_t rate) {
    return (uint16_t)(bit ? p - (p * rate >> 16) : p + ((65536 - p) * rate >> 16));
}

/* rates[n] = floor(65536 / (n + 2)): with these steps a model starts as a Krichevsky-Trofimov estimator. */
static inline void nsdf_bit_update(nsdf_bit_model *m, uint32_t bit, const uint16_t *rates) {
    uint32_t n = m->seen;
    m->fast = nsdf_probability_step(m->fast, bit, rates[n < NSDF_RANGE_FAST_LIMIT ? n : NSDF_RANGE_FAST_LIMIT]);
    m->slow = nsdf_probability_step(m->slow, bit, rates[n]);
    m->seen = (uint16_t)(n < NSDF_RANGE_SLOW_LIMIT ? n + 1 : n);
}

static inline void nsdf_rates_fill(uint16_t rates[NSDF_RANGE_SLOW_LIMIT + 1]) {
    for (uint32_t n = 0; n <= NSDF_RANGE_SLOW_LIMIT; n++)
        rates[n] = (uint16_t)(65536 / (n + 2));
}

static inline void nsdf_bit_models_reset(nsdf_bit_model *models, size_t count) {
    for (size_t i = 0; i < count; i++) {
        models[i].fast = models[i].slow = 32768;
        models[i].seen = 0;
    }
}

static inline void nsdf_range_group_start(nsdf_range_group *g, const nsdf_array_desc *a, uint32_t first_plane,
                                          uint32_t end_plane) {
    uint32_t largest = nsdf_largest_class(a);
    g->array = a;
    g->first_plane = first_plane;
    g->end_plane = end_plane;
    g->depth = nsdf_bit_length(largest);
    g->contexts =
        (uint64_t)(end_plane - first_plane) * a->rows * a->cols < NSDF_RANGE_MIN_VALUES ? 1 : NSDF_RANGE_CONTEXTS;
    g->mean = largest << (NSDF_RANGE_CLASS_SHIFT - 1);
    g->row_mean = 0;
    memset(g->column_mean, 0, sizeof g->column_mean);
    nsdf_bit_models_reset(&g->tree[0][0], NSDF_RANGE_CONTEXTS * NSDF_RANGE_CLASSES);
    nsdf_bit_models_reset(g->sign, 3);
    nsdf_bit_models_reset(&g->mantissa[0][0], NSDF_RANGE_CLASSES * 4);
}

/* What an element's contexts are made of: what came before it in its group. */
typedef struct nsdf_range_neighbours {
    uint32_t row_count, column_count; /* elements before it in its row; in its column, over all planes */
    uint32_t sum, weight;             /* of the row's mean, the column's mean and the class in the plane before */
    uint32_t sign;                    /* of the plane before: 0 = zero or none, 1 = positive, 2 = negative */
} nsdf_range_neighbours;

/* r points at the element (plane, row, col) among the array's residuals. */
static inline nsdf_range_neighbours nsdf_range_look(const nsdf_range_group *g, const int32_t *r, uint32_t plane,
                                                    uint32_t row, uint32_t col) {
    nsdf_range_neighbours n = {col, (plane - g->first_plane) * g->array->rows + row, 0, 0, 0};
    if (n.row_count > 0) {
        n.sum += g->row_mean;
        n.weight++;
    }
    if (n.column_count > 0) {
        n.sum += g->column_mean[col];
        n.weight++;
    }
    if (plane > g->first_plane) {
        int32_t before = *(r - (size_t)g->array->rows * g->array->cols);
        n.sum += nsdf_residual_class(before) << NSDF_RANGE_CLASS_SHIFT;
        n.weight++;
        n.sign = before > 0 ? 1 : before < 0 ? 2 : 0;
    }
    return n;
}

static inline uint32_t nsdf_range_context(const nsdf_range_group *g, const nsdf_range_neighbours *n) {
    if (g->contexts == 1)
        return 0;
    uint32_t mean = n->weight * g->mean, band = n->weight * NSDF_RANGE_MEAN_BAND;
    return n->sum + band < mean ? 1 : n->sum > mean + band ? 2 : 0;
}

/* `count` values went into the mean before this one. */
static inline uint32_t nsdf_range_mean_step(uint32_t mean, uint32_t count, uint32_t class) {
    uint32_t shift = count < 1 ? 0 : count < 2 ? 1 : count < 6 ? 2 : count < 12 ? 3 : 4;
    return mean - (mean >> shift) + (class << (NSDF_RANGE_CLASS_SHIFT - shift));
}

static inline void nsdf_range_means_update(nsdf_range_group *g, const nsdf_range_neighbours *n, uint32_t class) {
    uint32_t col = n->row_count;
    g->row_mean = nsdf_range_mean_step(g->row_mean, n->row_count, class);
    g->column_mean[col] = nsdf_range_mean_step(g->column_mean[col], n->column_count, class);
    g->mean = g->mean - (g->mean >> NSDF_RANGE_MEAN_RATE) + (class << (NSDF_RANGE_CLASS_SHIFT - NSDF_RANGE_MEAN_RATE));
}

/* Groups of an array: one, or two when planes are predicted. */
static inline uint32_t nsdf_range_first_group_end(const nsdf_array_desc *a) {
    const int by_planes = a->predict == NSDF_PREDICT_PLANE || a->predict == NSDF_PREDICT_LINEAR;
    return by_planes && a->planes > 1 ? 1 : a->planes;
}

#endif
