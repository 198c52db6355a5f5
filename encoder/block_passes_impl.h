/* The inner loops of block_batch.h on vectors of W floats (GCC and Clang vector extension).  Included once per
 * instruction set by a source file that is compiled for it and defines
 *   PASSES_NAME  text
 *   W            4, 8 or 16
 *   OWN_APPEND   where the instruction set has append() functions of its own
 * Hits are worked on by NSDF_HIT_LANES, in parts of W; every lane has sums of its own, which are added up in the same
 * order everywhere. */
#include "block_batch.h"

#include <string.h>

enum { LANES = NSDF_HIT_LANES };
#define LEAST_ROOT 1e-4f /* 1 - |u|^2: nearer to the border a point does not count */
#define INLINE static inline __attribute__((always_inline))

typedef float vec __attribute__((vector_size(4 * W)));
typedef int32_t mask __attribute__((vector_size(4 * W)));
typedef float vec4 __attribute__((vector_size(16)));
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

INLINE vec4 load4(const float *p) {
    vec4 v;
    memcpy(&v, p, sizeof v);
    return v;
}

INLINE double load_pair(const float *p) {
    double v;
    memcpy(&v, p, sizeof v);
    return v;
}

/* Shuffles that do the same in each four lanes: i, j, k, l count four of a, then four of b. */
#define IN(i, four) ((i) < 4 ? 4 * (four) + (i) : W + 4 * (four) + (i)-4)
#define FOUR(i, j, k, l, four) IN(i, four), IN(j, four), IN(k, four), IN(l, four)
#if W == 16
#define SHUFFLE(a, b, i, j, k, l)                                                                                      \
    __builtin_shufflevector(a, b, FOUR(i, j, k, l, 0), FOUR(i, j, k, l, 1), FOUR(i, j, k, l, 2), FOUR(i, j, k, l, 3))
typedef float vec8 __attribute__((vector_size(32)));
typedef double vec_pairs __attribute__((vector_size(64)));
#define PAIRS(n)                                                                                                       \
    ((vec_pairs){PAIR(n), PAIR(n + 1), PAIR(n + 4), PAIR(n + 5), PAIR(n + 8), PAIR(n + 9), PAIR(n + 12), PAIR(n + 13)})
#elif W == 8
#define SHUFFLE(a, b, i, j, k, l) __builtin_shufflevector(a, b, FOUR(i, j, k, l, 0), FOUR(i, j, k, l, 1))
typedef double vec_pairs __attribute__((vector_size(32)));
#define PAIRS(n) ((vec_pairs){PAIR(n), PAIR(n + 1), PAIR(n + 4), PAIR(n + 5)})
#else
#define SHUFFLE(a, b, i, j, k, l) __builtin_shufflevector(a, b, FOUR(i, j, k, l, 0))
typedef double vec_pairs __attribute__((vector_size(16)));
#define PAIRS(n) ((vec_pairs){PAIR(n), PAIR(n + 1)})
#endif

/* Points a, b, ... that are four apart, side by side. */
#if W == 16
INLINE vec side_by_side(const float *a, const float *b, const float *c, const float *d) {
    const vec8 low = __builtin_shufflevector(load4(a), load4(b), 0, 1, 2, 3, 4, 5, 6, 7);
    const vec8 high = __builtin_shufflevector(load4(c), load4(d), 0, 1, 2, 3, 4, 5, 6, 7);
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
}
#define SIDE_BY_SIDE(n) side_by_side(POINT(n), POINT(n + 4), POINT(n + 8), POINT(n + 12))
#elif W == 8
#define SIDE_BY_SIDE(n) __builtin_shufflevector(load4(POINT(n)), load4(POINT(n + 4)), 0, 1, 2, 3, 4, 5, 6, 7)
#else
#define SIDE_BY_SIDE(n) load4(POINT(n))
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
INLINE size_t append_candidates(uint16_t *near, const float root[LANES], float least, uint32_t from, uint32_t n,
                                size_t at) {
    for (uint32_t l = 0; l < n; l++) {
        near[at] = (uint16_t)(from + l);
        at += root[l] > least;
    }
    return at;
}

