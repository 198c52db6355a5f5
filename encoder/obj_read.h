/* Wavefront OBJ: vertices and faces of a whole file. */
#ifndef NSDF_OBJ_READ_H
#define NSDF_OBJ_READ_H

#include "nsdf/encoder.h"

/* Grows as needed and is reused from file to file; start with all zero. */
typedef struct nsdf_obj_mesh {
    double *positions; /* [vertex_count][3] */
    uint32_t *indices; /* [triangle_count][3], all below vertex_count */
    uint32_t vertex_count, triangle_count;
    size_t vertex_capacity, triangle_capacity;
} nsdf_obj_mesh;

void nsdf_obj_mesh_free(nsdf_obj_mesh *mesh);

/* Reads a file.  Records other than v and f are skipped, and so is what follows x y z in a v.  Quadrilaterals are cut
 * along the better diagonal, other polygons by ear clipping (those of more than 256 corners as fans).  On failure the
 * mesh has no triangles, and *error (may be NULL) names the file, the line and what was expected:
 * NSDF_IO cannot be read, NSDF_CORRUPT bad contents, NSDF_LIMIT too large, NSDF_NO_MEMORY. */
nsdf_status nsdf_obj_read(const char *path, nsdf_obj_mesh *mesh, nsdf_encoder_error *error);

/* The same from memory; text[size] must be a zero byte.  `name` is for messages. */
nsdf_status nsdf_obj_parse(const char *name, const char *text, size_t size, nsdf_obj_mesh *mesh,
                           nsdf_encoder_error *error);

#endif
