/* A block's polynomial, with terms in the order of nsdf_block_term, at one point; or at several side by side, where
 * NSDF_POLYNOMIAL_REAL is a vector of floats. */
#ifndef NSDF_BLOCK_POLYNOMIAL_H
#define NSDF_BLOCK_POLYNOMIAL_H

#include <stdint.h>

#ifndef NSDF_POLYNOMIAL_REAL
#define NSDF_POLYNOMIAL_REAL float
#define NSDF_POLYNOMIAL_INLINE static inline
#endif

NSDF_POLYNOMIAL_INLINE NSDF_POLYNOMIAL_REAL nsdf_block_value(const float *t, uint32_t degree,
                                                             const NSDF_POLYNOMIAL_REAL u[3]) {
    const NSDF_POLYNOMIAL_REAL x = u[0], y = u[1], z = u[2];
    NSDF_POLYNOMIAL_REAL value = t[0] + t[1] * x + t[2] * y + t[3] * z;
    if (degree >= 2)
        value += x * (t[4] * x + t[5] * y + t[6] * z) + y * (t[7] * y + t[8] * z) + z * (t[9] * z);
    if (degree >= 3)
        value += x * x * (t[10] * x + t[11] * y + t[12] * z) + x * (y * (t[13] * y + t[14] * z) + t[15] * z * z) +
                 y * y * (t[16] * y + t[17] * z) + z * z * (t[18] * y + t[19] * z);
    return value;
}

NSDF_POLYNOMIAL_INLINE void nsdf_block_slope(const float *t, uint32_t degree, const NSDF_POLYNOMIAL_REAL u[3],
                                             NSDF_POLYNOMIAL_REAL slope[3]) {
    const NSDF_POLYNOMIAL_REAL x = u[0], y = u[1], z = u[2];
    for (int axis = 0; axis < 3; axis++)
        slope[axis] = (NSDF_POLYNOMIAL_REAL){0} + t[1 + axis];
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
