/* Decoded meshes as surfaces in normalised coordinates. */
#ifndef NSDF_DECODED_SURFACE_H
#define NSDF_DECODED_SURFACE_H

#include "container_write.h"
#include "nsdf/decoder.h"
#include "surface.h"

/* A copy of the mesh, to be freed by nsdf_surface_free whatever is returned: 0, or -1 when memory ran out. */
int nsdf_decoded_surface(const nsdf_file_header *header, const nsdf_mesh *mesh, nsdf_surface *surface);

#endif
