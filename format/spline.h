/* Uniform cubic B-spline over u in [0, 1] with `knots` control points (spec, section "Evaluating a network"). */
#ifndef NSDF_SPLINE_H
#define NSDF_SPLINE_H

#include <stdint.h>

/* Weights of the control points first .. first + 3 at u, which is clamped to [0, 1]; knots >= 4.  Returns first.
 * Computed in double, so that no machine's contraction of products changes the float weights by more than an ulp. */
static inline uint32_t nsdf_spline_weights(double u, uint32_t knots, float weight[4]) {
    uint32_t spans = knots - 3;
    double s = u <= 0.0 ? 0.0 : u >= 1.0 ? (double)spans : u * (double)spans;
    uint32_t first = (uint32_t)s < spans ? (uint32_t)s : spans - 1;
    double f = s - (double)first, g = 1.0 - f;
    weight[0] = (float)(g * g * g / 6.0);
    weight[1] = (float)((3.0 * f * f * f - 6.0 * f * f + 4.0) / 6.0);
    weight[2] = (float)((3.0 * g * g * g - 6.0 * g * g + 4.0) / 6.0);
    weight[3] = (float)(f * f * f / 6.0);
    return first;
}

#endif
