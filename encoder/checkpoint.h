/* Checkpoints: bytes from which another run with the same options and input goes on fitting, and when they are made.
 *
 *     signature, layout          10 bytes
 *     size of all, steps done    u64 each
 *     version                    of the program: length (u8) and text
 *     identity                   run_identity.h
 *     kernels                    that fit: length (u8) and text
 *     trace                      u64: hash of what fitting begins with, see nsdf_checkpoint_begin
 *     state                      fit_state.h
 *     hash of all before         u64
 */
#ifndef NSDF_CHECKPOINT_H
#define NSDF_CHECKPOINT_H

#include "fit.h"
#include "fit_state.h"

typedef struct nsdf_checkpoint {
    nsdf_checkpoint_fn save; /* NULL = none are asked for */
    void *user;
    double seconds;       /* between two */
    nsdf_buffer identity; /* of this run, from version to kernels, when `save` is there */
    uint64_t trace;
    double saved_at; /* nsdf_clock() */
    uint64_t saved_steps;
    nsdf_buffer resumed; /* a whole checkpoint to go on with; empty = fitting begins anew */
    size_t trace_at;     /* where its trace is */
    const char *refusal; /* why `resumed` does not fit, once that is known */
} nsdf_checkpoint;

void nsdf_checkpoint_free(nsdf_checkpoint *checkpoint);

/* Takes a checkpoint to go on with.  Everything but trace and state is checked here: see nsdf_encoder_resume for the
 * statuses.  On failure *checkpoint is as before. */
nsdf_status nsdf_checkpoint_open(nsdf_checkpoint *checkpoint, const void *data, size_t size,
                                 const nsdf_encoder_options *options, const nsdf_frames *frames, uint64_t *steps,
                                 nsdf_encoder_error *error);

/* Prepares saving, before the frames are normalised.  Returns 0, or -1 when memory ran out. */
int nsdf_checkpoint_prepare(nsdf_checkpoint *checkpoint, const nsdf_encoder_options *options,
                            const nsdf_frames *frames);

/* To be called when fitting is about to make its first step.  Samples and first values are not stored but made anew;
 * their hash is, so that nothing goes on from others.  Fills the state from the checkpoint to go on with, if there is
 * one, and forgets it.  Returns 0, or -1 with checkpoint->refusal, or without when
 * memory ran out.  Here and below checkpoint may be NULL. */
int nsdf_checkpoint_begin(nsdf_checkpoint *checkpoint, const nsdf_fit_job *job, const float *values, size_t count,
                          nsdf_fit_state_fn fields, void *fitting);

/* Whether the time has come; after the last step it always has. */
int nsdf_checkpoint_due(const nsdf_checkpoint *checkpoint, int last_step);

/* Saves, if checkpoints are asked for and these steps were not saved yet.  Returns 0, or -1 when memory ran out. */
int nsdf_checkpoint_save(nsdf_checkpoint *checkpoint, uint64_t steps, nsdf_fit_state_fn fields, void *fitting);

#endif
