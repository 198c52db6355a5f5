/* Messages about input files. */
#ifndef NSDF_INPUT_ERROR_H
#define NSDF_INPUT_ERROR_H

#include "nsdf/encoder.h"

/* The longest path that messages show in full; of longer ones the end is shown. */
#define NSDF_SHOWN_PATH 120

typedef struct nsdf_shown_path {
    char text[NSDF_SHOWN_PATH + 4];
} nsdf_shown_path;

nsdf_shown_path nsdf_show_path(const char *path);

/* Fills *error (may be NULL) and returns the status. */
#if defined(__GNUC__)
__attribute__((format(printf, 3, 4)))
#endif
nsdf_status
nsdf_input_fail(nsdf_encoder_error *error, nsdf_status status, const char *format, ...);

nsdf_status nsdf_input_no_memory(nsdf_encoder_error *error);

#endif
