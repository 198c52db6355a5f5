/* The extraction bound: how large |f| may be at the centre of a cube that the surface passes. */
#ifndef NSDF_BOUND_H
#define NSDF_BOUND_H

#include "container_write.h"
#include "frames.h"

typedef struct nsdf_check_job { /* shared by bound.c and verify.c */
    const nsdf_frames *frames;
    const nsdf_file_header *header;
    const nsdf_encoder_options *options;
    nsdf_progress_fn progress;
    void *progress_user;
    double start_time;
} nsdf_check_job;

/* Evaluates the file's field on a dense grid at every frame and finds the smallest bound for which no cube of 2 to 32
 * cells with a change of sign is skipped; adds a margin; then compares sparse with dense extraction on every frame, and
 * raises the bound until they agree.  `file` must hold some bound already; the result goes to *bound. */
nsdf_status nsdf_measure_bound(const nsdf_check_job *job, const nsdf_buffer *file, float *bound,
                               nsdf_encoder_error *error);

/* Calls progress for a stage whose first `done` of `count` items are done since `began`; nonzero = abort. */
int nsdf_check_progress(const nsdf_check_job *job, nsdf_stage stage, double began, uint32_t done, uint32_t count);

#endif
