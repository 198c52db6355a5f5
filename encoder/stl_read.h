/* STL, ascii or binary: triangles of a whole file. */
#ifndef NSDF_STL_READ_H
#define NSDF_STL_READ_H

#include "file_mesh.h"

/* Reads a file that is in memory; text[size] must be a zero byte, `name` is for messages.  Binary when its size is what
 * the count of triangles in it says, else ascii.  Every triangle has vertices of its own; normals are not looked at.
 * Errors as nsdf_ply_parse. */
nsdf_status nsdf_stl_parse(const char *name, const char *text, size_t size, nsdf_file_mesh *mesh,
                           nsdf_encoder_error *error);

#endif
