/* glTF 2.0, text or binary (GLB), by way of tinygltf: the triangles of a file where its nodes put them, and the frames
 * of an animation. */
#ifndef NSDF_GLTF_READ_H
#define NSDF_GLTF_READ_H

#include "file_mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Reads a file that is in memory; `name` is its path, beside which buffers are looked for.  All triangle lists, strips
 * and fans of the default scene (or the first, or all nodes) are taken, with skins and morph targets as the file
 * stands, without animation.  On failure the mesh has no triangles; NSDF_CORRUPT bad contents or no triangles,
 * NSDF_LIMIT too large, NSDF_NO_MEMORY, NSDF_UNSUPPORTED_FEATURE built without tinygltf, or meshes that an extension
 * has compressed. */
nsdf_status nsdf_gltf_parse(const char *name, const char *text, size_t size, nsdf_file_mesh *mesh,
                            nsdf_encoder_error *error);

/* The animation of a file, kept in memory. */
typedef struct nsdf_gltf_film nsdf_gltf_film;

typedef struct nsdf_gltf_film_info {
    const double
        *keys;        /* times at which something begins or ends to move, ascending; seconds from the first, borrowed */
    size_t key_count; /* at least 2 */
    int in_steps;     /* nothing moves between keys */
    int ends_held;    /* and nothing changes at the last one, which is where the last frame ends */
    const char *note; /* what is left out, or "": borrowed */
} nsdf_gltf_film_info;

/* Takes the first animation of a file in which nodes, skins or morph targets change.  *film is NULL when it has none,
 * or when the program was built without tinygltf.  Errors as above. */
nsdf_status nsdf_gltf_film_open(nsdf_gltf_film **film, const char *name, const char *text, size_t size,
                                nsdf_encoder_error *error);
void nsdf_gltf_film_free(nsdf_gltf_film *film); /* may be NULL */
nsdf_gltf_film_info nsdf_gltf_film_describe(const nsdf_gltf_film *film);

/* The mesh at a time, seconds from the first key; up to `slack` seconds before a key are its time. */
nsdf_status nsdf_gltf_film_mesh(const nsdf_gltf_film *film, double seconds, double slack, nsdf_file_mesh *mesh,
                                nsdf_encoder_error *error);

#ifdef __cplusplus
}
#endif
#endif
