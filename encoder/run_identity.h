/* What the result of fitting depends on besides the program: its options and its input.  A checkpoint carries it, so
 * that it is gone on with in no other run. */
#ifndef NSDF_RUN_IDENTITY_H
#define NSDF_RUN_IDENTITY_H

#include "bytes.h"
#include "container_write.h"
#include "frames.h"

/* An option; those without `fitting` only matter afterwards, or never, and may differ. */
typedef struct nsdf_option_field {
    const char *name;
    size_t offset, size; /* in nsdf_encoder_options */
    int real, fitting;
} nsdf_option_field;

/* All options but struct_size, in the order of the struct. */
const nsdf_option_field *nsdf_option_fields(size_t *count);

/* Options and hashes of the frames, as they were added: call before nsdf_frames_normalise. */
void nsdf_identity_write(nsdf_buffer *out, const nsdf_encoder_options *options, const nsdf_frames *frames);

/* Reads what nsdf_identity_write wrote.  NSDF_OK, or NSDF_INVALID_ARGUMENT with a message that names the first thing
 * that differs, or NSDF_CORRUPT. */
nsdf_status nsdf_identity_compare(nsdf_cursor *in, const nsdf_encoder_options *options, const nsdf_frames *frames,
                                  nsdf_encoder_error *error);

#endif
