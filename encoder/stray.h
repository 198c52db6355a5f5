/* Where the network puts a surface that is not there: hard samples for the rest of fitting. */
#ifndef NSDF_STRAY_H
#define NSDF_STRAY_H

#include "fit_network.h"
#include "frames.h"
#include "sampler.h"
#include "workers.h"

/* A crossing of the network's zero set further than this from the input counts as stray. */
#define NSDF_STRAY_TOLERANCE 0.01f

typedef struct nsdf_stray_job {
    const nsdf_model *model;
    const nsdf_fit_kernels *kernels;
    nsdf_fit_scratch *const *scratch; /* [worker] */
    const float *parameters;
    const nsdf_frames *frames;
    const double *u;                    /* [frame_count] */
    float domain_min[3], domain_max[3]; /* normalised */
    uint32_t resolution;                /* cells of the search grid along the domain's longest side */
    uint64_t seed;                      /* moves the grid */
    nsdf_workers *workers;
    nsdf_sample_set *hard; /* [frame_count]: points found are added, up to NSDF_MOST_HARD */
} nsdf_stray_job;

enum { NSDF_MOST_HARD = 8192 };

/* Gives an empty set room for NSDF_MOST_HARD samples.  Returns 0, or -1 when memory ran out. */
int nsdf_stray_room(nsdf_sample_set *hard);

/* Evaluates the network on a grid at every frame, and looks up the true distance wherever the sign changes along an
 * edge.  *found gets the number of stray crossings over all frames.  Returns 0, or -1 when memory ran out. */
int nsdf_find_strays(const nsdf_stray_job *job, uint64_t *found);

#endif
