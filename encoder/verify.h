/* Decoding what was encoded, through the public decoder, and measuring it against the input. */
#ifndef NSDF_VERIFY_H
#define NSDF_VERIFY_H

#include "bound.h"
#include "workers.h"

/* Decodes every added frame at the stored default resolution; fills *quality (fractions of the diagonal, averaged over
 * frames; maxima over all) and *stray_pieces. */
nsdf_status nsdf_verify_file(const nsdf_check_job *job, nsdf_workers *workers, const nsdf_buffer *file,
                             nsdf_quality_record *quality, uint32_t *stray_pieces, nsdf_encoder_error *error);

#endif
