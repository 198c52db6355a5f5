/* Kernels for one vector instruction set: included once by each net_kernels_ISA.c, which defines
 *   TARGET             attribute that lets a function use the instruction set
 *   NAME               the table's name
 *   LANES, ROWS        floats in a vector; rows of a panel that are worked on at once
 *   VEC                the vector type
 *   v_load v_store v_set v_add v_sub v_mul v_div v_fma (a * b + c) v_fnma (c - a * b) v_min v_max (the second argument
 *   when one is not a number), v_and v_or v_xor (of bits), v_bits (constant from bits), v_shift (bits, left), v_addi
 *   (integers), v_positive (x > 0 ? y : 0)
 * The algorithms are those of net_kernels_c.c, where they are explained. */
#include "net_kernels.h"

enum { BLOCK = 3 * LANES }; /* points that are worked on at once */

/* Sums indexed by a loop counter are registers only when the loop is gone, which compilers do unasked at -O3 only. */
#if defined(__clang__)
#define UNROLL _Pragma("clang loop unroll(full)")
#else
#define UNROLL _Pragma("GCC unroll 8")
#endif
#define INLINE TARGET static inline __attribute__((always_inline))

/* `rows` is a constant where this is called: the sums then live in registers. */
INLINE void linear_block(int rows, size_t stride, uint32_t inputs, const float *w, const float *bias, const float *in,
                         const float *gain, float *out) {
    VEC sum[ROWS][3];
    UNROLL
    for (int r = 0; r < rows; r++)
        sum[r][0] = sum[r][1] = sum[r][2] = v_set(bias ? bias[r] : 0.0f);
    for (uint32_t i = 0; i < inputs; i++, w += stride, in += NSDF_TILE) {
        const VEC x0 = v_load(in), x1 = v_load(in + LANES), x2 = v_load(in + 2 * LANES);
        UNROLL
        for (int r = 0; r < rows; r++) {
            const VEC weight = v_set(w[r]);
            sum[r][0] = v_fma(weight, x0, sum[r][0]);
            sum[r][1] = v_fma(weight, x1, sum[r][1]);
            sum[r][2] = v_fma(weight, x2, sum[r][2]);
        }
    }
    UNROLL
    for (int r = 0; r < rows; r++) {
        UNROLL
        for (int v = 0; v < 3; v++) {
            const int at = r * NSDF_TILE + v * LANES;
            v_store(out + at, gain ? v_mul(sum[r][v], v_load(gain + at)) : sum[r][v]);
        }
    }
}

/* One panel for all points of the tile. */
INLINE void linear_panel(int height, int rows, uint32_t inputs, const float *w, const float *bias, const float *in,
                         const float *gain, float *out) {
    for (int row = 0; row < height; row += rows) {
        for (int p = 0; p < NSDF_TILE; p += BLOCK) {
            const int at = row * NSDF_TILE + p;
            linear_block(rows, (size_t)height, inputs, w + row, bias ? bias + row : NULL, in + p,
                         gain ? gain + at : NULL, out + at);
        }
    }
}

TARGET static void linear(uint32_t outputs, uint32_t inputs, const float *weights, const float *bias, const float *in,
                          const float *gain, float *out) {
    for (uint32_t o = 0; o < outputs; o += nsdf_panel_height(outputs - o)) {
        const uint32_t height = nsdf_panel_height(outputs - o);
        const float *w = weights + (size_t)o * inputs, *b = bias ? bias + o : NULL;
        const size_t at = (size_t)o * NSDF_TILE;
        const float *g = gain ? gain + at : NULL;
        if (height == NSDF_PANEL)
            linear_panel(NSDF_PANEL, ROWS, inputs, w, b, in, g, out + at);
        else if (height == 4)
            linear_panel(4, 4, inputs, w, b, in, g, out + at);
        else
            linear_panel(1, 1, inputs, w, b, in, g, out + at);
    }
}

INLINE VEC reduce(VEC z, VEC *sign) {
    const VEC shifted = v_add(z, v_set(NSDF_ROUNDER));
    *sign = v_shift(shifted, 31);
    const VEC r = v_sub(z, v_sub(shifted, v_set(NSDF_ROUNDER)));
    return v_min(v_set(0.5f), v_max(v_set(-0.5f), r));
}

