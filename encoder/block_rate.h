/* What the motion costs in the file, as a term of the loss. */
#ifndef NSDF_BLOCK_RATE_H
#define NSDF_BLOCK_RATE_H

#include "block_model.h"

/* Adds to `gradient` (of all values) that of weight * B, where B is the mean over all control points of about the bits
 * that the difference r from the control point before takes: log2(1 + (r / step)^2) / 2.  Where levels move, a bit of
 * theirs costs as much.  Directions in which the
 * surface hardly tells how a bone moves thus become smooth instead of following the noise. */
void nsdf_block_add_rate(const nsdf_block_model *model, const float *values, double weight, float *gradient);

#endif
