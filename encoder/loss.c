#include "loss.h"

#include <math.h>

static float sign_of(float x) {
    return x > 0.0f ? 1.0f : x < 0.0f ? -1.0f : 0.0f;
}

/* Thesis (4.2) with c1, c2, c3 of (4.9) to (4.11).  The argument of the blends c2 and c3 is s (|y| - delta), as (4.4)
 * and (4.8) say; (4.10) and (4.11) misplace the bracket. */
static float surface_sensitive(const nsdf_loss_params *p, float f, float d, float *derivative) {
    float s = p->slope, error = f - d;
    float tf = tanhf(s * f), half_sum = 0.5f * (tanhf(s * d) + tf);
    float c1 = fabsf(half_sum);
    float c2 = 0.5f * tanhf(s * (fabsf(d) - p->delta)) + 0.5f;
    float t3 = tanhf(s * (fabsf(f) - p->delta)), c3 = 0.5f * t3 + 0.5f;
    float c1_slope = sign_of(half_sum) * 0.5f * s * (1.0f - tf * tf);
    float c3_slope = 0.5f * s * (1.0f - t3 * t3) * sign_of(f);
    *derivative = (1.0f - c1 * c2 * c3) * sign_of(error) - c2 * (c1_slope * c3 + c1 * c3_slope) * fabsf(error);
    return (1.0f - c1 * c2 * c3) * fabsf(error);
}

/* Far from the surface only the sign matters: the weight falls with the distance, unless the sign is wrong.  About
 * something thin all distances are small, so that a hole in it would cost little if wrong signs weighed no more; both
 * signs do, since otherwise it gets thick. */
static float weighted(const nsdf_loss_params *p, float f, float d, float *derivative) {
    const float near = p->d0 / (p->d0 + fabsf(d));
    const float weight = f * d < 0.0f ? 1.0f + (p->sign - 1.0f) * near : near;
    *derivative = weight * sign_of(f - d);
    return weight * fabsf(f - d);
}

float nsdf_loss_value(const nsdf_loss_params *params, float f, float d, float *derivative) {
    if (params->kind == NSDF_LOSS_SURFACE_SENSITIVE)
        return surface_sensitive(params, f, d, derivative);
    if (params->kind == NSDF_LOSS_WEIGHTED_MAE)
        return weighted(params, f, d, derivative);
    *derivative = sign_of(f - d); /* mean absolute error, thesis 4.1 */
    return fabsf(f - d);
}

double nsdf_loss_batch(const nsdf_loss_params *params, const float *f, const float *d, size_t count, float scale,
                       float *derivative, float *losses) {
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) {
        float loss = nsdf_loss_value(params, f[i], d[i], &derivative[i]);
        sum += (double)loss;
        derivative[i] *= scale;
        if (losses)
            losses[i] = loss;
    }
    return sum;
}
