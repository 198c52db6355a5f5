/* The inner loops of block_batch.h, included once per instruction set with TARGET (an attribute, or nothing) defined,
 * and OWN_APPEND where the instruction set has an append() of its own.
 * Loops over NSDF_HIT_LANES lanes are for the compiler to turn into vectors. */
#include "block_batch.h"

enum { LANES = NSDF_HIT_LANES };
#define LEAST_ROOT 1e-4f /* 1 - |u|^2: nearer to the border a point does not count */

#ifndef OWN_APPEND
/* Adds the first n lanes, points from `from` on, that are inside the ball to the hits; there is room for all lanes. */
TARGET static uint32_t append(nsdf_block_batch *b, float u[4][LANES], uint32_t from, uint32_t n, uint32_t at) {
    for (uint32_t l = 0; l < n; l++) {
        b->point[at] = from + l;
        for (int i = 0; i < 4; i++)
            b->hit[i][at] = u[i][l];
        at += u[3][l] > LEAST_ROOT;
    }
    return at;
}
#endif

TARGET static uint32_t find(nsdf_block_batch *b, const float m[12], uint32_t from, uint32_t to, uint32_t at) {
    const float *restrict x = b->sorted[0], *restrict y = b->sorted[1], *restrict z = b->sorted[2];
    for (; from < to; from += LANES) {
        float u[4][LANES];
        const uint32_t n = to - from < LANES ? to - from : LANES;
        for (uint32_t l = 0; l < LANES; l++) { /* there is room behind the last point */
            for (int row = 0; row < 3; row++)
                u[row][l] = m[4 * row] * x[from + l] + m[4 * row + 1] * y[from + l] + m[4 * row + 2] * z[from + l] +
                            m[4 * row + 3];
            u[3][l] = 1.0f - (u[0][l] * u[0][l] + u[1][l] * u[1][l] + u[2][l] * u[2][l]);
        }
        at = append(b, u, from, n, at);
    }
    return at;
}

TARGET static void values(const float *restrict t, uint32_t degree, const float *restrict x, const float *restrict y,
                          const float *restrict z, float *restrict value) {
    for (uint32_t l = 0; l < LANES; l++)
        value[l] = t[0] + t[1] * x[l] + t[2] * y[l] + t[3] * z[l];
    for (uint32_t l = 0; degree >= 2 && l < LANES; l++)
        value[l] += x[l] * (t[4] * x[l] + t[5] * y[l] + t[6] * z[l]) + y[l] * (t[7] * y[l] + t[8] * z[l]) +
                    z[l] * (t[9] * z[l]);
    for (uint32_t l = 0; degree >= 3 && l < LANES; l++)
        value[l] += x[l] * x[l] * (t[10] * x[l] + t[11] * y[l] + t[12] * z[l]) +
                    x[l] * (y[l] * (t[13] * y[l] + t[14] * z[l]) + t[15] * z[l] * z[l]) +
                    y[l] * y[l] * (t[16] * y[l] + t[17] * z[l]) + z[l] * z[l] * (t[18] * y[l] + t[19] * z[l]);
}

TARGET static void forward(nsdf_block_batch *b, uint32_t block, uint32_t degree, const float *t) {
    for (uint32_t i = b->first[block]; i < b->first[block + 1]; i += LANES) {
        float *value = b->hit[4] + i, weight[LANES], part[LANES];
        const float *root = b->hit[3] + i;
        values(t, degree, b->hit[0] + i, b->hit[1] + i, b->hit[2] + i, value);
        for (uint32_t l = 0; l < LANES; l++) {
            weight[l] = root[l] * root[l];
            part[l] = weight[l] * value[l];
        }
        for (uint32_t l = 0; l < LANES; l++) {
            b->weight[b->point[i + l]] += weight[l];
            b->value[b->point[i + l]] += part[l];
        }
    }
}

/* Slopes of the polynomial with respect to u. */
TARGET static void slopes(const float *restrict t, uint32_t degree, const float *restrict xs, const float *restrict ys,
                          const float *restrict zs, float slope[restrict 3][LANES]) {
    for (uint32_t l = 0; l < LANES; l++) {
        slope[0][l] = t[1];
        slope[1][l] = t[2];
        slope[2][l] = t[3];
    }
    for (uint32_t l = 0; degree >= 2 && l < LANES; l++) {
        const float x = xs[l], y = ys[l], z = zs[l];
        slope[0][l] += 2.0f * t[4] * x + t[5] * y + t[6] * z;
        slope[1][l] += t[5] * x + 2.0f * t[7] * y + t[8] * z;
        slope[2][l] += t[6] * x + t[8] * y + 2.0f * t[9] * z;
    }
    for (uint32_t l = 0; degree >= 3 && l < LANES; l++) {
        const float x = xs[l], y = ys[l], z = zs[l];
        slope[0][l] +=
            x * (3.0f * t[10] * x + 2.0f * (t[11] * y + t[12] * z)) + y * (t[13] * y + t[14] * z) + t[15] * z * z;
        slope[1][l] +=
            x * (t[11] * x + 2.0f * t[13] * y + t[14] * z) + y * (3.0f * t[16] * y + 2.0f * t[17] * z) + t[18] * z * z;
        slope[2][l] +=
            x * (t[12] * x + t[14] * y + 2.0f * t[15] * z) + t[17] * y * y + z * (2.0f * t[18] * y + 3.0f * t[19] * z);
    }
}

