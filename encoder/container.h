/* From fitted parameters to the bytes of a file. */
#ifndef NSDF_CONTAINER_H
#define NSDF_CONTAINER_H

#include "container_write.h"
#include "model.h"

/* A coded segment: the payload of its chunk, and the hash of its dequantised parameters. */
typedef struct nsdf_coded_segment {
    nsdf_buffer payload;
    uint64_t hash;
} nsdf_coded_segment;

/* Codes a model whose quantisers are chosen.  Returns 0; -1 when memory ran out or a value cannot be represented. */
int nsdf_code_segment(nsdf_model *model, const float *parameters, nsdf_coded_segment *segment);

/* Builds a file of one segment that covers all frames; lead, trail and smallest_piece are those of `entry`.  quality
 * may be NULL.  Returns 0, or -1 when memory ran out. */
int nsdf_assemble_file(const nsdf_file_header *header, const nsdf_index_entry *entry, const nsdf_coded_segment *segment,
                       const nsdf_quality_record *quality, nsdf_buffer *file);

#endif
