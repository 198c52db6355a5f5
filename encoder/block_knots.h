/* How many control points the motion of blocks takes. */
#ifndef NSDF_BLOCK_KNOTS_H
#define NSDF_BLOCK_KNOTS_H

#include "bones.h"

/* Frames per control point: `spacing`, or less, down to one, where the bones' splines would lose the motion otherwise.
 * u[motion->frame_count] are the frames' times.  Negative when memory ran out. */
double nsdf_block_knot_spacing(const nsdf_motion *motion, const nsdf_bones *bones, const double *u, double spacing);

#endif