enum { FIRST_SLOPE = NSDF_BLOCK_MOST_TERMS, FIRST_MOMENT = FIRST_SLOPE + 3, SUMS = FIRST_MOMENT + 9 };

/* w times every monomial of a degree, in nsdf_block_term's order. */
TARGET static void add_monomials(uint32_t degree, const float *restrict w, const float *restrict x,
                                 const float *restrict y, const float *restrict z, float sums[restrict SUMS][LANES]) {
    for (uint32_t l = 0; l < LANES; l++) {
        const float wx = w[l] * x[l], wy = w[l] * y[l], wz = w[l] * z[l];
        sums[0][l] += w[l];
        sums[1][l] += wx;
        sums[2][l] += wy;
        sums[3][l] += wz;
    }
    for (uint32_t l = 0; degree >= 2 && l < LANES; l++) {
        const float wx = w[l] * x[l], wy = w[l] * y[l], wz = w[l] * z[l];
        sums[4][l] += wx * x[l];
        sums[5][l] += wx * y[l];
        sums[6][l] += wx * z[l];
        sums[7][l] += wy * y[l];
        sums[8][l] += wy * z[l];
        sums[9][l] += wz * z[l];
    }
    for (uint32_t l = 0; degree >= 3 && l < LANES; l++) {
        const float xx = w[l] * x[l] * x[l], yy = w[l] * y[l] * y[l], zz = w[l] * z[l] * z[l];
        const float xyz = w[l] * x[l] * y[l] * z[l];
        sums[10][l] += xx * x[l];
        sums[11][l] += xx * y[l];
        sums[12][l] += xx * z[l];
        sums[13][l] += yy * x[l];
        sums[14][l] += xyz;
        sums[15][l] += zz * x[l];
        sums[16][l] += yy * y[l];
        sums[17][l] += yy * z[l];
        sums[18][l] += zz * y[l];
        sums[19][l] += zz * z[l];
    }
}

/* Halves the lanes until one is left: the same order for all instruction sets. */
TARGET static void reduce(float sums[restrict SUMS][LANES]) {
    for (uint32_t half = LANES / 2; half > 0; half /= 2)
        for (int s = 0; s < SUMS; s++)
            for (uint32_t l = 0; l < half; l++)
                sums[s][l] += sums[s][l + half];
}

TARGET static void backward(const nsdf_block_batch *b, uint32_t block, uint32_t degree, const float *t,
                            nsdf_block_gradient *out) {
    float sums[SUMS][LANES] = {{0.0f}};
    for (uint32_t i = b->first[block]; i < b->first[block + 1]; i += LANES) {
        const float *u[3] = {b->hit[0] + i, b->hit[1] + i, b->hit[2] + i}, *root = b->hit[3] + i,
                    *value = b->hit[4] + i;
        float share[LANES], away[LANES], w[LANES], fall[LANES], slope[3][LANES];
        for (uint32_t l = 0; l < LANES; l++) {
            share[l] = b->weight[b->point[i + l]];
            away[l] = value[l] - b->value[b->point[i + l]];
        }
        for (uint32_t l = 0; l < LANES; l++) {
            const float s = share[l] * root[l];
            w[l] = s * root[l];
            fall[l] = 4.0f * s * away[l];
        }
        add_monomials(degree, w, u[0], u[1], u[2], sums);
        slopes(t, degree, u[0], u[1], u[2], slope);
        for (int k = 0; k < 3; k++)
            for (uint32_t l = 0; l < LANES; l++) {
                const float g = w[l] * slope[k][l] - fall[l] * u[k][l];
                sums[FIRST_SLOPE + k][l] += g;
                sums[FIRST_MOMENT + 3 * k][l] += g * u[0][l];
                sums[FIRST_MOMENT + 3 * k + 1][l] += g * u[1][l];
                sums[FIRST_MOMENT + 3 * k + 2][l] += g * u[2][l];
            }
    }
    reduce(sums);
    for (int s = 0; s < NSDF_BLOCK_MOST_TERMS; s++)
        out->terms[s] = sums[s][0];
    for (int s = 0; s < 3; s++)
        out->slope[s] = sums[FIRST_SLOPE + s][0];
    for (int s = 0; s < 9; s++)
        out->moment[s] = sums[FIRST_MOMENT + s][0];
}

static const nsdf_block_passes passes = {find, forward, backward};
