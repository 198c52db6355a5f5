/* On which side of a patch the inside is, by winding numbers. */
#ifndef NSDF_SIDES_H
#define NSDF_SIDES_H

#include "repair/patches.h"

/* Measures patches[].inside: the mean winding number on each patch, between its two sides.  1/2 on the outside of a
 * body, 0 on a sheet that stands alone, 1 on what is within a body, -1/2 on a body turned inside out.  Then turns the
 * patches that face the wrong way, and measures again, a few times at most.  Positions are normalised.  Returns 0, or
 * -1 when memory ran out. */
int nsdf_find_sides(nsdf_patches *patches, const nsdf_surface *surface);

#endif