/* The first n lanes that are inside the ball; there is room for all lanes. */
INLINE uint32_t append_hits(nsdf_block_work *w, float u[4][LANES], const uint16_t *point, uint32_t n, uint32_t at) {
    for (uint32_t l = 0; l < n; l++) {
        w->point[at] = point[l];
        for (int i = 0; i < 4; i++)
            w->hit[i][at] = u[i][l];
        at += u[3][l] > LEAST_ROOT;
    }
    return at;
}
#endif

static size_t list(nsdf_block_batch *b, const float m[12], float least, uint32_t from, uint32_t to, size_t at) {
    for (; from < to; from += LANES) {
        float root[LANES];
        for (uint32_t l = 0; l < LANES; l += W) { /* there is room behind the last point */
            vec x[3], u[4];
            load_points((const float(*)[4])b->point + from + l, x);
            to_ball(m, x, u);
            store(root + l, u[3]);
        }
        at = append_candidates(b->near, root, least, from, to - from < LANES ? to - from : LANES, at);
    }
    return at;
}

/* Whole vectors: hits of the point that is none, where the weight is 0. */
static uint32_t pad(nsdf_block_work *w, uint32_t none, uint32_t at) {
    const uint32_t end = (at + LANES - 1) / LANES * LANES;
    for (uint32_t l = at; l < end; l++)
        w->point[l] = none;
    for (int i = 0; i < NSDF_HIT_ARRAYS - 1; i++)
        for (uint32_t l = at; l < end; l++)
            w->hit[i][l] = 0.0f;
    return end;
}

