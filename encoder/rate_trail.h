/* What rate control of blocks and of networks share: the trail of rounds, and errors of some of the frames. */
#ifndef NSDF_RATE_TRAIL_H
#define NSDF_RATE_TRAIL_H

#include "container.h"
#include "container_write.h"
#include "fit.h"

typedef struct nsdf_rate_job {
    nsdf_fit_job fit;          /* its options are those given */
    uint64_t size;             /* that the file may have; 0 = the options' target_error counts */
    const nsdf_frames *shown;  /* the frames that the file's time reaches, of those that are fitted */
    nsdf_index_entry entry;    /* of the file's segment, as nsdf_assemble_file takes it, before specks are found */
    nsdf_encoder_stats *stats; /* rounds are added */
} nsdf_rate_job;

/* Adds a round; when there is no room, it takes the place of the last. */
void nsdf_rate_note(const nsdf_rate_job *job, const nsdf_rate_round *round);

/* The file of a segment as it would be verified, with room for its measured quality where the options ask for it.
 * Returns 0, or -1 when memory ran out. */
int nsdf_rate_make_file(const nsdf_rate_job *job, const nsdf_coded_segment *segment, nsdf_buffer *file);

typedef struct nsdf_quick_error {
    double mean;            /* nsdf_mean_error */
    double back_by_decoded; /* mean distance back to the input as a multiple of that to the decoded surface */
    uint64_t bytes;         /* of the file */
} nsdf_quick_error;

/* Of a segment's file, from some frames that are spread over the sequence, without the specks that verification would
 * leave out. */
nsdf_status nsdf_rate_quick_error(const nsdf_rate_job *job, const nsdf_coded_segment *segment, nsdf_quick_error *quick,
                                  nsdf_encoder_error *error);

#endif
