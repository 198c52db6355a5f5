/* Fitting a network to a file size or to an error. */
#ifndef NSDF_RATE_NETWORK_H
#define NSDF_RATE_NETWORK_H

#include "dataset.h"
#include "rate_trail.h"

typedef struct nsdf_rate_network nsdf_rate_network;

/* job->fit.model and *parameters, which is allocated anew with other widths, are the network.  Everything is borrowed
 * until the free.  NULL when memory ran out. */
nsdf_rate_network *nsdf_rate_network_create(const nsdf_rate_job *job, const nsdf_dataset *dataset, float **parameters);
void nsdf_rate_network_free(nsdf_rate_network *rate);

/* Fits, and chooses the quantisers.  What of *result tells an end that is none is left to the caller. */
nsdf_status nsdf_rate_network_fit(nsdf_rate_network *rate, nsdf_fit_result *result, nsdf_encoder_error *error);

/* Chooses the quantisers again, once the parameters have changed. */
nsdf_status nsdf_rate_network_requantise(nsdf_rate_network *rate, nsdf_encoder_error *error);

/* As nsdf_rate_blocks_judge. */
nsdf_status nsdf_rate_network_judge(nsdf_rate_network *rate, nsdf_fit_result *result, const nsdf_quality *quality,
                                    int *again, nsdf_encoder_error *error);

#endif
