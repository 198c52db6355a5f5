/* Composed segments as a field for the mesher and for evaluation: one, or in a cross-fade two. */
#ifndef NSDF_SEGMENT_FIELD_H
#define NSDF_SEGMENT_FIELD_H

#include "block_kernels.h"
#include "field.h"
#include "segment.h"

typedef struct nsdf_segment_field {
    const nsdf_segment *segments[2]; /* composed; the second is NULL but in a cross-fade */
    float share[2];                  /* of each in the field */
    const nsdf_net_kernels *kernels;
    const nsdf_block_kernels *block_kernels;
    float *scratch;        /* of all workers, aligned to 64 bytes */
    size_t scratch_stride; /* floats from one worker's to the next one's, a multiple of 16 */
} nsdf_segment_field;

/* nsdf_field.evaluate with user = nsdf_segment_field: the sum over a segment's parts, mixed by the shares. */
void nsdf_segment_field_evaluate(void *user, uint32_t worker, size_t count, const float *const xyz[3], float *value,
                                 float *const grad[3]);

/* nsdf_field.measure; only for one segment that is a single part of blocks. */
void nsdf_segment_field_measure(void *user, uint32_t worker, size_t count, const float *const xyz[3], float enough,
                                float *value, uint8_t *exact);
/* The field for the mesher. */
nsdf_field nsdf_segment_field_view(nsdf_segment_field *field);

#endif
