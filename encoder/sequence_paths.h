/* Names of frames: what an input of a sequence stands for. */
#ifndef NSDF_SEQUENCE_PATHS_H
#define NSDF_SEQUENCE_PATHS_H

#include "nsdf/encoder.h"

typedef struct nsdf_frame_file {
    char *path; /* owned */
    /* That a list file says: */
    double seconds;
    unsigned line;
} nsdf_frame_file;

typedef struct nsdf_path_list {
    nsdf_frame_file *items; /* owned */
    size_t count, capacity;
    char *timed_list; /* owned: the list file that says times, of all items; NULL = there are none */
} nsdf_path_list;

void nsdf_path_list_free(nsdf_path_list *list);

/* Appends the files that an input names (see nsdf/sequence.h), at least one.  On failure the list may have grown.  A
 * list file that says times must be the only input, which is the caller's to check. */
nsdf_status nsdf_expand_input(nsdf_path_list *list, const char *input, nsdf_encoder_error *error);

/* Order in which people count: runs of digits compare as numbers, all else by byte.  As strcmp. */
int nsdf_natural_compare(const char *a, const char *b);

#endif
