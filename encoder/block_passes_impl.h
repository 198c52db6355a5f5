/* The inner loops of block_batch.h on vectors of W floats (GCC and Clang vector extension).  Included once per
 * instruction set by a source file that is compiled for it and defines
 *   PASSES_NAME  text
 *   W            4 or 8
 *   OWN_APPEND   where the instruction set has append() functions of its own
 * Hits are worked on by NSDF_HIT_LANES, in parts of W; every lane has sums of its own, which are added up in the same
 * order everywhere.  A ball of a batch holds some twenty points: longer vectors would mostly be empty. */
#include "block_batch.h"
#include "row4.h"

#include <string.h>

enum { LANES = NSDF_HIT_LANES };
#define LEAST_ROOT 1e-4f /* 1 - |u|^2: nearer to the border a point does not count */
#define INLINE static inline __attribute__((always_inline))
/* Sums indexed by a loop counter are registers only when the loop is gone. */
#if defined(__clang__)
#define UNROLL _Pragma("clang loop unroll(full)")
#else
#define UNROLL _Pragma("GCC unroll 32")
#endif

typedef float vec __attribute__((vector_size(4 * W)));
typedef int32_t mask __attribute__((vector_size(4 * W)));
typedef float vec2 __attribute__((vector_size(8)));

INLINE vec load(const float *p) {
    vec v;
    memcpy(&v, p, sizeof v);
    return v;
}

INLINE void store(float *p, vec v) {
    memcpy(p, &v, sizeof v);
}

INLINE vec splat(float f) {
    return f - (vec){0};
}

INLINE vec choose(mask m, vec a, vec b) {
    return (vec)((m & (mask)a) | (~m & (mask)b));
}

INLINE double load_pair(const float *p) {
    double v;
    memcpy(&v, p, sizeof v);
    return v;
}

/* Shuffles that do the same in each four lanes: i, j, k, l count four of a, then four of b. */
#define IN(i, four) ((i) < 4 ? 4 * (four) + (i) : W + 4 * (four) + (i)-4)
#define FOUR(i, j, k, l, four) IN(i, four), IN(j, four), IN(k, four), IN(l, four)
#if W == 8
#define SHUFFLE(a, b, i, j, k, l) __builtin_shufflevector(a, b, FOUR(i, j, k, l, 0), FOUR(i, j, k, l, 1))
typedef double vec_pairs __attribute__((vector_size(32)));
#define PAIRS(n) ((vec_pairs){PAIR(n), PAIR(n + 1), PAIR(n + 4), PAIR(n + 5)})
#define SIDE_BY_SIDE(n)                                                                                                \
    __builtin_shufflevector(nsdf_row4_load(POINT(n)), nsdf_row4_load(POINT(n + 4)), 0, 1, 2, 3, 4, 5, 6, 7)
#else
#define SHUFFLE(a, b, i, j, k, l) __builtin_shufflevector(a, b, FOUR(i, j, k, l, 0))
typedef double vec_pairs __attribute__((vector_size(16)));
#define PAIRS(n) ((vec_pairs){PAIR(n), PAIR(n + 1)})
#define SIDE_BY_SIDE(n) nsdf_row4_load(POINT(n))
#endif

INLINE void transpose(const vec r[4], vec x[3]) {
    const vec a = SHUFFLE(r[0], r[1], 0, 4, 1, 5), b = SHUFFLE(r[2], r[3], 0, 4, 1, 5);
    const vec c = SHUFFLE(r[0], r[1], 2, 6, 3, 7), d = SHUFFLE(r[2], r[3], 2, 6, 3, 7);
    x[0] = SHUFFLE(a, b, 0, 1, 4, 5);
    x[1] = SHUFFLE(a, b, 2, 3, 6, 7);
    x[2] = SHUFFLE(c, d, 0, 1, 4, 5);
}

/* W points anywhere, and W that follow each other. */
INLINE void gather_points(const float (*point)[4], const uint16_t *at, vec x[3]) {
#define POINT(n) point[at[n]]
    const vec r[4] = {SIDE_BY_SIDE(0), SIDE_BY_SIDE(1), SIDE_BY_SIDE(2), SIDE_BY_SIDE(3)};
#undef POINT
    transpose(r, x);
}

