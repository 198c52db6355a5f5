/* Meshes for nsdf-render: a small OBJ reader and vertex normals. */
#ifndef NSDF_RENDER_MESH_H
#define NSDF_RENDER_MESH_H

#include <stddef.h>
#include <stdint.h>

typedef struct nsdf_render_mesh {
    double *positions, *normals; /* [vertex_count][3] */
    uint32_t *triangles;         /* [triangle_count][3] */
    size_t vertex_count, triangle_count;
    size_t vertex_capacity, triangle_capacity;
} nsdf_render_mesh;

/* Reads "v" and "f" lines; polygons are cut into fans; normals are averages of the faces around, by area.  Returns
 * NULL, or a text that says what is wrong; *mesh holds nothing then. */
const char *nsdf_render_mesh_read(const char *path, nsdf_render_mesh *mesh);

void nsdf_render_mesh_free(nsdf_render_mesh *mesh);

#endif
