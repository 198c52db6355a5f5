/* glTF 2.0, text or binary (GLB), by way of tinygltf: the triangles of a file where its nodes put them. */
#ifndef NSDF_GLTF_READ_H
#define NSDF_GLTF_READ_H

#include "file_mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Reads a file that is in memory; `name` is its path, beside which buffers are looked for.  All triangle lists, strips
 * and fans of the default scene (or the first, or all nodes) are taken; skins, morph targets and animations are not
 * applied.  On failure the mesh has no triangles; NSDF_CORRUPT bad contents or no triangles, NSDF_LIMIT too large,
 * NSDF_NO_MEMORY, NSDF_UNSUPPORTED_FEATURE built without tinygltf. */
nsdf_status nsdf_gltf_parse(const char *name, const char *text, size_t size, nsdf_file_mesh *mesh,
                            nsdf_encoder_error *error);

#ifdef __cplusplus
}
#endif
#endif
