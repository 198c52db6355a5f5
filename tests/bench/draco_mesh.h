/* Draco for the benches, as C functions: libdraco has a C++ interface only.  Positions, normals where
 * they are wanted, and triangles.
 *
 * Functions that can fail say how they show it, and then fill in `error`. */
#ifndef DRACO_MESH_H
#define DRACO_MESH_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct draco_mesh_options {
    int level;         /* compression level, 0 (fast) to 10 (small): -cl of draco_encoder */
    int position_bits; /* of each coordinate, 1 to 30: -qp of draco_encoder */
    int normal_bits;   /* of each of the two coordinates of a normal, 2 to 30: -qn; 0 = no normals */
} draco_mesh_options;

typedef struct draco_mesh_bytes {
    unsigned char *data;
    size_t size;
} draco_mesh_bytes;

typedef struct draco_mesh_error {
    char message[160];
} draco_mesh_error;

typedef struct draco_mesh_decoded draco_mesh_decoded; /* as Draco's decoder leaves it */

/* Encodes positions [][3], normals [][3] if options have bits for them (else they may be NULL), and indices
 * [triangle_count][3].  Equal vertices become one, as Draco's own reader of OBJ files has it.  Returns 0, or -1 with
 * bytes untouched; the bytes are freed with draco_mesh_bytes_free. */
int draco_mesh_encode(const float *positions, const float *normals, const uint32_t *indices, uint32_t triangle_count,
                      const draco_mesh_options *options, draco_mesh_bytes *bytes, draco_mesh_error *error);
void draco_mesh_bytes_free(draco_mesh_bytes *bytes);

/* Decodes, on the calling thread, and copies nothing: what is to be timed.  NULL on failure. */
draco_mesh_decoded *draco_mesh_decode(const void *data, size_t size, draco_mesh_error *error);
void draco_mesh_decoded_free(draco_mesh_decoded *decoded); /* NULL-safe */

uint32_t draco_mesh_vertex_count(const draco_mesh_decoded *decoded);
uint32_t draco_mesh_triangle_count(const draco_mesh_decoded *decoded);
/* positions [vertex_count][3], indices [triangle_count][3]; either may be NULL. */
void draco_mesh_copy(const draco_mesh_decoded *decoded, float *positions, uint32_t *indices);

/* The library's version, "1.5.5". */
const char *draco_mesh_version(void);

#ifdef __cplusplus
}
#endif
#endif