INLINE void load_points(const float (*point)[4], vec x[3]) {
#define POINT(n) point[n]
    const vec r[4] = {SIDE_BY_SIDE(0), SIDE_BY_SIDE(1), SIDE_BY_SIDE(2), SIDE_BY_SIDE(3)};
#undef POINT
    transpose(r, x);
}

/* u of a ball, and 1 - |u|^2. */
INLINE void to_ball(const float m[12], const vec x[3], vec u[4]) {
    for (int row = 0; row < 3; row++)
        u[row] = m[4 * row] * x[0] + m[4 * row + 1] * x[1] + m[4 * row + 2] * x[2] + m[4 * row + 3];
    u[3] = 1.0f - (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
}

/* ---- Candidates and hits --------------------------------------------------------------------------------- */

#ifndef OWN_APPEND
/* The first n lanes, points from `from` on, whose root is above `least`. */
INLINE size_t append_candidates(uint16_t *near, const vec root[LANES / W], float least, uint32_t from, uint32_t n,
                                size_t at) {
    float each[LANES];
    for (uint32_t part = 0; part < LANES / W; part++)
        store(each + W * part, root[part]);
    for (uint32_t l = 0; l < n; l++) {
        near[at] = (uint16_t)(from + l);
        at += each[l] > least;
    }
    return at;
}

/* The first n lanes that are inside the ball; there is room for all lanes. */
INLINE uint32_t append_hits(nsdf_block_work *w, const vec u[LANES / W][4], const uint16_t *point, uint32_t n,
                            uint32_t at) {
    float each[4][LANES];
    for (uint32_t part = 0; part < LANES / W; part++)
        for (int i = 0; i < 4; i++)
            store(each[i] + W * part, u[part][i]);
    for (uint32_t l = 0; l < n; l++) {
        w->point[at] = point[l];
        for (int i = 0; i < 4; i++)
            w->hit[i][at] = each[i][l];
        at += each[3][l] > LEAST_ROOT;
    }
    return at;
}
#endif

static size_t list(nsdf_block_batch *b, const float m[12], float least, uint32_t from, uint32_t to, size_t at) {
    for (; from < to; from += LANES) {
        vec root[LANES / W];
        for (uint32_t part = 0; part < LANES / W; part++) { /* there is room behind the last point */
            vec x[3], u[4];
            load_points((const float(*)[4])b->point + from + W * part, x);
            to_ball(m, x, u);
            root[part] = u[3];
        }
        at = append_candidates(b->near, root, least, from, to - from < LANES ? to - from : LANES, at);
    }
    return at;
}

/* Whole vectors: hits of the point that is none, where the weight is 0.  There is room for a vector more. */
INLINE uint32_t pad(nsdf_block_work *w, uint32_t none, uint32_t at) {
    for (uint32_t part = 0; part < LANES; part += W) {
        const mask point = (mask){0} + (int32_t)none;
        memcpy(w->point + at + part, &point, sizeof point);
        for (int i = 0; i < NSDF_HIT_ARRAYS - 1; i++)
            store(w->hit[i] + at + part, (vec){0});
    }
    return (at + LANES - 1) / LANES * LANES;
}

static uint32_t find(nsdf_block_work *w, const nsdf_block_batch *b, uint32_t block, const float m[12], uint32_t at) {
    const uint32_t to = b->first[block + 1];
    for (uint32_t i = b->first[block]; i < to; i += LANES) {
        vec u[LANES / W][4];
        for (uint32_t part = 0; part < LANES / W; part++) {
            vec x[3];
            gather_points((const float(*)[4])b->point, b->near + i + W * part, x);
            to_ball(m, x, u[part]);
        }
        at = append_hits(w, (const vec(*)[4])u, b->near + i, to - i < LANES ? to - i : LANES, at);
    }
    return pad(w, b->count, at);
}

/* ---- Values ---------------------------------------------------------------------------------------------- */

INLINE vec value_of(uint32_t degree, const float *t, vec x, vec y, vec z) {
    vec value = t[0] + t[1] * x + t[2] * y + t[3] * z;
    if (degree >= 2)
        value += x * (t[4] * x + t[5] * y + t[6] * z) + y * (t[7] * y + t[8] * z) + z * (t[9] * z);
    if (degree >= 3)
        value += x * x * (t[10] * x + t[11] * y + t[12] * z) + x * (y * (t[13] * y + t[14] * z) + t[15] * z * z) +
                 y * y * (t[16] * y + t[17] * z) + z * z * (t[18] * y + t[19] * z);
    return value;
}

INLINE void add_pair(float *sum, const float *pair) {
    vec2 a, b;
    memcpy(&a, sum, sizeof a);
    memcpy(&b, pair, sizeof b);
    a += b;
    memcpy(sum, &a, sizeof a);
}

INLINE void forward_degree(nsdf_block_work *w, uint32_t from, uint32_t to, uint32_t degree, const float *t) {
    for (uint32_t i = from; i < to; i += W) {
        const vec root = load(w->hit[3] + i);
        const vec value = value_of(degree, t, load(w->hit[0] + i), load(w->hit[1] + i), load(w->hit[2] + i));
        const vec weight = root * root, part = weight * value;
        float pairs[2][W]; /* of lanes 0, 1 and of lanes 2, 3 of every four */
        store(w->hit[4] + i, value);
        store(pairs[0], SHUFFLE(weight, part, 0, 4, 1, 5));
        store(pairs[1], SHUFFLE(weight, part, 2, 6, 3, 7));
        UNROLL
        for (uint32_t l = 0; l < W; l++)
            add_pair(w->sum[w->point[i + l]], pairs[l / 2 % 2] + l / 4 * 4 + l % 2 * 2);
    }
}

static void forward(nsdf_block_work *w, uint32_t block, uint32_t degree, const float *t) {
    const uint32_t from = w->first[block], to = w->first[block + 1];
    if (degree == 2)
        forward_degree(w, from, to, 2, t);
    else if (degree == 3)
        forward_degree(w, from, to, 3, t);
    else
        forward_degree(w, from, to, 1, t);
}

/* ---- Loss ------------------------------------------------------------------------------------------------ */

INLINE vec size_of(vec x) {
    return (vec)((mask)x & ((mask){0} + INT32_MAX));
}

/* What differentiating a stretch of points adds up to, lane by lane. */
typedef struct loss_lanes {
    vec near_error;
    mask near_count, count;
} loss_lanes;

/* sum becomes share, value becomes f. */
INLINE void differentiate_lanes(const nsdf_block_loss *loss, vec d, vec *sum, vec *value, loss_lanes *lanes) {
    const mask held = *sum > (vec){0};
    const vec one = splat(1.0f), size = size_of(d), per_weight = one / choose(held, *sum, one);
    const vec f = *value / choose(held, *sum, one), side = choose(d < (vec){0}, -f, f);
    const vec away = loss->weight_distance / (loss->weight_distance + size);
    const vec weight = choose(side < loss->safe_share * size, one, away);
    const vec share = loss->scale * weight * per_weight;
    const mask near = held & (size < splat(loss->near_limit));
    *sum = (vec)(held & (mask)choose(f > d, share, -share));
    *value = (vec)(held & (mask)f);
    lanes->near_error += (vec)(near & (mask)size_of(f - d));
    lanes->near_count -= near;
    lanes->count -= held;
}

/* Weights and values of W points that follow each other, and back. */
INLINE void load_sums(const float (*sum)[2], vec *weight, vec *value) {
#if W == 8
    const vec a = __builtin_shufflevector(nsdf_row4_load(sum[0]), nsdf_row4_load(sum[4]), 0, 1, 2, 3, 4, 5, 6, 7);
    const vec b = __builtin_shufflevector(nsdf_row4_load(sum[2]), nsdf_row4_load(sum[6]), 0, 1, 2, 3, 4, 5, 6, 7);
#else
    const vec a = nsdf_row4_load(sum[0]), b = nsdf_row4_load(sum[2]);
#endif
    *weight = SHUFFLE(a, b, 0, 2, 4, 6);
    *value = SHUFFLE(a, b, 1, 3, 5, 7);
}

INLINE void store_sums(float (*sum)[2], vec weight, vec value) {
    float pairs[2][W];
    store(pairs[0], SHUFFLE(weight, value, 0, 4, 1, 5));
    store(pairs[1], SHUFFLE(weight, value, 2, 6, 3, 7));
    for (int four = 0; four < W / 4; four++)
        for (int half = 0; half < 2; half++)
            memcpy(sum[4 * four + 2 * half], pairs[half] + 4 * four, 4 * sizeof(float));
}

static nsdf_block_loss_sums differentiate(nsdf_block_work *w, const nsdf_block_batch *b, const nsdf_block_loss *loss) {
    nsdf_block_loss_sums sums = {0.0, 0, 0};
    for (uint32_t part = 0; part < LANES; part += W) {
        loss_lanes lanes = {{0}, {0}, {0}};
        for (uint32_t i = part; i < b->count; i += LANES) {
            const float(*point)[4] = (const float(*)[4])b->point + i;
            vec sum, value, d;
#define POINT(n) point[n]
            const vec low = SHUFFLE(SIDE_BY_SIDE(0), SIDE_BY_SIDE(1), 2, 6, 3, 7);
            const vec high = SHUFFLE(SIDE_BY_SIDE(2), SIDE_BY_SIDE(3), 2, 6, 3, 7);
#undef POINT
            d = SHUFFLE(low, high, 2, 3, 6, 7);
            load_sums((const float(*)[2])w->sum + i, &sum, &value);
            differentiate_lanes(loss, d, &sum, &value, &lanes);
            store_sums(w->sum + i, sum, value);
        }
        for (uint32_t l = 0; l < W; l++) {
            sums.near_error += (double)lanes.near_error[l];
            sums.near_count += (uint64_t)lanes.near_count[l];
            sums.count += (uint64_t)lanes.count[l];
        }
    }
    return sums;
}

/* ---- Gradients ------------------------------------------------------------------------------------------- */

enum { MOST_SUMS = NSDF_BLOCK_MOST_TERMS + 12 };

INLINE uint32_t terms_of(uint32_t degree) {
    return degree >= 3 ? 20 : degree == 2 ? 10 : 4;
}

/* Slopes of the polynomial with respect to u. */
INLINE void slopes(uint32_t degree, const float *t, vec x, vec y, vec z, vec slope[3]) {
    slope[0] = splat(t[1]);
    slope[1] = splat(t[2]);
    slope[2] = splat(t[3]);
    if (degree >= 2) {
        slope[0] += 2.0f * t[4] * x + t[5] * y + t[6] * z;
        slope[1] += t[5] * x + 2.0f * t[7] * y + t[8] * z;
        slope[2] += t[6] * x + t[8] * y + 2.0f * t[9] * z;
    }
    if (degree >= 3) {
        slope[0] +=
            x * (3.0f * t[10] * x + 2.0f * (t[11] * y + t[12] * z)) + y * (t[13] * y + t[14] * z) + t[15] * z * z;
        slope[1] +=
            x * (t[11] * x + 2.0f * t[13] * y + t[14] * z) + y * (3.0f * t[16] * y + 2.0f * t[17] * z) + t[18] * z * z;
        slope[2] +=
            x * (t[12] * x + t[14] * y + 2.0f * t[15] * z) + t[17] * y * y + z * (2.0f * t[18] * y + 3.0f * t[19] * z);
    }
}

/* Sums of w times the monomials. */
INLINE void add_monomials(uint32_t degree, vec w, vec x, vec y, vec z, vec *sums) {
    const vec wx = w * x, wy = w * y, wz = w * z;
    sums[0] += w;
    sums[1] += wx;
    sums[2] += wy;
    sums[3] += wz;
    if (degree >= 2) {
        sums[4] += wx * x;
        sums[5] += wx * y;
        sums[6] += wx * z;
        sums[7] += wy * y;
        sums[8] += wy * z;
        sums[9] += wz * z;
    }
    if (degree >= 3) {
        const vec xx = wx * x, yy = wy * y, zz = wz * z;
        sums[10] += xx * x;
        sums[11] += xx * y;
        sums[12] += xx * z;
        sums[13] += yy * x;
        sums[14] += wx * y * z;
        sums[15] += zz * x;
        sums[16] += yy * y;
        sums[17] += yy * z;
        sums[18] += zz * y;
        sums[19] += zz * z;
    }
}

/* Shares dL/df / weight and f of W hits. */
INLINE void gather_pairs(const float (*sum)[2], const uint32_t *point, vec *share, vec *f) {
#define PAIR(n) load_pair(sum[point[n]])
    const vec a = (vec)PAIRS(0), b = (vec)PAIRS(2);
#undef PAIR
    *share = SHUFFLE(a, b, 0, 2, 4, 6);
    *f = SHUFFLE(a, b, 1, 3, 5, 7);
}

INLINE void add_hits(const nsdf_block_work *w, uint32_t i, uint32_t degree, const float *t, vec *sums) {
    const vec u[3] = {load(w->hit[0] + i), load(w->hit[1] + i), load(w->hit[2] + i)}, root = load(w->hit[3] + i);
    vec share, f, slope[3], *moments = sums + terms_of(degree);
    gather_pairs((const float(*)[2])w->sum, w->point + i, &share, &f);
    const vec s = share * root, weight = s * root, fall = 4.0f * s * (load(w->hit[4] + i) - f);
    add_monomials(degree, weight, u[0], u[1], u[2], sums);
    slopes(degree, t, u[0], u[1], u[2], slope);
    for (int k = 0; k < 3; k++) {
        const vec g = weight * slope[k] - fall * u[k];
        for (int j = 0; j < 3; j++)
            moments[4 * k + j] += g * u[j];
        moments[4 * k + 3] += g;
    }
}

/* The sums of the lanes of eight sums: halves are added until one lane is left. */
#if W == 8
INLINE void add_lanes(const vec *sums, float out[8]) {
#define HALVES(a, b)                                                                                                   \
    (__builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11) +                                                         \
     __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15))
