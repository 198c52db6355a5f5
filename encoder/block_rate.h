/* What the numbers of blocks cost in the file, as a term of the loss. */
#ifndef NSDF_BLOCK_RATE_H
#define NSDF_BLOCK_RATE_H

#include "block_model.h"

/* Adds to `gradient` (of all values) that of weight * B, where B is the mean over all control points of the poses of
 * about the bits that the difference r from the control point before takes: log2(1 + (r / step)^2) / 2.  Directions in
 * which the surface hardly tells how a bone moves thus become smooth instead of following the noise.
 *
 * A bit of the others costs as much: of levels that move, as differences too; of weights, while they are fitted, and of
 * coefficients of degree 1, as differences from the block before, from which they are predicted; of coefficients above,
 * as they are.  A polynomial thus bends only where that brings the surface nearer.  Where nothing moves, they cost what
 * they do where two frames do.  Centres and radii have no rate: what they take hardly depends on where they are. */
void nsdf_block_add_rate(const nsdf_block_model *model, const float *values, double weight, float *gradient);

#endif
