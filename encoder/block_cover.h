/* How much of the surface blocks hold, before any of them is fitted. */
#ifndef NSDF_BLOCK_COVER_H
#define NSDF_BLOCK_COVER_H

#include "frames.h"
#include "motion.h"

/* Shares of a frame's surface, by area, that lie in the ball of a block that lives there. */
typedef struct nsdf_block_cover {
    double least; /* of all frames */
    double mean;
} nsdf_block_cover;

/* Looks at random points of every frame's outer surface; the motion is that of `frames`, normalised.  Returns 0, or -1
 * when memory ran out. */
int nsdf_block_cover_find(nsdf_block_cover *cover, const nsdf_motion *motion, const nsdf_frames *frames, uint64_t seed,
                          nsdf_workers *workers);

#endif
