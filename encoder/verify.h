/* Decoding what was encoded, through the public decoder, and measuring it against the input. */
#ifndef NSDF_VERIFY_H
#define NSDF_VERIFY_H

#include "check_job.h"
#include "container_write.h"
#include "sampler.h"
#include "workers.h"

#include <stdbool.h>

enum { NSDF_MOST_STRAYS = 2048 };

/* Decoded pieces, without the largest of each frame when it comes to strays: further from the input than
 * NSDF_STRAY_DISTANCE (lost_pieces.h). */
typedef struct nsdf_piece_report {
    uint32_t stray;      /* pieces astray */
    float largest_stray; /* diagonal of its box, normalised; 0 without any */
    float smallest_true; /* of the others, all frames' largest pieces among them; INFINITY without any */
    float smallest_lost; /* part of the input's surface that the file says to leave out; INFINITY without any */
    double bound;        /* that all need to be found: see bound_pieces.h; 0 when there is one a frame */
} nsdf_piece_report;

/* What was found at one frame. */
typedef struct nsdf_frame_check {
    double mean[2], mean_square[2], max[2]; /* distances to decoded and to input, fractions of the diagonal */
    nsdf_piece_report pieces;
    float smallest;   /* of all pieces; INFINITY without any */
    uint32_t dropped; /* smaller ones, which were left out */
    float size;       /* of the smallest piece that the file had then */
    bool is_done;
} nsdf_frame_check;

/* Decodes every added frame at the stored default resolution.  Fills checks[frame], of the surface that the file's
 * bound lets be found; one that is done is taken over if the size of the smallest piece, which is all that may be
 * different about the file since, does not change that frame.  strays[frame] gets vertices of the stray pieces with
 * their true distances, or where the options ask for blocks all vertices as far from the input, at most
 * NSDF_MOST_STRAYS a frame; the sets are freed by the caller, also on failure. */
nsdf_status nsdf_verify_file(const nsdf_check_job *job, nsdf_workers *workers, const nsdf_buffer *file,
                             nsdf_frame_check *checks, nsdf_sample_set *strays, nsdf_encoder_error *error);

/* All frames together: means of the means, maxima over all. */
nsdf_quality_record nsdf_quality_of_checks(const nsdf_frame_check *checks, uint32_t frames, uint32_t resolution);
nsdf_piece_report nsdf_pieces_of_checks(const nsdf_frame_check *checks, uint32_t frames);

#endif
