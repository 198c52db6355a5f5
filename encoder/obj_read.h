/* Wavefront OBJ: vertices and faces of a whole file. */
#ifndef NSDF_OBJ_READ_H
#define NSDF_OBJ_READ_H

#include "file_mesh.h"

/* Reads a file that is in memory; text[size] must be a zero byte, `name` is for messages.  Records other than v and f
 * are skipped, and so is what follows x y z in a v.  Quadrilaterals are cut along the better diagonal, other polygons
 * by ear clipping (those of more than 256 corners as fans).  On failure the mesh has no triangles, and *error (may be
 * NULL) names the file, the line and what was expected: NSDF_CORRUPT bad contents, NSDF_LIMIT too large,
 * NSDF_NO_MEMORY. */
nsdf_status nsdf_obj_parse(const char *name, const char *text, size_t size, nsdf_file_mesh *mesh,
                           nsdf_encoder_error *error);

#endif
