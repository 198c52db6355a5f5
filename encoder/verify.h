/* Decoding what was encoded, through the public decoder, and measuring it against the input. */
#ifndef NSDF_VERIFY_H
#define NSDF_VERIFY_H

#include "bound.h"
#include "sampler.h"
#include "workers.h"

#include <stdbool.h>

enum { NSDF_MOST_STRAYS = 2048 };

/* Decoded pieces, without the largest of each frame when it comes to strays: further than 0.01 from the input. */
typedef struct nsdf_piece_report {
    uint32_t stray;      /* pieces astray */
    float largest_stray; /* diagonal of its box, normalised; 0 without any */
    float smallest_true; /* of the others, all frames' largest pieces among them; INFINITY without any */
    double bound;        /* that all need to be found: see bound_pieces.h; 0 when there is one a frame */
} nsdf_piece_report;

/* Pieces astray that are smaller than all true ones, and than the smallest of `frames`, can be left out as specks: then
 * true, and *size is below which size pieces are.  Not where the options say it. */
bool nsdf_specks_can_go(const nsdf_piece_report *pieces, const nsdf_frames *frames, const nsdf_encoder_options *options,
                        float *size);

/* Decodes every added frame at the stored default resolution; fills *quality (fractions of the diagonal, averaged over
 * frames; maxima over all) and *pieces, of the surface that the file's bound lets be found.  strays[frame] gets
 * vertices of the stray pieces with their true distances, or where the options ask for blocks all vertices as far from
 * the input, at most NSDF_MOST_STRAYS a frame; the sets must be empty at first and are freed by the caller, also on
 * failure. */
nsdf_status nsdf_verify_file(const nsdf_check_job *job, nsdf_workers *workers, const nsdf_buffer *file,
                             nsdf_quality_record *quality, nsdf_piece_report *pieces, nsdf_sample_set *strays,
                             nsdf_encoder_error *error);

#endif
