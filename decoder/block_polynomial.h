/* A block's polynomial of d = x - centre, with terms in the order of nsdf_block_term, and its weight, at one point; or
 * at several side by side, where NSDF_POLYNOMIAL_REAL is a vector of floats.  Slopes are written with the sums and
 * products that values have, so that the compiler finds them twice where both are wanted. */
#ifndef NSDF_BLOCK_POLYNOMIAL_H
#define NSDF_BLOCK_POLYNOMIAL_H

#include <stdint.h>

#ifndef NSDF_POLYNOMIAL_REAL
#define NSDF_POLYNOMIAL_REAL float
#define NSDF_POLYNOMIAL_INLINE static inline
#endif

/* q[0] x^2 + q[1] x y + q[2] x z + q[3] y^2 + q[4] y z + q[5] z^2. */
NSDF_POLYNOMIAL_INLINE NSDF_POLYNOMIAL_REAL nsdf_quadratic_value(const float q[6], const NSDF_POLYNOMIAL_REAL d[3]) {
    const NSDF_POLYNOMIAL_REAL x = d[0], y = d[1], z = d[2];
    return x * (q[0] * x + q[1] * y + q[2] * z) + y * (q[3] * y + q[4] * z) + z * (q[5] * z);
}

NSDF_POLYNOMIAL_INLINE void nsdf_quadratic_slope(const float q[6], const NSDF_POLYNOMIAL_REAL d[3],
                                                 NSDF_POLYNOMIAL_REAL slope[3]) {
    const NSDF_POLYNOMIAL_REAL x = d[0], y = d[1], z = d[2];
    slope[0] = (q[0] * x + q[1] * y + q[2] * z) + q[0] * x;
    slope[1] = (q[3] * y + q[4] * z) + q[3] * y + q[1] * x;
    slope[2] = q[5] * z + q[5] * z + q[4] * y + q[2] * x;
}

NSDF_POLYNOMIAL_INLINE NSDF_POLYNOMIAL_REAL nsdf_block_value(const float *t, uint32_t degree,
                                                             const NSDF_POLYNOMIAL_REAL d[3]) {
    const NSDF_POLYNOMIAL_REAL x = d[0], y = d[1], z = d[2];
    NSDF_POLYNOMIAL_REAL value = t[0] + t[1] * x + t[2] * y + t[3] * z;
    if (degree >= 2)
        value += nsdf_quadratic_value(t + 4, d);
    if (degree >= 3)
        value += x * x * (t[10] * x + t[11] * y + t[12] * z) + x * (y * (t[13] * y + t[14] * z) + t[15] * z * z) +
                 y * y * (t[16] * y + t[17] * z) + z * z * (t[18] * y + t[19] * z);
    return value;
}

NSDF_POLYNOMIAL_INLINE void nsdf_block_slope(const float *t, uint32_t degree, const NSDF_POLYNOMIAL_REAL d[3],
                                             NSDF_POLYNOMIAL_REAL slope[3]) {
    const NSDF_POLYNOMIAL_REAL x = d[0], y = d[1], z = d[2];
    for (int axis = 0; axis < 3; axis++)
        slope[axis] = (NSDF_POLYNOMIAL_REAL){0};
    if (degree >= 2)
        nsdf_quadratic_slope(t + 4, d, slope);
    for (int axis = 0; axis < 3; axis++)
        slope[axis] += t[1 + axis];
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
