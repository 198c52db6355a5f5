#include "check_job.h"

#include "fit.h"

#include <stdlib.h>
#include <string.h>

int nsdf_check_part_pick(nsdf_check_part *part, const nsdf_check_job *job, uint32_t count) {
    nsdf_frame *picked = malloc(count * sizeof *picked);
    memset(part, 0, sizeof *part);
    if (!picked)
        return -1;
    part->job = *job;
    part->frames = nsdf_frames_pick(job->frames, count, picked);
    part->job.frames = &part->frames;
    return 0;
}

void nsdf_check_part_free(nsdf_check_part *part) {
    free(part->frames.frames);
    memset(part, 0, sizeof *part);
}

int nsdf_check_progress(const nsdf_check_job *job, nsdf_stage stage, double began, uint32_t done, uint32_t count) {
    double spent = nsdf_clock() - began, fraction = (double)done / (double)count;
    nsdf_progress p = {stage, fraction, nsdf_clock() - job->start_time,
                       0.0,   0.0,      done ? spent * (1.0 - fraction) / fraction : -1.0};
    return job->progress && job->progress(job->progress_user, &p) == NSDF_ABORT;
}
