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

/* The longest word of a file that messages show in full. */
#define NSDF_SHOWN_TOKEN 24

typedef struct nsdf_shown_token {
    char text[NSDF_SHOWN_TOKEN + 4];
} nsdf_shown_token;

/* Unprintable characters become '?'. */
nsdf_shown_token nsdf_show_token(const char *token, size_t length);

/* Fills *error (may be NULL) and returns the status. */
#if defined(__GNUC__)
__attribute__((format(printf, 3, 4)))
#endif
nsdf_status
nsdf_input_fail(nsdf_encoder_error *error, nsdf_status status, const char *format, ...);

nsdf_status nsdf_input_no_memory(nsdf_encoder_error *error);

#endif
