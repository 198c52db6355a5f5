/* The meshes that a file was made from: OBJ frames in a folder, one for each encoded frame, or else
 * as far apart in time as the numbers in their names, from the file's first frame on. */
#ifndef PLAY_REFERENCE_H
#define PLAY_REFERENCE_H

#include "nsdf/decoder.h"

typedef struct play_reference play_reference;

/* All names in `folder` that end in .obj, frame2 before frame10.  If these are not `count`, the number of frames of the
 * file, a line says so.  NSDF_CLI_SUCCESS, or NSDF_CLI_FAILURE after printing why: no meshes, or times that are not to
 * be told or end before the file does. */
int play_reference_open(play_reference **reference, const char *folder, uint32_t count);
/* NULL-safe. */
void play_reference_close(play_reference *reference);

/* The mesh of a frame, or the nearest in time to it, valid until the next load.  NSDF_CLI_SUCCESS, or NSDF_CLI_FAILURE
 * after printing why. */
int play_reference_load(play_reference *reference, uint32_t frame, nsdf_mesh_view *view);

/* Which of two names comes first: as strcmp, but numbers in them by their value. */
int play_reference_order(const char *a, const char *b);

#endif
