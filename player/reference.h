/* The meshes that a file was made from: OBJ frames in a folder, one for each encoded frame. */
#ifndef PLAY_REFERENCE_H
#define PLAY_REFERENCE_H

#include "nsdf/decoder.h"

typedef struct play_reference play_reference;

/* All names in `folder` that end in .obj, frame2 before frame10; there must be `count` of them.  NSDF_CLI_SUCCESS, or
 * NSDF_CLI_FAILURE after printing why. */
int play_reference_open(play_reference **reference, const char *folder, uint32_t count);
/* NULL-safe. */
void play_reference_close(play_reference *reference);

/* Mesh `index`, valid until the next load.  NSDF_CLI_SUCCESS, or NSDF_CLI_FAILURE after printing why. */
int play_reference_load(play_reference *reference, uint32_t index, nsdf_mesh_view *view);

/* Which of two names comes first: as strcmp, but numbers in them by their value. */
int play_reference_order(const char *a, const char *b);

#endif
