/* A block's polynomial, with terms in the order of nsdf_block_term, at one point. */
#ifndef NSDF_BLOCK_POLYNOMIAL_H
#define NSDF_BLOCK_POLYNOMIAL_H

#include <stdint.h>

static inline float nsdf_block_value(const float *t, uint32_t degree, const float u[3]) {
    const float x = u[0], y = u[1], z = u[2];
    float value = t[0] + t[1] * x + t[2] * y + t[3] * z;
    if (degree >= 2)
        value += x * (t[4] * x + t[5] * y + t[6] * z) + y * (t[7] * y + t[8] * z) + z * (t[9] * z);
    if (degree >= 3)
        value += x * x * (t[10] * x + t[11] * y + t[12] * z) + x * (y * (t[13] * y + t[14] * z) + t[15] * z * z) +
                 y * y * (t[16] * y + t[17] * z) + z * z * (t[18] * y + t[19] * z);
    return value;
}

static inline void nsdf_block_slope(const float *t, uint32_t degree, const float u[3], float slope[3]) {
    const float x = u[0], y = u[1], z = u[2];
    slope[0] = t[1];
    slope[1] = t[2];
    slope[2] = t[3];
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

#endif