static uint32_t find(nsdf_block_work *w, const nsdf_block_batch *b, uint32_t block, const float m[12], uint32_t at) {
    const uint32_t to = b->first[block + 1];
    for (uint32_t i = b->first[block]; i < to; i += LANES) {
        float u[4][LANES];
        for (uint32_t l = 0; l < LANES; l += W) {
            vec x[3], v[4];
            gather_points((const float(*)[4])b->point, b->near + i + l, x);
            to_ball(m, x, v);
            for (int k = 0; k < 4; k++)
                store(u[k] + l, v[k]);
        }
        at = append_hits(w, u, b->near + i, to - i < LANES ? to - i : LANES, at);
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

/* sum becomes share, value becomes f; error is |f - d| where it is near the surface, else 0. */
INLINE void differentiate_lanes(const nsdf_block_loss *loss, vec d, vec *sum, vec *value, vec *error) {
    const mask held = *sum > (vec){0};
    const vec one = splat(1.0f), size = size_of(d), f = *value / choose(held, *sum, one);
    const vec side = choose(d < (vec){0}, -f, f), away = loss->weight_distance / (loss->weight_distance + size);
    const vec weight = choose(side < loss->safe_share * size, one, away);
    const vec share = loss->scale * weight / choose(held, *sum, one);
    *sum = (vec)(held & (mask)choose(f > d, share, -share));
    *value = (vec)(held & (mask)f);
    *error = choose(held & (size < splat(loss->near_limit)), size_of(f - d), splat(-1.0f));
}

static nsdf_block_loss_sums differentiate(nsdf_block_work *w, const nsdf_block_batch *b, const nsdf_block_loss *loss) {
    nsdf_block_loss_sums sums = {0.0, 0, 0};
    for (uint32_t i = 0; i < b->count; i += LANES) {
        float sum[LANES], value[LANES], d[LANES], error[LANES];
        for (uint32_t l = 0; l < LANES; l++) {
            sum[l] = w->sum[i + l][0];
            value[l] = w->sum[i + l][1];
            d[l] = b->point[i + l][3];
        }
        for (uint32_t l = 0; l < LANES; l += W) {
            vec s = load(sum + l), v = load(value + l), e;
            differentiate_lanes(loss, load(d + l), &s, &v, &e);
            store(sum + l, s);
            store(value + l, v);
            store(error + l, e);
        }
        for (uint32_t l = 0; l < LANES; l++) {
            sums.count += sum[l] != 0.0f;
            sums.near_count += error[l] >= 0.0f;
            sums.near_error += error[l] >= 0.0f ? (double)error[l] : 0.0;
            w->sum[i + l][0] = sum[l];
            w->sum[i + l][1] = value[l];
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
    vec share, f, slope[3], *slope_sums = sums + terms_of(degree), *moments = slope_sums + 3;
    gather_pairs((const float(*)[2])w->sum, w->point + i, &share, &f);
    const vec s = share * root, weight = s * root, fall = 4.0f * s * (load(w->hit[4] + i) - f);
    add_monomials(degree, weight, u[0], u[1], u[2], sums);
    slopes(degree, t, u[0], u[1], u[2], slope);
    for (int k = 0; k < 3; k++) {
        const vec g = weight * slope[k] - fall * u[k];
        slope_sums[k] += g;
        for (int j = 0; j < 3; j++)
            moments[3 * k + j] += g * u[j];
    }
}

/* The sum of the lanes, four sums at once: halves are added until one lane is left. */
INLINE void add_lanes(float sums[4][LANES], float *out) {
    vec4 quarter[4];
    for (int s = 0; s < 4; s++)
        quarter[s] = (load4(sums[s]) + load4(sums[s] + 8)) + (load4(sums[s] + 4) + load4(sums[s] + 12));
    const vec4 a = __builtin_shufflevector(quarter[0], quarter[1], 0, 4, 1, 5);
    const vec4 b = __builtin_shufflevector(quarter[2], quarter[3], 0, 4, 1, 5);
    const vec4 c = __builtin_shufflevector(quarter[0], quarter[1], 2, 6, 3, 7);
    const vec4 d = __builtin_shufflevector(quarter[2], quarter[3], 2, 6, 3, 7);
    const vec4 lane0 = __builtin_shufflevector(a, b, 0, 1, 4, 5), lane1 = __builtin_shufflevector(a, b, 2, 3, 6, 7);
    const vec4 lane2 = __builtin_shufflevector(c, d, 0, 1, 4, 5), lane3 = __builtin_shufflevector(c, d, 2, 3, 6, 7);
    const vec4 sum = (lane0 + lane2) + (lane1 + lane3);
    memcpy(out, &sum, sizeof sum);
}

/* `degree` is a constant where this is inlined: the sums then live in registers, as far as there are any. */
INLINE void backward_degree(const nsdf_block_work *w, uint32_t from, uint32_t to, uint32_t degree, const float *t,
                            nsdf_block_gradient *out) {
    const uint32_t terms = terms_of(degree), count = terms + 12;
    float lanes[MOST_SUMS][LANES], flat[MOST_SUMS];
    for (uint32_t part = 0; part < LANES; part += W) {
        vec sums[MOST_SUMS];
        for (uint32_t s = 0; s < count; s++)
            sums[s] = (vec){0};
        for (uint32_t i = from + part; i < to; i += LANES)
            add_hits(w, i, degree, t, sums);
        for (uint32_t s = 0; s < count; s++)
            store(lanes[s] + part, sums[s]);
    }
    for (uint32_t s = count; s < (count + 3) / 4 * 4; s++)
        memset(lanes[s], 0, sizeof lanes[s]);
    for (uint32_t s = 0; s < count; s += 4)
        add_lanes(lanes + s, flat + s);
    memset(out->terms, 0, sizeof out->terms);
    memcpy(out->terms, flat, terms * sizeof *flat);
    memcpy(out->slope, flat + terms, sizeof out->slope);
    memcpy(out->moment, flat + terms + 3, sizeof out->moment);
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
