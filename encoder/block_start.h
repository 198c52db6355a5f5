/* First coefficients of the blocks, straight from the signed distance. */
#ifndef NSDF_BLOCK_START_H
#define NSDF_BLOCK_START_H

#include "block_model.h"

/* Fits each block's polynomial by least squares to the signed distance in its ball, averaged over frames spread over
 * the sequence, with most weight near the surface.   Returns 0, or -1 when memory ran out. */
int nsdf_block_start(nsdf_block_model *model, float (*normals)[3], const nsdf_frames *frames, const double *u,
                     nsdf_block_frame *scratch, nsdf_workers *workers);

#endif
