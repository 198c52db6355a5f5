/* Writing the container.  Encoders only; the counterpart of container_read.h. */
#ifndef NSDF_CONTAINER_WRITE_H
#define NSDF_CONTAINER_WRITE_H

#include "container_read.h"

/* Growing byte buffer on malloc; `failed` sticks when memory runs out, later appends do nothing. */
typedef struct nsdf_buffer {
    uint8_t *data;
    size_t size, capacity;
    int failed;
} nsdf_buffer;

void nsdf_buffer_append(nsdf_buffer *b, const void *data, size_t size);
void nsdf_buffer_u8(nsdf_buffer *b, uint8_t v);
void nsdf_buffer_u16(nsdf_buffer *b, uint16_t v);
void nsdf_buffer_u32(nsdf_buffer *b, uint32_t v);
void nsdf_buffer_u64(nsdf_buffer *b, uint64_t v);
void nsdf_buffer_f32(nsdf_buffer *b, float v);
void nsdf_buffer_f64(nsdf_buffer *b, double v);
void nsdf_buffer_free(nsdf_buffer *b);

void nsdf_write_preamble(nsdf_buffer *b);
void nsdf_write_chunk(nsdf_buffer *b, uint32_t type, uint32_t flags, const void *payload, size_t size);
void nsdf_write_header(nsdf_buffer *payload, const nsdf_file_header *header);
void nsdf_write_quality(nsdf_buffer *payload, const nsdf_quality_record *quality);
/* Appends one pair to META's payload.  The strings may not hold a NUL; key <= 65535 bytes. */
void nsdf_write_metadata(nsdf_buffer *payload, const char *key, const char *value);

/* An ancillary chunk that is not one of the format's own. */
typedef struct nsdf_loose_chunk {
    uint32_t type, flags;
    uint32_t before; /* the segment that it stands in front of; segment_count: behind the last */
    nsdf_buffer payload;
} nsdf_loose_chunk;

typedef struct nsdf_file_parts {
    nsdf_file_header header;            /* segment_count says how many payloads there are */
    const nsdf_buffer *segments;        /* SEGM payloads */
    nsdf_index_entry *entries;          /* offset and size are filled in */
    const nsdf_buffer *metadata;        /* META payload, or NULL */
    const nsdf_quality_record *quality; /* or NULL */
    const nsdf_loose_chunk *others;     /* [other_count], or NULL; `before` does not descend */
    uint32_t other_count;
} nsdf_file_parts;

/* A whole file: preamble, HEAD, INDX, [QUAL], [META], SEGM..., ENDF, and the others among the SEGM.  Returns 0, or -1
 * when memory ran out. */
int nsdf_write_file(nsdf_buffer *out, nsdf_file_parts *parts);

#endif
