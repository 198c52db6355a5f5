/* Lives of blocks, once these are fitted. */
#ifndef NSDF_BLOCK_LIVES_H
#define NSDF_BLOCK_LIVES_H

#include "block_model.h"
#include "frames.h"
#include "workers.h"

/* Ends lives where the surface has gone out of a block's ball for good, and begins them where it first comes into it:
 * around such a ball there is no surface to describe, but the block might make some, as where parts come together or
 * apart.  u[frames->count] are the frames' times.  Returns 0, or -1 when memory ran out. */
int nsdf_block_trim_lives(nsdf_block_model *model, const nsdf_frames *frames, const double *u,
                          const nsdf_file_header *header, nsdf_workers *workers);

#endif
