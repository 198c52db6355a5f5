/* Long sequences: fitted in segments, which are joined into one file. */
#ifndef NSDF_ENC_SEGMENTS_H
#define NSDF_ENC_SEGMENTS_H

#include "cli_util.h"
#include "enc_plan.h"

/* Fits all segments, puts the file together in `file`, which is open, and closes it; *stats gets what can be said of
 * the whole.  The segments' own files stay until enc_segments_done.  0, or -1 after printing why. */
int enc_segments_encode(const enc_plan *plan, nsdf_cli_file *file, nsdf_encoder_stats *stats);

/* After the output has its name: removes the segments' files. */
void enc_segments_done(const enc_plan *plan);

#endif
