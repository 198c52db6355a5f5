/* Names of frames: what an input of a sequence stands for. */
#ifndef NSDF_SEQUENCE_PATHS_H
#define NSDF_SEQUENCE_PATHS_H

#include "nsdf/encoder.h"

typedef struct nsdf_path_list {
    char **items; /* owned */
    size_t count, capacity;
} nsdf_path_list;

void nsdf_path_list_free(nsdf_path_list *list);

/* Appends the files that an input names (see nsdf/sequence.h), at least one.  On failure the list may have grown. */
nsdf_status nsdf_expand_input(nsdf_path_list *list, const char *input, nsdf_encoder_error *error);

/* Order in which people count: runs of digits compare as numbers, all else by byte.  As strcmp. */
int nsdf_natural_compare(const char *a, const char *b);

#endif
