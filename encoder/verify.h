/* Decoding what was encoded, through the public decoder, and measuring it against the input. */
#ifndef NSDF_VERIFY_H
#define NSDF_VERIFY_H

#include "bound.h"
#include "sampler.h"
#include "workers.h"

enum { NSDF_MOST_STRAYS = 2048 };

/* Decodes every added frame at the stored default resolution; fills *quality (fractions of the diagonal, averaged over
 * frames; maxima over all) and *stray_pieces.  strays[frame] gets vertices of the stray pieces with their true
 * distances, at most NSDF_MOST_STRAYS a frame; the sets must be empty at first and are freed by the caller, also on
 * failure. */
nsdf_status nsdf_verify_file(const nsdf_check_job *job, nsdf_workers *workers, const nsdf_buffer *file,
                             nsdf_quality_record *quality, uint32_t *stray_pieces, nsdf_sample_set *strays,
                             nsdf_encoder_error *error);

#endif
