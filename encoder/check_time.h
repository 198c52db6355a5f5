/* How long it takes to find the bound of a network's file and to verify it, told by doing both for a few frames. */
#ifndef NSDF_CHECK_TIME_H
#define NSDF_CHECK_TIME_H

#include "check_job.h"
#include "container.h"
#include "workers.h"

typedef struct nsdf_check_time {
    double bound, verify; /* seconds a frame; next to nothing for what the options leave out */
} nsdf_check_time;

/* With the network that `segment` holds; `entry` as in nsdf_assemble_file.  The job's progress is not called. */
nsdf_status nsdf_time_check(const nsdf_check_job *job, nsdf_workers *workers, const nsdf_coded_segment *segment,
                            const nsdf_index_entry *entry, nsdf_check_time *seconds, nsdf_encoder_error *error);

#endif
