/* Signed distance to a triangle mesh (thesis 5.1): bounding volume hierarchy, nearest point on face, edge or vertex,
 * sign by angle-weighted pseudo-normals (Baerentzen & Aanaes 2005), or by generalised winding number (Jacobson et al.
 * 2013; hierarchical dipole expansion after Barill et al. 2018) where the mesh is not closed. */
#ifndef NSDF_SDF_H
#define NSDF_SDF_H

#include <stdbool.h>

#include "surface.h"

typedef struct nsdf_sdf nsdf_sdf;

typedef enum nsdf_sign_rule {
    NSDF_SIGN_PSEUDO_NORMAL = 0, /* exact for closed, consistently oriented meshes */
    NSDF_SIGN_WINDING = 1        /* inside where the winding number is above 1/2 */
} nsdf_sign_rule;

/* Builds the hierarchy; the surface is borrowed and must stay unchanged.  NULL when memory ran out or the surface has
 * no triangle.  Triangles without area count as the segments or points they are. */
nsdf_sdf *nsdf_sdf_create(const nsdf_surface *surface, nsdf_sign_rule rule);
/* Distance to `outer`, a part of `whole` on the same positions, with signs by the winding number of `whole`: for meshes
 * whose parts pass through each other, of which only the outside of their union counts.  Both are borrowed. */
nsdf_sdf *nsdf_sdf_create_union(const nsdf_surface *outer, const nsdf_surface *whole);
/* For nsdf_sdf_unsigned and nsdf_sdf_is_within only. */
nsdf_sdf *nsdf_sdf_create_unsigned(const nsdf_surface *surface);
/* For nsdf_sdf_winding only. */
nsdf_sdf *nsdf_sdf_create_winding(const nsdf_surface *surface);
void nsdf_sdf_free(nsdf_sdf *sdf);

/* Negative inside.  Read-only: may be called from many threads. */
float nsdf_sdf_distance(const nsdf_sdf *sdf, const float point[3]);

/* The same, faster for a caller who knows that the unsigned distance to the triangles is at most `upper`: the search
 * starts there.  A wrong or tight guess costs time only. */
float nsdf_sdf_distance_below(const nsdf_sdf *sdf, const float point[3], float upper);

/* Unsigned distance to the triangles; *nearest (may be NULL) gets the nearest point.  Looks no further than
 * `limit` (pass INFINITY for none) and returns `limit` when nothing is nearer. */
float nsdf_sdf_unsigned(const nsdf_sdf *sdf, const float point[3], float limit, float nearest[3]);

/* nsdf_sdf_unsigned(sdf, point, limit, NULL) < limit, in less time. */
bool nsdf_sdf_is_within(const nsdf_sdf *sdf, const float point[3], float limit);

/* Generalised winding number at a point: 1 inside, 0 outside of a closed outward mesh; of a distance function whose
 * signs come from it. */
float nsdf_sdf_winding(const nsdf_sdf *sdf, const float point[3]);

#endif
