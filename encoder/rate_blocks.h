/* Fitting blocks to a file size or to an error. */
#ifndef NSDF_RATE_BLOCKS_H
#define NSDF_RATE_BLOCKS_H

#include "block_stage.h"
#include "rate_trail.h"

typedef struct nsdf_rate_blocks nsdf_rate_blocks;

/* NULL when memory ran out.  Everything in the job is borrowed until the free. */
nsdf_rate_blocks *nsdf_rate_blocks_create(const nsdf_rate_job *job);
void nsdf_rate_blocks_free(nsdf_rate_blocks *rate);

/* Fits *model, which is ready for coding, so that its file has the size, or about the error, that is asked for.
 * NSDF_LIMIT when the size cannot be met.  What of *result tells an end that is none is left to the caller. */
nsdf_status nsdf_rate_blocks_fit(nsdf_rate_blocks *rate, nsdf_block_model *model, nsdf_fit_result *result,
                                 nsdf_encoder_error *error);

/* After verification found `quality` for the whole file, and strays[frame], which are taken over: whether *model was
 * changed and must be coded and checked again. *again is 0 at the end, when *model is the one with the fewest bytes
 * that met the error, if any did, or with the least error of the size. */
nsdf_status nsdf_rate_blocks_judge(nsdf_rate_blocks *rate, nsdf_block_model *model, nsdf_fit_result *result,
                                   const nsdf_quality *quality, nsdf_sample_set *strays, int *again,
                                   nsdf_encoder_error *error);

#endif
