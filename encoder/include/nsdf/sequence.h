/* NSDF encoder: mesh sequences on disk.  Reads OBJ, PLY, STL and glTF frames named by files, folders, globs,
 * printf patterns or list files.  The rules of nsdf/encoder.h hold. */
#ifndef NSDF_SEQUENCE_H
#define NSDF_SEQUENCE_H

#include "nsdf/encoder.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct nsdf_sequence nsdf_sequence;

/* Expands the inputs, in the order given, each one of:
 *   a folder          every .obj in it, or if there is none every .ply, .stl, .glb or .gltf, the first of these that is
 *                     there; natural order (frame2 before frame10)
 *   a printf pattern  walk_%04d.obj: the numbers that exist, ascending
 *   a glob            "walk_*.obj" (for shells that did not expand it), natural order
 *   a list file       name ends in .txt or .lst: one path a line, relative to the list file; '#' comments, blank lines
 *                     skipped
 *   a file            anything else
 * Fails with NSDF_IO (nothing there, cannot be read) or NSDF_CORRUPT (list file) and a message that names the path. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_sequence_open(nsdf_sequence **sequence, const char *const *inputs,
                                                      size_t input_count, nsdf_encoder_error *error);
NSDF_API void nsdf_sequence_close(nsdf_sequence **sequence);

NSDF_API uint32_t nsdf_sequence_frame_count(const nsdf_sequence *sequence);
/* Borrowed until close; NULL when out of range. */
NSDF_API const char *nsdf_sequence_frame_path(const nsdf_sequence *sequence, uint32_t index);

/* Reads a frame.  The mesh is owned by the sequence, valid until the next load or close.  Errors name file and line:
 * "walk_0003.obj:17: face index 90 is out of range (the file has 88 vertices so far)", or the byte in a binary file:
 * "walk_0003.ply: byte 1302: ...".  PLY is ascii or binary of either byte order; the properties x, y, z of the element
 * vertex and vertex_indices (or vertex_index) of the element face are read.  Polygons are triangulated.  STL is ascii
 * or binary; of glTF and GLB all triangles of the default scene are read where their nodes put them, without animation.
 * NSDF_UNSUPPORTED_FEATURE for glTF where the library was built without it. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_sequence_load(nsdf_sequence *sequence, uint32_t index, nsdf_input_mesh *mesh,
                                                      nsdf_encoder_error *error);

#ifdef __cplusplus
}
#endif
#endif
