/* The thesis's rejection sampling (5.1). */
#ifndef NSDF_SAMPLER_REJECTION_H
#define NSDF_SAMPLER_REJECTION_H

#include "sampler.h"

/* Fills the arrays of the set, which has room.  Returns 0, or -1 when memory ran out. */
int nsdf_fill_by_rejection(const nsdf_sdf *sdf, const nsdf_surface *surface, const nsdf_sampler_params *params,
                           nsdf_random *random, nsdf_sample_set *set);

static inline void nsdf_random_in_box(nsdf_random *random, const float low[3], const float high[3], float xyz[3]) {
    for (int k = 0; k < 3; k++) {
        xyz[k] = fminf(low[k] + nsdf_random_unit(random) * (high[k] - low[k]), high[k]);
    }
}

#endif
