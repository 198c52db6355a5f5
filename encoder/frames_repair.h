/* All frames repaired, and what follows from it for the encoding. */
#ifndef NSDF_FRAMES_REPAIR_H
#define NSDF_FRAMES_REPAIR_H

#include "frames.h"
#include "workers.h"

typedef struct nsdf_repair_job {
    nsdf_frames *frames;
    const nsdf_encoder_options *options;
    const nsdf_file_header *header; /* scale */
    nsdf_workers *workers;
    nsdf_progress_fn progress; /* may be NULL */
    void *progress_user;
    double start_time; /* nsdf_clock */
} nsdf_repair_job;

/* Repairs the normalised frames, finds what is on their outside and how small their pieces are, and sums their reports;
 * hidden faces and areas included.  NSDF_INVALID_ARGUMENT when a frame has no area, NSDF_NO_MEMORY, NSDF_CANCELLED. */
nsdf_status nsdf_frames_repair(const nsdf_repair_job *job, nsdf_mesh_report *sum, nsdf_encoder_error *error);

/* How much shells reach beyond the box of the input, normalised. */
double nsdf_shell_margin(const nsdf_encoder_options *options, const nsdf_frames *frames);

/* Sets the resolution where it is left open, such that it shows the sheets, and the weight of signs; takes the network
 * where there is much of them: outside of balls, signs come from the blocks as elements of surface (spec, 11.2), and
 * the two sides of a sheet do not cancel well enough. */
void nsdf_suit_sheets(nsdf_encoder_options *options, const nsdf_mesh_report *input, const nsdf_file_header *header);

#endif
