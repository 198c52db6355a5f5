/* Bounding volume hierarchy over the triangles of a surface: nodes of four children, leaves of up to four triangles,
 * so that boxes and triangles can be tested four at a time. */
#ifndef NSDF_BVH_H
#define NSDF_BVH_H

#include "surface.h"

#define NSDF_BVH_WIDTH 4
#define NSDF_BVH_NONE UINT32_MAX           /* an unused child, or an unused place in a leaf */
#define NSDF_BVH_LEAF UINT32_C(0x80000000) /* set in a child that is a leaf; the rest is its number */
/* Before a loop over the four: gcc would unroll it first, and then fail to use vector instructions. */
#define NSDF_VECTOR_LOOP _Pragma("GCC unroll 1")
/* Entries that a depth-first walk can have waiting: three for each level. */
#define NSDF_BVH_STACK 224

typedef struct nsdf_bvh_node {
    float low[3][NSDF_BVH_WIDTH], high[3][NSDF_BVH_WIDTH]; /* unused: +infinity, -infinity */
    uint32_t child[NSDF_BVH_WIDTH];                        /* node number above the parent's, or leaf */
} nsdf_bvh_node;

typedef struct nsdf_bvh_leaf {
    uint32_t triangle[NSDF_BVH_WIDTH]; /* used places come first */
} nsdf_bvh_leaf;

typedef struct nsdf_bvh {
    nsdf_bvh_node *nodes; /* the root is number 0 */
    nsdf_bvh_leaf *leaves;
    uint32_t node_count, leaf_count;
} nsdf_bvh;

/* Returns 0, or -1 when memory ran out; needs at least one triangle, and fewer than 2^31. */
int nsdf_bvh_build(nsdf_bvh *bvh, const nsdf_surface *surface);
void nsdf_bvh_free(nsdf_bvh *bvh);

#endif
