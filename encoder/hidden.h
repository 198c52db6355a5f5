/* Surface inside of bodies: of meshes whose parts pass through each other, nobody outside meets some of it, and no zero
 * set of a signed distance holds it. */
#ifndef NSDF_HIDDEN_H
#define NSDF_HIDDEN_H

#include "surface.h"

/* The connected pieces that are boundaries of bodies: as many triangles run along each edge one way as the other, so
 * that winding numbers are whole (equal positions are one vertex).  Sheets and bodies with holes are none.  All are
 * turned round where they enclose a negative volume together.  *bodies gets indices of its own, and the positions of
 * the surface.  Returns 0, or -1 when memory ran out. */
int nsdf_find_bodies(const nsdf_surface *surface, nsdf_surface *bodies);

/* The triangles of a surface that are not within bodies: those with a winding number of the bodies of 1/2 at most a
 * little in front of their middle, or a little behind it.  A triangle counts as a whole.
 *
 * *outer gets indices of its own, and the positions of the surface; none (NULL) when nothing is hidden, or everything.
 * `first_look`: one in so many triangles is looked at first, and nothing is taken for hidden when none of these is; 1 =
 * all are looked at.  Returns 0, or -1 when memory ran out. */
int nsdf_find_outer(const nsdf_surface *surface, const nsdf_surface *bodies, uint32_t first_look, nsdf_surface *outer);

#endif
