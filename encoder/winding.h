/* Generalised winding number of a triangle mesh (Jacobson et al. 2013), fast by dipoles on the hierarchy (Barill et
 * al. 2018, first order). */
#ifndef NSDF_WINDING_H
#define NSDF_WINDING_H

#include "bvh.h"

/* What stands for each child of a node when it is looked at from afar. */
typedef struct nsdf_dipoles {
    float centre[3][NSDF_BVH_WIDTH]; /* of area */
    float moment[3][NSDF_BVH_WIDTH]; /* sum of area times normal, over 4 pi */
    float reach2[NSDF_BVH_WIDTH];    /* square of the distance from which the dipole is good enough */
} nsdf_dipoles;

/* The corners of a leaf's triangles; unused places hold three equal ones, which nothing sees. */
typedef struct nsdf_leaf_corners {
    float corner[3][3][NSDF_BVH_WIDTH]; /* [corner][coordinate] */
} nsdf_leaf_corners;

typedef struct nsdf_winding {
    nsdf_dipoles *dipoles;     /* [node] */
    nsdf_leaf_corners *leaves; /* [leaf] */
} nsdf_winding;

/* Returns 0, or -1 when memory ran out; can be freed in either case. */
int nsdf_winding_build(nsdf_winding *winding, const nsdf_bvh *bvh, const nsdf_surface *surface);
void nsdf_winding_free(nsdf_winding *winding);

double nsdf_winding_number(const nsdf_winding *winding, const nsdf_bvh *bvh, const float point[3]);

#endif
