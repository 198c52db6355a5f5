/* A model of blocks under rate control: made at a level, fitted, measured. */
#ifndef NSDF_RATE_MODEL_H
#define NSDF_RATE_MODEL_H

#include "block_stage.h"
#include "rate_trail.h"

/* Share of the options' steps that a whole fit has. */
#define NSDF_RATE_FIT_SHARE 0.85
/* Quantiser steps are exp(x) times those of the level; searches stay within this |x|. */
#define NSDF_RATE_MOST_X 1.6

/* What belongs to one fit of the blocks, besides their values. */
typedef struct nsdf_rate_state {
    nsdf_encoder_options level_o; /* at the level */
    nsdf_encoder_options options; /* and with x: those that fitting sees */
    double level, x;              /* see rate_control.h */
    uint64_t bytes;               /* of the file */
    double quick;                 /* its error, of some frames */
    double back_by_decoded;       /* see nsdf_quick_error */
    uint64_t steps;               /* of all fits when the last one ended: no two models have the same */
} nsdf_rate_state;

typedef struct nsdf_rate_model {
    nsdf_rate_job job;
    nsdf_encoder_options base; /* as given, with the steps of blocks */
    nsdf_rate_state now;
    nsdf_fit_control control;
    nsdf_block_model *blocks; /* the caller's */
    nsdf_fit_result *result;  /* the caller's: of all fits together */
    nsdf_encoder_error *error;
    nsdf_tracked tracked;
    uint32_t tracked_blocks; /* 0 = nothing tracked */
    nsdf_sample_set *strays; /* [job.fit.frame_count]: samples of every fit besides the job's, see block_mend.h */
    uint32_t tunes;
    int stopped; /* a fit made fewer steps than it should */
} nsdf_rate_model;

/* Everything in the job is borrowed until the free.  Returns 0, or -1 when memory ran out. */
int nsdf_rate_model_init(nsdf_rate_model *m, const nsdf_rate_job *job);
void nsdf_rate_model_free(nsdf_rate_model *m);

/* Always NSDF_NO_MEMORY, which the caller's error tells. */
nsdf_status nsdf_rate_no_memory(const nsdf_rate_model *m);

/* Follows the surface for so many blocks, unless that was done. */
nsdf_status nsdf_rate_track(nsdf_rate_model *m, uint32_t blocks);

/* The nearest of the levels that the target may have. */
double nsdf_rate_within_levels(const nsdf_rate_model *m, double level);

/* First values at a level. */
nsdf_status nsdf_rate_start_at(nsdf_rate_model *m, double level);

/* The quantiser steps, and the motion's rate, of another x. */
void nsdf_rate_set_x(nsdf_rate_model *m, double x);

/* Only m->now.bytes.  0, or -1 when memory ran out. */
int nsdf_rate_count_bytes(nsdf_rate_model *m);

/* Fits by a share of the options' steps; a probe, which is not steered (nsdf_fit_control; m->control.steer is called
 * with m->control.user), and a tuning, which has other samples each time, by a little more where that would be few.
 * Then measures: bytes, and with a target error the error.  NSDF_CANCELLED where *m->result says why. */
nsdf_status nsdf_rate_fit_and_measure(nsdf_rate_model *m, nsdf_rate_kind kind, double share);

/* strays[job.fit.frame_count], taken over where there are any, join the samples of fits that follow. */
void nsdf_rate_take_strays(nsdf_rate_model *m, nsdf_sample_set *strays);

/* Adds a round to the trail. */
void nsdf_rate_note_model(const nsdf_rate_model *m, nsdf_rate_kind kind, uint64_t steps, double error);

/* A model with what belongs to it; without values when there is none. */
typedef struct nsdf_rate_copy {
    nsdf_block_model blocks;
    nsdf_rate_state state;
} nsdf_rate_copy;

/* In place of the one that was there.  0, or -1 when memory ran out. */
int nsdf_rate_copy_model(nsdf_rate_copy *copy, const nsdf_rate_model *m);
/* The copy takes the model's place, and has no values then. */
void nsdf_rate_take_copy(nsdf_rate_model *m, nsdf_rate_copy *copy);
void nsdf_rate_copy_free(nsdf_rate_copy *copy);

#endif
