/* Binary glTF 2.0 (.glb): one surface, or a film of surfaces whose meshes are shown one after the other. */
#ifndef NSDF_GLTF_WRITER_H
#define NSDF_GLTF_WRITER_H

#include "nsdf/export.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct nsdf_gltf nsdf_gltf;

/* generator: what asset.generator says.  NULL when memory ran out. */
nsdf_gltf *nsdf_gltf_create(const char *generator);
void nsdf_gltf_free(nsdf_gltf *gltf);

/* Copies a surface of the time `seconds` of the file; an empty one is a moment at which nothing is shown.  Coordinates
 * stay as they are.  NSDF_OK, NSDF_LIMIT when the file would be larger than its format allows (4 GiB), or
 * NSDF_NO_MEMORY. */
nsdf_status nsdf_gltf_add(nsdf_gltf *gltf, const nsdf_mesh_view *view, double seconds);

/* Writes what was added.  Of several surfaces, each is a node that an animation makes visible (its scale is 1 instead
 * of 0, in steps) at index * interval seconds; the last is held for one interval.  Players that play no animations show
 * the first.  NSDF_OK, NSDF_IO when `write` failed, or NSDF_NO_MEMORY. */
nsdf_status nsdf_gltf_write(const nsdf_gltf *gltf, double interval, nsdf_write_fn write, void *user);

#ifdef __cplusplus
}
#endif
#endif
