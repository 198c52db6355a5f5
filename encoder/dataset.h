/* Training data: signed-distance samples of all frames, and the normalisations that follow from them. */
#ifndef NSDF_DATASET_H
#define NSDF_DATASET_H

#include "frames.h"
#include "model.h"
#include "sampler.h"
#include "workers.h"

typedef struct nsdf_dataset {
    nsdf_sample_set *sets; /* [frame_count] */
    double *u;             /* [frame_count]: time in [0, 1] over the sequence */
    uint32_t frame_count;
    double bytes; /* memory that the samples take */
} nsdf_dataset;

/* Of the sampling stage, what repairing the frames before it takes. */
#define NSDF_REPAIR_SHARE 0.3

typedef struct nsdf_dataset_job {
    nsdf_frames *frames; /* normalised and repaired */
    const nsdf_encoder_options *options;
    const nsdf_file_header *header;
    nsdf_workers *workers;
    nsdf_progress_fn progress;
    void *progress_user;
    double start_time;
} nsdf_dataset_job;

/* Samples every frame, in parallel.  NSDF_CANCELLED when progress answers NSDF_ABORT; NSDF_INVALID_ARGUMENT when a
 * frame has no inside (an open sheet). */
nsdf_status nsdf_dataset_create(nsdf_dataset *dataset, const nsdf_dataset_job *job, nsdf_encoder_error *error);
void nsdf_dataset_free(nsdf_dataset *dataset);

/* Sets value_scale and value_offset (5.10) and time_scale (5.11 to 5.13) of the network. */
void nsdf_dataset_normalise(const nsdf_dataset *dataset, const nsdf_encoder_options *options, nsdf_network_desc *desc);

/* Whether any sample is inside, and what to say of a frame where none is. */
int nsdf_has_inside(const nsdf_sample_set *set);
nsdf_status nsdf_no_inside(const nsdf_frame *frame, nsdf_encoder_error *error);

#endif
