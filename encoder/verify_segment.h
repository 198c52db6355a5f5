/* Verifying what was coded, and choosing below which size decoders leave pieces out as specks. */
#ifndef NSDF_VERIFY_SEGMENT_H
#define NSDF_VERIFY_SEGMENT_H

#include "container.h"
#include "verify.h"

/* Whether another *size, below which pieces are left out, suits the surface better: a smaller one where parts of the
 * input's surface were lost, such as hands that came off; a larger one where pieces astray are smaller than all true
 * ones, and than the smallest of `frames`.  Not where the options say it. */
bool nsdf_suit_smallest_piece(const nsdf_piece_report *pieces, const nsdf_frames *frames,
                              const nsdf_encoder_options *options, float *size);

/* Verifies the file of job->header, *entry and the segment; with another entry->smallest_piece, too, when one suits
 * better: *entry gets the one with the lesser error, *quality, *pieces and strays, as in verify.h, are of that one. */
nsdf_status nsdf_verify_segment(const nsdf_check_job *job, nsdf_workers *workers, const nsdf_coded_segment *segment,
                                nsdf_index_entry *entry, nsdf_quality_record *quality, nsdf_piece_report *pieces,
                                nsdf_sample_set *strays, nsdf_encoder_error *error);

#endif
