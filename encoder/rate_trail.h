/* What rate control of blocks and of networks share: the trail of rounds, and errors of some of the frames. */
#ifndef NSDF_RATE_TRAIL_H
#define NSDF_RATE_TRAIL_H

#include "container.h"
#include "container_write.h"
#include "fit.h"

typedef struct nsdf_rate_job {
    nsdf_fit_job fit;              /* its options are those given */
    uint64_t size;                 /* that the file may have; 0 = the options' target_error counts */
    const nsdf_frames *shown;      /* the frames that the file's time reaches, of those that are fitted */
    const nsdf_index_entry *entry; /* of the file's segment, as nsdf_assemble_file takes it */
    nsdf_encoder_stats *stats;     /* rounds are added */
} nsdf_rate_job;

/* Adds a round; when there is no room, it takes the place of the last. */
void nsdf_rate_note(const nsdf_rate_job *job, const nsdf_rate_round *round);

/* The file of a segment as it would be verified, with room for its measured quality where the options ask for it.
 * Returns 0, or -1 when memory ran out. */
int nsdf_rate_make_file(const nsdf_rate_job *job, const nsdf_coded_segment *segment, nsdf_buffer *file);

/* nsdf_mean_error of a file, from some frames that are spread over the sequence. */
nsdf_status nsdf_rate_quick_error(const nsdf_rate_job *job, const nsdf_buffer *file, double *mean,
                                  nsdf_encoder_error *error);

#endif
