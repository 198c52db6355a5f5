/* Meshes while they are read from a file: growing arrays, and polygons cut into triangles. */
#ifndef NSDF_FILE_MESH_H
#define NSDF_FILE_MESH_H

#include "nsdf/encoder.h"

#define NSDF_FILE_MESH_MAX INT32_MAX /* of vertices, and of triangles */

/* A polygon of more than three corners, until all positions are known. */
typedef struct nsdf_polygon_note {
    uint32_t triangle, corners; /* its first triangle */
} nsdf_polygon_note;

/* A vertex that is not finite, until it is known whether a face uses it. */
typedef struct nsdf_bad_vertex {
    uint32_t vertex;
    uint64_t line;
    const char *at; /* in the text of the file */
} nsdf_bad_vertex;

/* Grows as needed and is reused from file to file; start with all zero. */
typedef struct nsdf_file_mesh {
    double *positions; /* [vertex_count][3] */
    uint32_t *indices; /* [triangle_count][3] */
    uint32_t vertex_count, triangle_count;
    nsdf_polygon_note *polygons;
    nsdf_bad_vertex *bad;
    size_t vertex_capacity, triangle_capacity, polygon_count, polygon_capacity, bad_count, bad_capacity;
} nsdf_file_mesh;

/* Empties the mesh; its memory is used again. */
void nsdf_file_mesh_clear(nsdf_file_mesh *mesh);
void nsdf_file_mesh_free(nsdf_file_mesh *mesh);

/* The functions below return NSDF_OK, NSDF_NO_MEMORY or NSDF_LIMIT; `name` is the file's, for the message. */

nsdf_status nsdf_file_mesh_add_vertex(nsdf_file_mesh *mesh, const double xyz[3], const char *name,
                                      nsdf_encoder_error *error);

/* A polygon that comes corner by corner; start with all zero. */
typedef struct nsdf_corners {
    uint32_t count, first, previous;
} nsdf_corners;

/* Vertices are numbered from 0 and may follow later. */
nsdf_status nsdf_file_mesh_add_corner(nsdf_file_mesh *mesh, nsdf_corners *corners, uint32_t vertex, const char *name,
                                      nsdf_encoder_error *error);
/* After the last corner, of which there must be three. */
nsdf_status nsdf_file_mesh_end_polygon(nsdf_file_mesh *mesh, const nsdf_corners *corners, nsdf_encoder_error *error);

/* The next vertex to be added is not finite. */
nsdf_status nsdf_file_mesh_note_bad(nsdf_file_mesh *mesh, uint64_t line, const char *at, nsdf_encoder_error *error);
/* The first one that a triangle uses, or NULL. */
const nsdf_bad_vertex *nsdf_file_mesh_find_bad(const nsdf_file_mesh *mesh);

/* Cuts the polygons, when all vertices are there and every corner names one.  NSDF_CORRUPT when the mesh has no
 * vertices or no triangles. */
nsdf_status nsdf_file_mesh_finish(nsdf_file_mesh *mesh, const char *name, nsdf_encoder_error *error);

/* The array with room for `wanted` elements of `size` bytes, or NULL: then it is as it was. */
void *nsdf_grow(void *array, size_t *capacity, size_t wanted, size_t size);

#endif
