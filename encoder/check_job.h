/* What a coded file is held against: the input's frames, or a part of them. */
#ifndef NSDF_CHECK_JOB_H
#define NSDF_CHECK_JOB_H

#include "frames.h"

typedef struct nsdf_check_job {
    const nsdf_frames *frames;
    const nsdf_file_header *header;
    const nsdf_encoder_options *options;
    nsdf_progress_fn progress;
    void *progress_user;
    double start_time;
    const nsdf_frames *all; /* of which `frames` may be a part: the input's pieces are theirs */
} nsdf_check_job;

/* A job with some of another one's frames; stays where it is while it is used. */
typedef struct nsdf_check_part {
    nsdf_check_job job;
    nsdf_frames frames; /* borrows the meshes */
} nsdf_check_part;

/* At most `count` of the job's frames, evenly spread.  Returns 0, or -1 when memory ran out; the part is to be freed
 * in either case. */
int nsdf_check_part_pick(nsdf_check_part *part, const nsdf_check_job *job, uint32_t count);
void nsdf_check_part_free(nsdf_check_part *part);

/* Calls progress for a stage whose first `done` of `count` items are done since `began`; nonzero = abort. */
int nsdf_check_progress(const nsdf_check_job *job, nsdf_stage stage, double began, uint32_t done, uint32_t count);

#endif
