/* Simplification of triangle meshes for the rate-distortion bench: a mesh codec reaches low rates only after it.
 *
 * Edges are collapsed by ascending quadric error (Garland & Heckbert 1997: Surface simplification using quadric error
 * metrics), planes weighed by area.  meshoptimizer 0.18, which Debian 12 has, leaves vertices where they were, and
 * needs more bytes for the same error; what moves them came with later versions. */
#ifndef RD_DECIMATE_H
#define RD_DECIMATE_H

#include "surface.h"

typedef enum rd_placement {
    RD_PLACE_OPTIMAL = 0, /* where the quadric error is least */
    RD_PLACE_ENDPOINT = 1 /* at the better end of the edge: good where vertices lie on sharp edges or on a grid */
} rd_placement;

/* Reduces the triangles to `target`, or to as few as go without changing the topology or turning a triangle over.
 * Equal positions become one vertex first, and triangles that then have a corner twice go.  Open edges are kept where
 * they are by planes that stand on them.  Vertices that no triangle uses any longer stay in surface->positions.
 * Returns 0, or -1 when memory ran out. */
int rd_decimate(nsdf_surface *surface, size_t target, rd_placement placement);

#endif
