/* The decoder's handle, and what its parts do for each other. */
#ifndef NSDF_HANDLE_H
#define NSDF_HANDLE_H

#include "mesher.h"
#include "segment_field.h"
#include "stream.h"
#include "tasks.h"

/* What extraction takes: `fixed` seconds and `slope` for each unit of squared resolution; of the last one also how long
 * it took.  Resolution 0 = not measured yet. */
typedef struct nsdf_pace {
    double fixed, slope, seconds;
    uint32_t resolution;
} nsdf_pace;

struct nsdf_decoder {
    nsdf_decoder_options options; /* every field set */
    nsdf_memory memory;
    nsdf_stream stream;
    nsdf_tasks *tasks;
    nsdf_segment_cache cache;
    uint64_t *parameter_counts; /* of each segment; 0 = not loaded yet */
    nsdf_segment_field field;   /* at the time prepared last */
    float smallest_piece;       /* then, normalised */
    uint64_t scratch_floats;    /* room in field.scratch */
    nsdf_mesher *mesher;        /* made at the first extraction */
    nsdf_mesh_storage into;     /* for nsdf_extract_mesh_into */
    nsdf_extraction_stats stats;
    nsdf_pace pace;   /* of nsdf_extract_mesh_within */
    nsdf_error error; /* of the last call that failed */
};

/* NSDF_INVALID_ARGUMENT with a message in the handle's error. */
nsdf_status nsdf_handle_invalid(nsdf_decoder *decoder, const char *message);

/* Loads the segment that holds time t, or the two of a cross-fade, and composes them: decoder->field and
 * decoder->smallest_piece are ready.  Checks t. */
nsdf_status nsdf_handle_prepare(nsdf_decoder *decoder, double t);

/* The loaded segment. */
nsdf_status nsdf_handle_segment(nsdf_decoder *decoder, uint32_t index, nsdf_segment **segment);

/* Frees what is kept for speed only: the mesher's scratch memory and the segments other than those two (NULL = all of
 * them, and the workers' scratch memory).  Called before giving up with NSDF_LIMIT, so that a result never depends on
 * what was decoded before. */
void nsdf_handle_trim(nsdf_decoder *decoder, const nsdf_segment *const keep[2]);

#endif
