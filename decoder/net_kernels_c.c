/* Kernels in plain C: the reference that every other table is tested against. */
#include "net_kernels.h"

#include <string.h>

static uint32_t bits_of(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static float float_of(uint32_t bits) {
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* NaN stays NaN. */
static float clamp(float x, float low, float high) {
    return x < low ? low : x > high ? high : x;
}

/* z = n + r with n an integer and |r| <= 1/2; *sign gets n's parity in the sign bit, which turns sin(pi r) into
 * sin(pi z) and cos(pi r) into cos(pi z).  Exact for |z| < 2^22; above, where floats are half a turn apart or more,
 * the clamp keeps results within [-1, 1]. */
static float reduce(float z, uint32_t *sign) {
    float shifted = z + NSDF_ROUNDER;
    *sign = bits_of(shifted) << 31;
    return clamp(z - (shifted - NSDF_ROUNDER), -0.5f, 0.5f);
}

/* Largest error for |pi z| <= 1000: 1.7e-7, nearly all of it rounding. */
static float sine_of(float r, uint32_t sign) {
    float y = r * r;
    float p = NSDF_SIN_4;
    p = p * y + NSDF_SIN_3;
    p = p * y + NSDF_SIN_2;
    p = p * y + NSDF_SIN_1;
    p = p * y + NSDF_SIN_0;
    return float_of(bits_of(p * r) ^ sign);
}

static float cosine_of(float r, uint32_t sign) {
    float y = r * r;
    float p = NSDF_COS_5;
    p = p * y + NSDF_COS_4;
    p = p * y + NSDF_COS_3;
    p = p * y + NSDF_COS_2;
    p = p * y + NSDF_COS_1;
    p = p * y + NSDF_COS_0;
    return float_of(bits_of(p) ^ sign);
}

/* tanh |x| = e / (e + 2) with e = exp(2 |x|) - 1, which loses nothing near 0.  Largest error 2e-7. */
static float tanh_of(float x) {
    float y = clamp(2.0f * float_of(bits_of(x) & 0x7fffffffu), 0.0f, NSDF_TANH_LIMIT);
    float shifted = y * NSDF_LOG2_E + NSDF_ROUNDER;
    float n = shifted - NSDF_ROUNDER;
    float r = (y - n * NSDF_LN2_HIGH) - n * NSDF_LN2_LOW;
    float p = NSDF_EXP_4;
    p = p * r + NSDF_EXP_3;
    p = p * r + NSDF_EXP_2;
    p = p * r + NSDF_EXP_1;
    p = p * r + NSDF_EXP_0;
    p = p * (r * r) + r;
    float power = float_of((bits_of(shifted) << 23) + 0x3f800000u); /* 2^n */
    float e = power * p + (power - 1.0f);
    return float_of(bits_of(e / (e + 2.0f)) | (bits_of(x) & 0x80000000u));
}

static void linear_row(uint32_t inputs, size_t stride, const float *w, float bias, const float *in, const float *gain,
                       float *out) {
    float sum[NSDF_TILE];
    for (int p = 0; p < NSDF_TILE; p++)
        sum[p] = bias;
    for (uint32_t i = 0; i < inputs; i++) {
        const float weight = w[i * stride];
        const float *x = in + (size_t)i * NSDF_TILE;
        for (int p = 0; p < NSDF_TILE; p++)
            sum[p] += weight * x[p];
    }
    for (int p = 0; p < NSDF_TILE; p++)
        out[p] = gain ? sum[p] * gain[p] : sum[p];
}

static void linear(uint32_t outputs, uint32_t inputs, const float *weights, const float *bias, const float *in,
                   const float *gain, float *out) {
    for (uint32_t o = 0; o < outputs; o += nsdf_panel_height(outputs - o)) {
        const uint32_t height = nsdf_panel_height(outputs - o);
        for (uint32_t row = o; row < o + height; row++) {
            const size_t at = (size_t)row * NSDF_TILE;
            linear_row(inputs, height, weights + (size_t)o * inputs + (row - o), bias ? bias[row] : 0.0f, in,
                       gain ? gain + at : NULL, out + at);
        }
    }
}

static void relu(size_t count, float *z, float *slope) {
    for (size_t i = 0; i < count; i++) {
        if (slope)
            slope[i] = z[i] > 0.0f ? 1.0f : 0.0f;
        z[i] = z[i] > 0.0f ? z[i] : 0.0f;
    }
}

static void sine(size_t count, float *z, float *slope) {
    for (size_t i = 0; i < count; i++) {
        uint32_t sign;
        const float r = reduce(z[i], &sign);
        if (slope)
            slope[i] = NSDF_SIN_0 * cosine_of(r, sign);
        z[i] = sine_of(r, sign);
    }
}

static void hyperbolic(size_t count, float *z, float *slope) {
    for (size_t i = 0; i < count; i++) {
        z[i] = tanh_of(z[i]);
        if (slope)
            slope[i] = 1.0f - z[i] * z[i];
    }
}

static void activate(nsdf_activation kind, size_t tiles, float *z, float *slope) {
    const size_t count = tiles * NSDF_TILE;
    if (kind == NSDF_ACT_RELU)
        relu(count, z, slope);
    else if (kind == NSDF_ACT_SINE)
        sine(count, z, slope);
    else if (kind == NSDF_ACT_TANH)
        hyperbolic(count, z, slope);
    else
        for (size_t i = 0; slope && i < count; i++)
            slope[i] = 1.0f;
}

static void turn(size_t tiles, const float *z, float *cosine, float *sines) {
    for (size_t i = 0; i < tiles * NSDF_TILE; i++) {
        uint32_t sign;
        const float r = reduce(z[i], &sign);
        cosine[i] = cosine_of(r, sign);
        sines[i] = sine_of(r, sign);
    }
}

static const nsdf_net_kernels table = {"c", linear, activate, turn};

const nsdf_net_kernels *nsdf_net_kernels_c(void) {
    return &table;
}
