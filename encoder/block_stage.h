/* From frames to a fitted block part, and to its bytes. */
#ifndef NSDF_BLOCK_STAGE_H
#define NSDF_BLOCK_STAGE_H

#include "block_fit.h"
#include "container.h"

/* Tracks, finds bones, starts and fits.  Returns as nsdf_fit_run. */
int nsdf_fit_blocks(const nsdf_fit_job *job, nsdf_block_model *model, nsdf_fit_result *result);

/* As nsdf_code_segment. */
int nsdf_code_blocks(const nsdf_block_model *model, nsdf_coded_segment *segment);

/* Where the coded bytes go.  Returns 0, or -1 when memory ran out. */
int nsdf_weigh_blocks(const nsdf_block_model *model, nsdf_block_bytes *bytes);

#endif
