/* The kernels of fit_kernels.h on vectors of LANES floats (GCC and Clang vector extension).  Included once per
 * instruction set by a source file that is compiled for it and defines
 *   KERNELS_NAME            text
 *   LANES                   4, 8 or 16
 *   ROW_BLOCK               rows of a product kept in registers, two vectors each
 *   OUTER_ROWS, OUTER_COLS  block of an outer product kept in registers
 *   OWN_SHORT               where the file has multiply_short, outer_short and the set of kernels itself */
#include "fit_kernels.h"

#include <string.h>

typedef float vec __attribute__((vector_size(4 * LANES)));
typedef int32_t mask __attribute__((vector_size(4 * LANES)));

static inline vec splat(float f) {
    return f - (vec){0};
}

static inline vec load(const float *p) {
    return *(const vec *)p;
}

static inline void store(float *p, vec v) {
    *(vec *)p = v;
}

static inline vec choose(mask m, vec a, vec b) {
    return (vec)((m & (mask)a) | (~m & (mask)b));
}

/* `n` rows of a product for two vectors of points; n is a constant wherever this is inlined. */
static inline __attribute__((always_inline)) void rows_times_points(const int n, const float *a, size_t stride,
                                                                    uint32_t cols, const float *x, float *y) {
    vec lo[ROW_BLOCK], hi[ROW_BLOCK];
    for (int r = 0; r < n; r++)
        lo[r] = hi[r] = (vec){0};
    for (uint32_t i = 0; i < cols; i++) {
        vec xl = load(x + (size_t)i * NSDF_PANEL), xh = load(x + (size_t)i * NSDF_PANEL + LANES);
        for (int r = 0; r < n; r++) {
            vec w = splat(a[(size_t)r * stride + i]);
            lo[r] += w * xl;
            hi[r] += w * xh;
        }
    }
    for (int r = 0; r < n; r++) {
        store(y + r * NSDF_PANEL, lo[r]);
        store(y + r * NSDF_PANEL + LANES, hi[r]);
    }
}

static void multiply(const float *a, size_t stride, uint32_t rows, uint32_t cols, const float *x, size_t x_panel,
                     float *y, size_t y_panel, uint32_t panels) {
    for (uint32_t k = 0; k < panels; k++)
        for (uint32_t p = 0; p < NSDF_PANEL; p += 2 * LANES) {
            const float *xp = x + k * x_panel + p;
            float *yp = y + k * y_panel + p;
            uint32_t o = 0;
            for (; o + ROW_BLOCK <= rows; o += ROW_BLOCK)
                rows_times_points(ROW_BLOCK, a + o * stride, stride, cols, xp, yp + (size_t)o * NSDF_PANEL);
            for (; o + 4 <= rows; o += 4)
                rows_times_points(4, a + o * stride, stride, cols, xp, yp + (size_t)o * NSDF_PANEL);
            for (; o < rows; o++)
                rows_times_points(1, a + o * stride, stride, cols, xp, yp + (size_t)o * NSDF_PANEL);
        }
}

static inline float sum_lanes(vec v) {
    float sum = 0;
    for (int i = 0; i < LANES; i++)
        sum += v[i];
    return sum;
}

