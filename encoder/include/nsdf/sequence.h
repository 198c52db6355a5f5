/* NSDF encoder: mesh sequences on disk.  Reads OBJ, PLY, STL and glTF frames named by files, folders, globs,
 * printf patterns or list files.  The rules of nsdf/encoder.h hold. */
#ifndef NSDF_SEQUENCE_H
#define NSDF_SEQUENCE_H

#include "nsdf/encoder.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct nsdf_sequence nsdf_sequence;

typedef struct nsdf_sequence_options {
    size_t struct_size;          /* set by nsdf_sequence_options_init */
    uint32_t rate_num, rate_den; /* frames per second, for inputs that tell times in seconds; default 0: that of the
                                    keys of an animation, or 25 */
    int ignore_numbers;          /* files follow each other one frame apart, whatever their numbers or times */
} nsdf_sequence_options;

NSDF_API void nsdf_sequence_options_init(nsdf_sequence_options *options);

/* Expands the inputs, in the order given, each one of:
 *   a folder          every .obj in it, or if there is none every .ply, .stl, .glb or .gltf, the first of these that is
 *                     there; natural order (frame2 before frame10)
 *   a printf pattern  walk_%04d.obj: the numbers that exist, ascending
 *   a glob            "walk_*.obj" (for shells that did not expand it), natural order
 *   a list file       name ends in .txt or .lst: in each line a path, relative to the list file, or a path, blanks and
 *                     a time in seconds; '#' comments, blank lines skipped
 *   a file            anything else
 *
 * A glTF file with an animation, alone, is a sequence: from the first key of its first animation to the last one, with
 * nodes, skins and morph targets as they are at the times of frames.  Otherwise each file is the mesh of a frame.
 * Frames are numbered in time, from 0 for the first file; numbers may be missing:
 *   - A list file with times, in all its lines and ascending, is the only input.  Times are counted from the first, and
 *     are those of frames at the rate of the options, at most a tenth of an interval beside them.
 *   - Otherwise, files whose names differ in one number are as far apart as their numbers, in steps of the greatest
 *     common divisor of all such differences (f_10, f_20, f_40: frames 0, 1, 3); files of other names follow each
 * other.
 *   - When such numbers do not ascend everywhere, all files follow each other.
 * Fails with NSDF_IO (nothing there, cannot be read), NSDF_CORRUPT (list file) or NSDF_LIMIT (numbers too far apart),
 * and a message that names the path. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_sequence_open(nsdf_sequence **sequence, const char *const *inputs,
                                                      size_t input_count, const nsdf_sequence_options *options,
                                                      nsdf_encoder_error *error);
NSDF_API void nsdf_sequence_close(nsdf_sequence **sequence);

/* The number of the last frame, and 1. */
NSDF_API uint32_t nsdf_sequence_frame_count(const nsdf_sequence *sequence);
/* Another handle on an open sequence, for another thread: its loads and those of the first do not disturb each other.
 * To be closed before the first. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_sequence_share(const nsdf_sequence *sequence, nsdf_sequence **other,
                                                       nsdf_encoder_error *error);

/* Frames per second: those of the options, or what was chosen for them. */
NSDF_API void nsdf_sequence_rate(const nsdf_sequence *sequence, uint32_t *rate_num, uint32_t *rate_den);
/* How many frames have a mesh, and their numbers, ascending; UINT32_MAX when i is out of range. */
NSDF_API uint32_t nsdf_sequence_mesh_count(const nsdf_sequence *sequence);
NSDF_API uint32_t nsdf_sequence_mesh_frame(const nsdf_sequence *sequence, uint32_t i);
/* Borrowed until close; NULL when the frame has no mesh. */
NSDF_API const char *nsdf_sequence_frame_path(const nsdf_sequence *sequence, uint32_t frame);

/* For messages: the path, and of an animation the number of the frame.  "" when the frame has no mesh. */
NSDF_API void nsdf_sequence_name_frame(const nsdf_sequence *sequence, uint32_t frame, char *text, size_t size);
/* What should be told about the input, one line without its name, or "".  Borrowed until close. */
NSDF_API const char *nsdf_sequence_note(const nsdf_sequence *sequence);

/* Names the files that are missing between those that are there, going by their numbers: "3, 8-9", and "..." at the end
 * where `size` is short.  Returns the number of frames without a mesh; where a list file told their times, no text. */
NSDF_API uint32_t nsdf_sequence_missing(const nsdf_sequence *sequence, char *text, size_t size);

/* Reads a frame.  The mesh is owned by the sequence, valid until the next load or close.  Errors name file and line:
 * "walk_0003.obj:17: face index 90 is out of range (the file has 88 vertices so far)", or the byte in a binary file:
 * "walk_0003.ply: byte 1302: ...".  PLY is ascii or binary of either byte order; the properties x, y, z of the element
 * vertex and vertex_indices (or vertex_index) of the element face are read.  Polygons are triangulated.  STL is ascii
 * or binary; of glTF and GLB all triangles of the default scene are read where their nodes and skins put them.
 * NSDF_UNSUPPORTED_FEATURE for glTF where the library was built without it. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_sequence_load(nsdf_sequence *sequence, uint32_t frame, nsdf_input_mesh *mesh,
                                                      nsdf_encoder_error *error);

#ifdef __cplusplus
}
#endif
#endif
