/* Whole files in memory, and meshes of any kind that is known. */
#ifndef NSDF_INPUT_FILE_H
#define NSDF_INPUT_FILE_H

#include <stdbool.h>

#include "file_mesh.h"

/* Reads a file whole.  *text is the caller's to free, text[size] is a zero byte.  Errors name the file: NSDF_IO cannot
 * be read, NSDF_LIMIT too large, NSDF_NO_MEMORY. */
nsdf_status nsdf_input_read(const char *path, char **text, size_t *size, nsdf_encoder_error *error);

/* Reads a mesh: STL, glTF or PLY when the name ends so, or PLY when the first line says so, else OBJ.  On failure the
 * mesh has no triangles. */
nsdf_status nsdf_input_read_mesh(const char *path, nsdf_file_mesh *mesh, nsdf_encoder_error *error);

/* Whether the name ends in `suffix` (lower case), in any case, and is longer. */
bool nsdf_input_has_suffix(const char *name, const char *suffix);

#endif
