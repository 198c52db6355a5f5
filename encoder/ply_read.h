/* Stanford PLY, ascii or binary: vertices and faces of a whole file. */
#ifndef NSDF_PLY_READ_H
#define NSDF_PLY_READ_H

#include "file_mesh.h"

/* Reads a file that is in memory; text[size] must be a zero byte, `name` is for messages.  Taken are the properties x,
 * y, z of the element vertex, of any types, and vertex_indices (or vertex_index) of the element face, of integer types;
 * all else is skipped.  Polygons are cut as in OBJ files.  On failure the mesh has no triangles, and *error (may be
 * NULL) names the file, the line (of the header and of ascii files) or the byte, and what was expected: NSDF_CORRUPT
 * bad contents, NSDF_LIMIT too large, NSDF_NO_MEMORY. */
nsdf_status nsdf_ply_parse(const char *name, const char *text, size_t size, nsdf_file_mesh *mesh,
                           nsdf_encoder_error *error);

#endif
