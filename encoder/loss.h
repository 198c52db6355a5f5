/* Losses on signed distances (thesis 4.1, 4.2).  All in units of the diagonal. */
#ifndef NSDF_LOSS_H
#define NSDF_LOSS_H

#include "nsdf/encoder.h"

typedef struct nsdf_loss_params {
    nsdf_loss kind;
    float d0;           /* weighted: distance at which the weight has fallen to 1/2 */
    float delta, slope; /* surface-sensitive */
    float sign;         /* weighted: weight of a wrong sign at the surface, >= 1; far from it 1 */
} nsdf_loss_params;

/* Loss of one prediction f for the true distance d; *derivative is dL/df. */
float nsdf_loss_value(const nsdf_loss_params *params, float f, float d, float *derivative);

/* The same for many: derivative[i] = scale * dL/df[i]; losses[i] (losses may be NULL) = L; returns their sum. */
double nsdf_loss_batch(const nsdf_loss_params *params, const float *f, const float *d, size_t count, float scale,
                       float *derivative, float *losses);

#endif