INLINE VEC sine_of(VEC r, VEC sign) {
    const VEC y = v_mul(r, r);
    VEC p = v_fma(v_set(NSDF_SIN_4), y, v_set(NSDF_SIN_3));
    p = v_fma(p, y, v_set(NSDF_SIN_2));
    p = v_fma(p, y, v_set(NSDF_SIN_1));
    p = v_fma(p, y, v_set(NSDF_SIN_0));
    return v_xor(v_mul(p, r), sign);
}

INLINE VEC cosine_of(VEC r, VEC sign) {
    const VEC y = v_mul(r, r);
    VEC p = v_fma(v_set(NSDF_COS_5), y, v_set(NSDF_COS_4));
    p = v_fma(p, y, v_set(NSDF_COS_3));
    p = v_fma(p, y, v_set(NSDF_COS_2));
    p = v_fma(p, y, v_set(NSDF_COS_1));
    p = v_fma(p, y, v_set(NSDF_COS_0));
    return v_xor(p, sign);
}

INLINE VEC tanh_of(VEC x) {
    const VEC size = v_and(x, v_bits(0x7fffffff));
    const VEC y = v_min(v_set(NSDF_TANH_LIMIT), v_add(size, size));
    const VEC shifted = v_fma(y, v_set(NSDF_LOG2_E), v_set(NSDF_ROUNDER));
    const VEC n = v_sub(shifted, v_set(NSDF_ROUNDER));
    const VEC r = v_fnma(n, v_set(NSDF_LN2_LOW), v_fnma(n, v_set(NSDF_LN2_HIGH), y));
    VEC p = v_fma(v_set(NSDF_EXP_4), r, v_set(NSDF_EXP_3));
    p = v_fma(p, r, v_set(NSDF_EXP_2));
    p = v_fma(p, r, v_set(NSDF_EXP_1));
    p = v_fma(p, r, v_set(NSDF_EXP_0));
    p = v_fma(p, v_mul(r, r), r);
    const VEC power = v_addi(v_shift(shifted, 23), v_set(1.0f));
    const VEC e = v_fma(power, p, v_sub(power, v_set(1.0f)));
    const VEC t = v_div(e, v_add(e, v_set(2.0f)));
    return v_or(t, v_and(x, v_bits(INT32_MIN)));
}

TARGET static void sine(size_t count, float *z, float *slope) {
    for (size_t i = 0; i < count; i += LANES) {
        VEC sign;
        const VEC r = reduce(v_load(z + i), &sign);
        if (slope)
            v_store(slope + i, v_mul(v_set(NSDF_SIN_0), cosine_of(r, sign)));
        v_store(z + i, sine_of(r, sign));
    }
}

TARGET static void hyperbolic(size_t count, float *z, float *slope) {
    for (size_t i = 0; i < count; i += LANES) {
        const VEC t = tanh_of(v_load(z + i));
        if (slope)
            v_store(slope + i, v_fnma(t, t, v_set(1.0f)));
        v_store(z + i, t);
    }
}

TARGET static void relu(size_t count, float *z, float *slope) {
    for (size_t i = 0; i < count; i += LANES) {
        const VEC x = v_load(z + i);
        if (slope)
            v_store(slope + i, v_positive(x, v_set(1.0f)));
        v_store(z + i, v_positive(x, x));
    }
}

TARGET static void activate(nsdf_activation kind, size_t tiles, float *z, float *slope) {
    const size_t count = tiles * NSDF_TILE;
    if (kind == NSDF_ACT_RELU)
        relu(count, z, slope);
    else if (kind == NSDF_ACT_SINE)
        sine(count, z, slope);
    else if (kind == NSDF_ACT_TANH)
        hyperbolic(count, z, slope);
    else
        for (size_t i = 0; slope && i < count; i += LANES)
            v_store(slope + i, v_set(1.0f));
}

TARGET static void turn(size_t tiles, const float *z, float *cosine, float *sines) {
    for (size_t i = 0; i < tiles * NSDF_TILE; i += LANES) {
        VEC sign;
        const VEC r = reduce(v_load(z + i), &sign);
        v_store(cosine + i, cosine_of(r, sign));
        v_store(sines + i, sine_of(r, sign));
    }
}

static const nsdf_net_kernels table = {NAME, linear, activate, turn};
