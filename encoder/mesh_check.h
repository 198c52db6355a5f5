/* What a caller's mesh must be. */
#ifndef NSDF_MESH_CHECK_H
#define NSDF_MESH_CHECK_H

#include "nsdf/encoder.h"

/* Fails with NSDF_INVALID_ARGUMENT when there are no triangles, an index is out of range, or a coordinate of a vertex
 * that a triangle uses is not finite or above 1e30; the message begins with `name` and a colon. */
nsdf_status nsdf_check_mesh(const char *name, const nsdf_input_mesh *mesh, nsdf_encoder_error *error);

#endif
