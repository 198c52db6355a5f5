/* Triangle meshes of implicit surfaces, for test data: closed, outward-oriented 2-manifolds whose connectivity differs
 * from seed to seed.  Shares nothing with the codec, so that it can serve as a reference for it. */
#ifndef NSDF_IMPLICIT_MESH_H
#define NSDF_IMPLICIT_MESH_H

#include <stddef.h>
#include <stdint.h>

/* A function of position: negative inside, positive outside, everywhere positive on and beyond the box. */
typedef struct nsdf_implicit_field {
    const void *user;
    double (*value)(const void *user, const double p[3]);
    double lipschitz; /* |value(p) - value(q)| <= lipschitz * |p - q| */
    double box_min[3], box_max[3];
} nsdf_implicit_field;

typedef struct nsdf_implicit_mesh {
    double *positions;   /* [vertex_count][3] */
    uint32_t *triangles; /* [triangle_count][3], counter-clockwise from outside */
    size_t vertex_count, triangle_count;
    size_t vertex_capacity, triangle_capacity;
} nsdf_implicit_mesh;

/* Fills *mesh (zero-initialised, or from an earlier call: its memory is used again).  `spacing` is the length of the
 * longer edges of the lattice; `seed` turns and shifts the lattice.  The same arguments give the same mesh.  Returns 0,
 * or -1 when memory ran out or the lattice would have more than 2^20 nodes along an axis; the mesh is empty then. */
int nsdf_implicit_extract(const nsdf_implicit_field *field, double spacing, uint64_t seed, nsdf_implicit_mesh *mesh);

void nsdf_implicit_mesh_free(nsdf_implicit_mesh *mesh);

#endif
