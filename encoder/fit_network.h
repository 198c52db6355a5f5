/* Forward and backward pass of the network for a batch of points at one time. */
#ifndef NSDF_FIT_NETWORK_H
#define NSDF_FIT_NETWORK_H

#include "fit_kernels.h"
#include "loss.h"
#include "model.h"

typedef struct nsdf_fit_scratch nsdf_fit_scratch; /* one per worker */

/* NULL when memory ran out. */
nsdf_fit_scratch *nsdf_fit_scratch_create(const nsdf_model *model);
void nsdf_fit_scratch_free(nsdf_fit_scratch *scratch);

typedef struct nsdf_fit_points {
    const float *x, *y, *z, *d; /* normalised position and signed distance */
    size_t count;
    float time; /* network time: time_scale * u */
} nsdf_fit_points;

typedef struct nsdf_fit_sums {
    double loss;       /* sum of the loss over the points */
    double near_error; /* sum of |f - d| over the points with |d| < near_limit */
    uint64_t near_count;
} nsdf_fit_sums;

/* Points with |d| below this count as near the surface. */
#define NSDF_NEAR_LIMIT 0.005f

/* Values f (signed distance, normalised) at the points. */
void nsdf_fit_forward(const nsdf_model *model, const nsdf_fit_kernels *kernels, nsdf_fit_scratch *scratch,
                      const float *composed, const nsdf_fit_points *points, float *f);

/* Adds to gradient[composed_size] the derivative of gradient_scale * sum of the losses, and to *sums.  losses (count
 * floats, may be NULL) gets the loss of each point. */
void nsdf_fit_backward(const nsdf_model *model, const nsdf_fit_kernels *kernels, nsdf_fit_scratch *scratch,
                       const float *composed, const nsdf_fit_points *points, const nsdf_loss_params *loss,
                       float gradient_scale, float *gradient, float *losses, nsdf_fit_sums *sums);

#endif