#if LANES == 16 && OUTER_ROWS * OUTER_COLS == 16
/* Sums of neighbouring lanes: a0+a1, a2+a3, ..., b0+b1, ... */
static inline vec add_pairs(vec a, vec b) {
    return __builtin_shufflevector(a, b, 0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30) +
           __builtin_shufflevector(a, b, 1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
}

/* Lane i of the result is the sum over the lanes of v[i]: a tree of 15 pairwise additions. */
static inline vec sum_each(vec v[16]) {
    for (int n = 8; n > 0; n /= 2)
        for (int i = 0; i < n; i++)
            v[i] = add_pairs(v[2 * i], v[2 * i + 1]);
    return v[0];
}
#else
static inline vec sum_each(vec *v) {
    return v[0];
}
#endif

/* An n x m block of the outer product, summed over all panels. */
static inline __attribute__((always_inline)) void outer_block(const int n, const int m, const float *dz,
                                                              size_t dz_panel, const float *x, size_t x_panel, float *g,
                                                              size_t stride, uint32_t panels) {
    vec sum[OUTER_ROWS * OUTER_COLS];
    for (int r = 0; r < n * m; r++)
        sum[r] = (vec){0};
    for (uint32_t k = 0; k < panels; k++)
        for (int part = 0; part < NSDF_PANEL; part += LANES) {
            vec xs[OUTER_COLS];
            for (int c = 0; c < m; c++)
                xs[c] = load(x + k * x_panel + c * NSDF_PANEL + part);
            for (int r = 0; r < n; r++) {
                vec d = load(dz + k * dz_panel + r * NSDF_PANEL + part);
                for (int c = 0; c < m; c++)
                    sum[r * m + c] += d * xs[c];
            }
        }
    if (LANES == 16 && n * m == 16) {
        vec all = sum_each(sum);
        for (int r = 0; r < n; r++)
            for (int c = 0; c < m; c++)
                g[(size_t)r * stride + (size_t)c] += all[r * m + c];
        return;
    }
    for (int r = 0; r < n; r++)
        for (int c = 0; c < m; c++)
            g[(size_t)r * stride + (size_t)c] += sum_lanes(sum[r * m + c]);
}

static void outer(const float *dz, size_t dz_panel, uint32_t rows, const float *x, size_t x_panel, uint32_t cols,
                  float *g, size_t stride, uint32_t panels) {
    uint32_t o = 0;
    for (; o + OUTER_ROWS <= rows; o += OUTER_ROWS) {
        const float *d = dz + (size_t)o * NSDF_PANEL;
        uint32_t i = 0;
        for (; i + OUTER_COLS <= cols; i += OUTER_COLS)
            outer_block(OUTER_ROWS, OUTER_COLS, d, dz_panel, x + (size_t)i * NSDF_PANEL, x_panel, g + o * stride + i,
                        stride, panels);
        for (; i < cols; i++)
            outer_block(OUTER_ROWS, 1, d, dz_panel, x + (size_t)i * NSDF_PANEL, x_panel, g + o * stride + i, stride,
                        panels);
    }
    for (; o < rows; o++)
        for (uint32_t i = 0; i < cols; i++)
            outer_block(1, 1, dz + (size_t)o * NSDF_PANEL, dz_panel, x + (size_t)i * NSDF_PANEL, x_panel,
                        g + o * stride + i, stride, panels);
}

/* x = k pi + r, |r| <= pi / 2, pi in three parts (Cody & Waite); then polynomials through Chebyshev nodes, errors below
 * 2.7e-8 (sine) and 3.6e-9 (cosine) before rounding; the sign is that of (-1)^k. */
static inline void sine_cosine(vec x, vec *sine, vec *cosine) {
    const vec round = splat(12582912.0f); /* 1.5 * 2^23: adding it rounds to an integer in the low bits */
    vec shifted = x * splat(0.318309886f) + round;
    vec k = shifted - round;
    mask sign = (mask)shifted << 31;
    vec r = x - k * splat(3.140625f);
    r -= k * splat(9.67025757e-4f);
    r -= k * splat(6.2783295e-7f);
    vec s = r * r;
    vec ps = splat(2.634638e-06f) * s + splat(-0.000198227029f);
    ps = ps * s + splat(0.00833324186f);
    ps = ps * s + splat(-0.16666666f);
    vec pc = splat(-2.6545073e-07f) * s + splat(2.47860518e-05f);
    pc = pc * s + splat(-0.00138888123f);
    pc = pc * s + splat(0.0416666661f);
    *sine = (vec)((mask)(r + r * s * ps) ^ sign);
    *cosine = (vec)((mask)(splat(1.0f) - splat(0.5f) * s + s * s * pc) ^ sign);
}

static void sine(float *z, float *slope, size_t count, float omega) {
    for (size_t i = 0; i < count; i += LANES) {
        vec s, c;
        sine_cosine(load(z + i) * splat(omega), &s, &c);
        store(z + i, s);
        store(slope + i, c * splat(omega));
    }
}

static void relu(float *z, float *slope, size_t count) {
    for (size_t i = 0; i < count; i += LANES) {
        vec x = load(z + i);
        mask positive = x > (vec){0};
        store(z + i, choose(positive, x, (vec){0}));
        store(slope + i, choose(positive, splat(1.0f), (vec){0}));
    }
}

/* tanh x = 1 - 2 / (e^2x + 1), e^y by 2^k and a polynomial of degree 6; odd, so computed for |x| <= 10. */
static void tanh_panel(float *z, float *slope, size_t count) {
    const vec round = splat(12582912.0f);
    for (size_t i = 0; i < count; i += LANES) {
        vec x = load(z + i), y = x + x;
        y = choose(y > splat(20.0f), splat(20.0f), y);
        y = choose(y < splat(-20.0f), splat(-20.0f), y);
        vec shifted = y * splat(1.44269504f) + round;
        vec k = shifted - round;
        vec r = y - k * splat(0.693359375f);
        r += k * splat(2.12194440e-4f);
        vec e = splat(1.0f / 720) * r + splat(1.0f / 120);
        e = e * r + splat(1.0f / 24);
        e = e * r + splat(1.0f / 6);
        e = e * r + splat(0.5f);
        e = e * r * r + r + splat(1.0f);
        mask power = ((mask)shifted << 23) + ((mask){0} + (127 << 23));
        vec t = splat(1.0f) - splat(2.0f) / (e * (vec)power + splat(1.0f));
        store(z + i, t);
        store(slope + i, splat(1.0f) - t * t);
    }
}

static void scale(float *y, const float *x, size_t count) {
    for (size_t i = 0; i < count; i += LANES)
        store(y + i, load(y + i) * load(x + i));
}

#ifndef OWN_SHORT
static const nsdf_fit_kernels kernels = {KERNELS_NAME, multiply, outer, multiply, outer, sine, relu, tanh_panel, scale};
#endif
