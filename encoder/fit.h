/* The fitting loop. */
#ifndef NSDF_FIT_H
#define NSDF_FIT_H

#include "fit_network.h"
#include "frames.h"
#include "quantise_model.h"
#include "sampler.h"
#include "time_budget.h"
#include "workers.h"

struct nsdf_checkpoint;
struct nsdf_tracked;

/* What rate control changes about fitting blocks. */
typedef struct nsdf_fit_control {
    int tuning; /* a fitted model: at a low rate, and rounded values from the first step on */
    /* Called now and then while values are rounded; may change the model's quantiser steps and the job's options.
     * May be NULL. */
    void (*steer)(void *user, uint64_t done, uint64_t steps);
    void *user;
} nsdf_fit_control;

typedef struct nsdf_fit_job {
    nsdf_model *model; /* quantisers are set here when fitting is quantisation-aware */
    const nsdf_encoder_options *options;
    const nsdf_sample_set *samples; /* [frame_count] */
    const double *u;                /* [frame_count]: time of each frame in [0, 1] */
    uint32_t frame_count;
    const nsdf_frames *frames; /* normalised: what the samples were made of */
    const nsdf_file_header *header;
    nsdf_workers *workers;
    nsdf_progress_fn progress;
    void *progress_user;
    double start_time;                  /* nsdf_clock() when the run began */
    struct nsdf_checkpoint *checkpoint; /* goes on where it was saved, and saves; NULL = neither */
    const nsdf_fit_control *control;    /* of blocks, which then are left unrounded; or NULL */
    double deadline;                    /* nsdf_clock() when the last step should be made, instead of the options'
                                           number of steps; 0 = none */
    const struct nsdf_tracked *tracked; /* the surface, followed for options->blocks; NULL = not yet */
    /* Of networks with a deadline, called once, after most of the steps: tries what follows the fit with the parameters
     * as they are, and returns the deadline that leaves time for it.  NULL = what was guessed stays. */
    double (*try_rest)(void *user);
    void *try_user;
} nsdf_fit_job;

typedef struct nsdf_fit_result {
    uint64_t steps, samples;
    double near_error; /* running mean |f - d| near the surface */
    uint64_t strays;   /* crossings far from the input that the last search found */
    int aborted;       /* progress answered NSDF_ABORT */
    int diverged;      /* a parameter is not finite */
} nsdf_fit_result;

/* Fits parameters[parameter_count] from the values they hold.  Returns 0, or -1 when memory ran out or
 * job->checkpoint has a refusal. */
int nsdf_fit_run(const nsdf_fit_job *job, float *parameters, nsdf_fit_result *result);

/* Fits a little more, with samples at places where verification found stray pieces (strays[frame_count]); the
 * quantisers stay.  Adds to *result.  Returns 0, or -1 when memory ran out. */
int nsdf_fit_mend(const nsdf_fit_job *job, const nsdf_sample_set *strays, float *parameters, nsdf_fit_result *result);

/* Seconds of a clock that only goes forward. */
double nsdf_clock(void);

#endif
