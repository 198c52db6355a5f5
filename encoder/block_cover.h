/* How much of the surface blocks hold, before any of them is fitted. */
#ifndef NSDF_BLOCK_COVER_H
#define NSDF_BLOCK_COVER_H

#include "frames.h"
#include "motion.h"

/* The least share of a frame's outer surface, by area, that lies in the balls of blocks that live there; random points
 * of every frame are looked at.  The motion is that of `frames`, normalised.  Returns 0, or -1 when memory ran out. */
int nsdf_block_cover_find(double *least, const nsdf_motion *motion, const nsdf_frames *frames, uint64_t seed,
                          nsdf_workers *workers);

#endif
