/* NSDF files cut, joined and put together again without coding anything anew.
 *
 *     nsdf_mux *whole = NULL, *more = NULL;
 *     nsdf_mux_open(&whole, data, size, &err);
 *     nsdf_mux_open(&more, other_data, other_size, &err);
 *     nsdf_mux_append(whole, more, 2, &err);
 *     nsdf_mux_write(whole, write, user, &err);
 *     nsdf_mux_close(&more);
 *     nsdf_mux_close(&whole);
 *
 * The rules of nsdf/encoder.h hold; after a failure the handle is as it was before the call.  Chunks that this version
 * does not know stay where they are between the segments.
 */
#ifndef NSDF_MUX_H
#define NSDF_MUX_H

#include "nsdf/encoder.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct nsdf_mux nsdf_mux;

/* Takes a file apart; the bytes are copied.  Structure and checksums of all chunks are checked, parameters are not
 * decoded.  Statuses as for nsdf_open_memory; the message names the byte. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_mux_open(nsdf_mux **mux, const void *data, size_t size,
                                                 nsdf_encoder_error *error);
NSDF_API void nsdf_mux_close(nsdf_mux **mux);

NSDF_API uint32_t nsdf_mux_frame_count(const nsdf_mux *mux);
NSDF_API uint32_t nsdf_mux_segment_count(const nsdf_mux *mux);

/* The errors that the encoder measured.  NSDF_INVALID_ARGUMENT when the file has none. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_mux_get_quality(const nsdf_mux *mux, nsdf_quality *quality);

/* As far as the models of both sides reach, but at most NSDF_MUX_FADE frames. */
#define NSDF_MUX_FADE_AUTO 0xffffffffu
enum { NSDF_MUX_FADE = 2 };

/* Puts the segments of `other` behind those of `mux`; the first frame of `other` takes the place of the last of `mux`.
 * For the time of `fade` frames before and after it the surface goes over from one to the other, which needs models
 * that reach so far (nsdf_encoder_options.lead and trail, or a cut); 0 = none.  Where `other` goes on with the model
 * that `mux` ends with, because a cut parted them, they become one segment again, unless `fade` says otherwise.  Frame
 * rate, box and domain must be the same: else NSDF_INVALID_ARGUMENT names what differs.  Errors that were measured are
 * put together, means by frames, where both files have them for the same resolution, and left out otherwise; the frame
 * of the join counts once.  Pairs of metadata of `other` are left out. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_mux_append(nsdf_mux *mux, const nsdf_mux *other, uint32_t fade,
                                                   nsdf_encoder_error *error);

/* Makes the last frame stay for `frames` frames more.  Before an nsdf_mux_append of 1: no frame is lost. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_mux_hold(nsdf_mux *mux, uint32_t frames, nsdf_encoder_error *error);

/* Keeps frames first to last, which become 0 to last - first; segments outside go.  A cross-fade that is cut through is
 * made as short as what is left of it.  Measured errors go unless all frames stay: only those of all frames together
 * are known. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_mux_cut(nsdf_mux *mux, uint32_t first, uint32_t last,
                                                nsdf_encoder_error *error);

/* Puts the segments of `other` in place of segments first to last, which must have as many frames and, as for
 * nsdf_mux_append, the same rate, box and domain.  Cross-fades with the neighbours become as short as the models reach.
 * Chunks that stood in front of the segments that go, go too.  Measured errors go. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_mux_replace(nsdf_mux *mux, uint32_t first, uint32_t last, const nsdf_mux *other,
                                                    nsdf_encoder_error *error);

/* Frames a second as a fraction; out parameters are untouched for a NULL. */
NSDF_API void nsdf_mux_get_rate(const nsdf_mux *mux, uint32_t *num, uint32_t *den);
/* Plays the same frames at another rate, num / den frames a second. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_mux_set_rate(nsdf_mux *mux, uint32_t num, uint32_t den,
                                                     nsdf_encoder_error *error);

/* Metadata are pairs of UTF-8 strings, borrowed until they are changed. */
NSDF_API uint32_t nsdf_mux_metadata_count(const nsdf_mux *mux);
NSDF_API NSDF_MUST_USE nsdf_status nsdf_mux_get_metadata(const nsdf_mux *mux, uint32_t index, const char **key,
                                                         const char **value);
/* Replaces all pairs of that key by one, at the place of the first, or behind the others; removes them with a NULL
 * value. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_mux_set_metadata(nsdf_mux *mux, const char *key, const char *value,
                                                         nsdf_encoder_error *error);

/* A segment as in the index (bitstream, section 7). */
typedef struct nsdf_mux_segment {
    uint32_t first_frame, last_frame;
    int32_t lead, trail; /* frames by which the model reaches beyond them */
    uint32_t fade;       /* half the length of the cross-fade around first_frame, frames */
    uint64_t size;       /* bytes of its payload */
    uint64_t parameter_hash;
} nsdf_mux_segment;

NSDF_API NSDF_MUST_USE nsdf_status nsdf_mux_get_segment(const nsdf_mux *mux, uint32_t index, nsdf_mux_segment *segment);

/* Chunks that this version does not know. */
typedef struct nsdf_mux_chunk {
    char type[8];    /* four letters */
    uint32_t before; /* the segment that it stands in front of; the number of segments: behind the last */
    uint64_t size;   /* bytes of its payload */
} nsdf_mux_chunk;

NSDF_API uint32_t nsdf_mux_chunk_count(const nsdf_mux *mux);
NSDF_API NSDF_MUST_USE nsdf_status nsdf_mux_get_chunk(const nsdf_mux *mux, uint32_t index, nsdf_mux_chunk *chunk);

/* The file's bytes.  `write` returns 0, or nonzero to stop with NSDF_IO. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_mux_write(const nsdf_mux *mux,
                                                  int (*write)(void *user, const void *data, size_t size), void *user,
                                                  nsdf_encoder_error *error);

#ifdef __cplusplus
}
#endif

#endif
