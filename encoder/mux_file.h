/* A file in parts: what nsdf_mux edits. */
#ifndef NSDF_MUX_FILE_H
#define NSDF_MUX_FILE_H

#include "container_write.h"
#include "nsdf/mux.h"

struct nsdf_mux {
    nsdf_file_header header;
    nsdf_index_entry *entries; /* [header.segment_count] */
    nsdf_buffer *payloads;     /* of the SEGM chunks, [header.segment_count] */
    int has_quality;
    nsdf_quality_record quality;
    int is_held; /* the last frame was not measured: nsdf_mux_hold made it */
    int has_metadata;
    nsdf_buffer metadata;     /* META's payload */
    nsdf_loose_chunk *others; /* [other_count] */
    uint32_t other_count;
};

/* Fills a zeroed *mux.  On failure the caller still calls nsdf_mux_release. */
nsdf_status nsdf_mux_read(nsdf_mux *mux, const uint8_t *data, size_t size, nsdf_encoder_error *error);

/* Appends copies of `count` segments of `from`, the first of them `first`, and of the other chunks in front of them
 * (and of those behind, with the last); their entries keep their frames.  Returns 0, or -1 when memory ran out: *mux is
 * then as it was. */
int nsdf_mux_take_segments(nsdf_mux *mux, const nsdf_mux *from, uint32_t first, uint32_t count);

/* The same with all segments of `from` but the first, which is the last of mux continued: of the other chunks those
 * that mux does not have at the same place. */
int nsdf_mux_take_rest(nsdf_mux *mux, const nsdf_mux *from);

/* Rate, box and domain: NSDF_INVALID_ARGUMENT names what differs. */
nsdf_status nsdf_mux_expect_same(const nsdf_file_header *a, const nsdf_file_header *b, nsdf_encoder_error *error);
/* Makes the box and the bound of `a` hold for both. */
void nsdf_mux_join_box(nsdf_file_header *a, const nsdf_file_header *b);

/* Frees what *mux holds, not *mux. */
void nsdf_mux_release(nsdf_mux *mux);

#endif
