/* Adam (Kingma & Ba 2015) with linear warm-up and cosine decay of the rate. */
#ifndef NSDF_OPTIMISER_H
#define NSDF_OPTIMISER_H

#include <stddef.h>
#include <stdint.h>

typedef struct nsdf_adam {
    float *mean, *square; /* running averages of the gradient and of its square */
    size_t count;
    float beta1, beta2, epsilon;
    uint64_t step;
} nsdf_adam;

/* Returns 0, or -1 when memory ran out. */
int nsdf_adam_create(nsdf_adam *adam, size_t count);
void nsdf_adam_free(nsdf_adam *adam);

/* One step for all parameters. */
void nsdf_adam_step(nsdf_adam *adam, float *parameters, const float *gradient, double rate);

/* Rate at `step` of `steps`: rises linearly over the first 1 %, then falls along half a cosine to 1 % of `peak`. */
double nsdf_rate_schedule(uint64_t step, uint64_t steps, double peak);

#endif
