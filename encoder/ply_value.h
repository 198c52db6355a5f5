/* Numbers in the body of a PLY file, text or binary. */
#ifndef NSDF_PLY_VALUE_H
#define NSDF_PLY_VALUE_H

#include "ply_header.h"

/* Where a body is being read.  In ascii files every element has its own line. */
typedef struct nsdf_ply_cursor {
    const char *name;             /* of the file, for messages */
    const char *start, *at, *end; /* *end is a zero byte */
    nsdf_ply_format format;
    uint64_t line; /* of ascii files */
    nsdf_encoder_error *error;
} nsdf_ply_cursor;

/* NSDF_CORRUPT, with a message that names the file and the line, or the byte at `at`. */
#if defined(__GNUC__)
__attribute__((format(printf, 3, 4)))
#endif
nsdf_status
nsdf_ply_fail(const nsdf_ply_cursor *cursor, const char *at, const char *format, ...);

/* Before and after the values of an element: the line's begin and end; nothing in binary files. */
nsdf_status nsdf_ply_begin_element(nsdf_ply_cursor *cursor);
nsdf_status nsdf_ply_end_element(nsdf_ply_cursor *cursor);

/* The next value.  NSDF_CORRUPT when the file ends there, or the word is no such number. */
nsdf_status nsdf_ply_read_real(nsdf_ply_cursor *cursor, nsdf_ply_type type, double *value);
nsdf_status nsdf_ply_read_whole(nsdf_ply_cursor *cursor, nsdf_ply_type type, int64_t *value); /* integer types only */
nsdf_status nsdf_ply_skip_value(nsdf_ply_cursor *cursor, nsdf_ply_type type);

/* After the last element only blanks and line ends may follow. */
nsdf_status nsdf_ply_check_end(nsdf_ply_cursor *cursor);

#endif