#define QUARTERS(a, b) (SHUFFLE(a, b, 0, 1, 4, 5) + SHUFFLE(a, b, 2, 3, 6, 7))
    const vec low = QUARTERS(HALVES(sums[0], sums[4]), HALVES(sums[1], sums[5]));
    const vec high = QUARTERS(HALVES(sums[2], sums[6]), HALVES(sums[3], sums[7]));
    store(out, SHUFFLE(low, high, 0, 2, 4, 6) + SHUFFLE(low, high, 1, 3, 5, 7));
}
#else
INLINE void add_lanes(const vec *sums, float out[8]) {
#define HALVES(s) (sums[s] + sums[MOST_SUMS + (s)])
#define QUARTERS(a, b) (SHUFFLE(a, b, 0, 1, 4, 5) + SHUFFLE(a, b, 2, 3, 6, 7))
    for (int s = 0; s < 8; s += 4) {
        const vec low = QUARTERS(HALVES(s), HALVES(s + 1)), high = QUARTERS(HALVES(s + 2), HALVES(s + 3));
        store(out + s, SHUFFLE(low, high, 0, 2, 4, 6) + SHUFFLE(low, high, 1, 3, 5, 7));
    }
}
#endif

/* `degree` is a constant where this is inlined: the sums then live in registers, as far as there are any. */
INLINE void backward_degree(const nsdf_block_work *w, uint32_t from, uint32_t to, uint32_t degree, const float *t,
                            nsdf_block_gradient *out) {
    const uint32_t terms = terms_of(degree), rounded = (terms + 12 + 7) / 8 * 8;
    vec sums[LANES / W][MOST_SUMS];
    float flat[MOST_SUMS];
    for (uint32_t part = 0; part < LANES / W; part++) {
        UNROLL
        for (uint32_t s = 0; s < rounded; s++)
            sums[part][s] = (vec){0};
        for (uint32_t i = from + W * part; i < to; i += LANES)
            add_hits(w, i, degree, t, sums[part]);
    }
    UNROLL
    for (uint32_t s = 0; s < rounded; s += 8)
        add_lanes(sums[0] + s, flat + s);
    memset(out->terms, 0, sizeof out->terms);
    memcpy(out->terms, flat, terms * sizeof *flat);
    memcpy(out->moment, flat + terms, sizeof out->moment);
}

static void backward(const nsdf_block_work *w, uint32_t block, uint32_t degree, const float *t,
                     nsdf_block_gradient *out) {
    const uint32_t from = w->first[block], to = w->first[block + 1];
    if (from == to)
        memset(out, 0, sizeof *out);
    else if (degree == 2)
        backward_degree(w, from, to, 2, t, out);
    else if (degree == 3)
        backward_degree(w, from, to, 3, t, out);
    else
        backward_degree(w, from, to, 1, t, out);
}

static const nsdf_block_passes passes = {PASSES_NAME, list, find, forward, differentiate, backward};
