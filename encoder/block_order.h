/* The order of blocks in the file. */
#ifndef NSDF_BLOCK_ORDER_H
#define NSDF_BLOCK_ORDER_H

#include "bones.h"

/* Puts the blocks in an order in which each resembles the one before, so that predicting rows from the rows before
 * takes few bits: a chain in which the next is the one that costs least.  Bones that move two successive blocks take
 * the same places among their influences, and places that a block has no use for keep the bone with weight 0.
 * Returns 0, or -1 when memory ran out. */
int nsdf_order_blocks(nsdf_motion *motion, nsdf_bones *bones);

#endif
