/* What the numbers of blocks cost in the file, as a term of the loss. */
#ifndef NSDF_BLOCK_RATE_H
#define NSDF_BLOCK_RATE_H

#include "block_model.h"

/* Adds to `gradient` (of all values) that of weight * B, where B is the mean over poses, levels, weights and other
 * coefficients of about the bits that a number r takes: log2(1 + (r / step)^2) / 2.  For poses, and levels that move, r
 * is the difference from the control point before; for weights, while they are fitted, and coefficients of degree 1,
 * that from the block before, from which they are predicted; for coefficients of higher degrees the number itself.
 * Centres and radii have no rate: what they take hardly depends on where they are.
 *
 * Directions in which the surface hardly tells how a bone moves thus become smooth instead of following the noise, and
 * a polynomial bends only where that brings the surface nearer. */
void nsdf_block_add_rate(const nsdf_block_model *model, const float *values, double weight, float *gradient);

#endif
