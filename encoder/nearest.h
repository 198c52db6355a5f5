/* Nearest point on a triangle mesh, with the normal that tells inside from outside there.
 *
 * A search in single precision, four boxes or triangles at a time, finds every triangle that may be the nearest,
 * allowing for its rounding errors.  The few that remain are resolved in double precision.
 *
 * The sign needs the angle-weighted pseudo-normal at the nearest point (Baerentzen & Aanaes 2005).  It is summed over
 * the triangles that attain the least distance at that point: 2 pi times the normal where the point is inside a
 * triangle, pi times where it is on an edge, the corner's angle where it is a corner.  That equals the tabulated
 * pseudo-normals of a welded mesh, and needs no connectivity: seams, T-junctions and triangles without area between
 * others do no harm. */
#ifndef NSDF_NEAREST_H
#define NSDF_NEAREST_H

#include <stdbool.h>

#include "bvh.h"
#include "vec3.h"

/* The triangles of a leaf, each in a frame of its own: corner A at the origin, B on the x axis, C in the xy plane. */
typedef struct nsdf_packet {
    float origin[3][NSDF_BVH_WIDTH];
    float axis[3][3][NSDF_BVH_WIDTH]; /* [axis][coordinate] */
    float bx[NSDF_BVH_WIDTH], cx[NSDF_BVH_WIDTH], cy[NSDF_BVH_WIDTH];
    float inverse_ac[NSDF_BVH_WIDTH], inverse_bc[NSDF_BVH_WIDTH]; /* 1 / squared length, 0 when that is 0 */
} nsdf_packet;

typedef struct nsdf_nearest_index {
    const nsdf_surface *surface; /* borrowed */
    nsdf_bvh bvh;
    nsdf_packet *packets; /* [leaf] */
    bool *has_say;        /* [triangle]: counts in normals; NULL when there are none */
    float slack;          /* bound on the rounding error of distances in the search, beside 2e-6 of the distance */
    double same_point;    /* nearest points closer than this are one */
} nsdf_nearest_index;

/* Without `normals` it takes less time, and the normals that it finds are 0.  Returns 0, or -1 when memory ran out; the
 * index can be freed in either case.  Needs at least one triangle. */
int nsdf_nearest_index_build(nsdf_nearest_index *index, const nsdf_surface *surface, bool normals);
void nsdf_nearest_index_free(nsdf_nearest_index *index);

typedef struct nsdf_nearest {
    nsdf_vec3 point, offset; /* the nearest point; from it to the query */
    nsdf_vec3 normal;        /* pseudo-normal, of any length; 0 when only triangles without area are near */
    double distance2;        /* infinite when nothing is within the limit */
} nsdf_nearest;

/* May miss what is farther than `limit`, and may find it. */
nsdf_nearest nsdf_find_nearest(const nsdf_nearest_index *index, const float point[3], float limit);

/* Whether something is nearer than `limit`; quicker than to find out what, the more so the nearer it is. */
bool nsdf_is_anything_nearer(const nsdf_nearest_index *index, const float point[3], float limit);

#endif
