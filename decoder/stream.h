/* The front of a file (preamble, HEAD, INDX, QUAL, META), validated, and access to its chunks. */
#ifndef NSDF_STREAM_H
#define NSDF_STREAM_H

#include "container_read.h"
#include "memory.h"
#include "source.h"

/* A chunk whose CRC matched.  The payload is the source's own memory, or `owned`. */
typedef struct nsdf_chunk {
    nsdf_chunk_header header;
    const uint8_t *payload;
    void *owned;
} nsdf_chunk;

typedef struct nsdf_stream {
    nsdf_source source;
    nsdf_version_fields version;
    nsdf_file_header header;
    nsdf_index_entry *entries; /* header.segment_count */
    uint64_t rest;             /* first byte behind INDX */
    int has_quality, has_metadata;
    nsdf_quality_record quality;
    nsdf_chunk metadata;
    const char **strings; /* key, value, key, value, ... inside the metadata chunk */
    uint32_t pair_count;
} nsdf_stream;

/* Reads everything in front of the first segment.  stream->source is set, the rest zero.  On failure the caller still
 * calls nsdf_stream_close. */
nsdf_status nsdf_stream_open(nsdf_stream *stream, nsdf_memory *memory, nsdf_error *error);
/* Closes the source too. */
void nsdf_stream_close(nsdf_stream *stream, nsdf_memory *memory);

/* Walks over all chunks behind INDX and checks their CRCs and their agreement with the index; needs little memory
 * whatever the size of the chunks. */
nsdf_status nsdf_stream_check_all(const nsdf_stream *stream, nsdf_memory *memory, nsdf_error *error);

/* Reads a whole chunk and checks its CRC; nothing is allocated before its length is known to fit the file. */
nsdf_status nsdf_stream_chunk(const nsdf_stream *stream, nsdf_memory *memory, uint64_t offset, nsdf_chunk *chunk,
                              nsdf_error *error);
/* The chunk where the index has segment `index`: in a single read, because a read may be a round trip over a network.
 * It may turn out to be of another type or length than the index says. */
nsdf_status nsdf_stream_segment(const nsdf_stream *stream, nsdf_memory *memory, uint32_t index, nsdf_chunk *chunk,
                                nsdf_error *error);
void nsdf_chunk_free(nsdf_memory *memory, nsdf_chunk *chunk);

/* Time of a nominal frame in seconds, rounded once as long as index * rate_den < 2^53. */
double nsdf_stream_frame_time(const nsdf_stream *stream, uint32_t index);
double nsdf_stream_duration(const nsdf_stream *stream);

/* Where a time lies: in one segment, or in the cross-fade from one to the next. */
typedef struct nsdf_place {
    uint32_t first;  /* segment */
    uint32_t count;  /* 1, or 2 in a cross-fade: `first` and the one behind it */
    double u[2];     /* where in the models' time, 0 to 1 */
    double share[2]; /* of the models in the field; sum 1 */
} nsdf_place;

/* The place of time t in [0, duration].  A segment holds its first frame but not its last; the last segment holds
 * both. */
nsdf_place nsdf_stream_find(const nsdf_stream *stream, double t);

#endif
