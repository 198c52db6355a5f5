/* Meshes with the faults that people's meshes have. */
#ifndef DIRTY_MESH_H
#define DIRTY_MESH_H

#include <stddef.h>
#include <stdint.h>

typedef struct dirty_mesh {
    double *positions;   /* [vertex_count][3] */
    uint32_t *triangles; /* [triangle_count][3] */
    size_t vertex_count, vertex_capacity, triangle_count, triangle_capacity;
} dirty_mesh;

void dirty_mesh_free(dirty_mesh *mesh);
/* Both return 0, or -1 when memory ran out. */
int dirty_mesh_add_vertex(dirty_mesh *mesh, double x, double y, double z);
int dirty_mesh_add_triangle(dirty_mesh *mesh, size_t a, size_t b, size_t c);

/* ---- Shapes, in motion: `time` is in [0, 1] --------------------------------------------------------------- */

/* Fills an empty mesh.  Returns 0, -1 when memory ran out, or 1 when no shape has that name. */
int dirty_shape(const char *name, double time, dirty_mesh *mesh);
/* A line for each shape. */
extern const char dirty_shapes_help[];

/* ---- Faults ------------------------------------------------------------------------------------------------ */

/* Applies a fault, "name" or "name=amount"; the same seed takes the same faces.  Returns 0, -1 when memory ran out, or
 * 1 when there is no such fault or its amount is out of range. */
int dirty_apply(const char *fault, uint64_t seed, dirty_mesh *mesh);
/* A line for each fault. */
extern const char dirty_faults_help[];

#endif
