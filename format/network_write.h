/* Writing a segment with a network part. */
#ifndef NSDF_NETWORK_WRITE_H
#define NSDF_NETWORK_WRITE_H

#include "container_write.h"
#include "network_read.h"

/* Quantises `count` values with w ~ offset + step * q, ties to even; q[i] in (-NSDF_MAX_QUANTISED,
 * NSDF_MAX_QUANTISED).  Returns 0, or -1 if a value is not finite or out of that range. */
int nsdf_quantise(const float *values, size_t count, float step, float offset, int32_t *q);
/* The float that every decoder gets for q: the double product and sum rounded once. */
float nsdf_dequantise(int32_t q, float step, float offset);

/* The thesis's quantiser (4.13, 4.14) with 2^bits - 1 steps from the smallest to the largest value, 1 <= bits <= 24.
 * The offset is moved to the middle level, so that q is centred.  A constant array gets step 0. */
void nsdf_minmax_quantiser(const float *values, size_t count, int bits, float *step, float *offset);

/* Appends the network part to a SEGM payload.  desc: every array's quantiser, step and offset are set by the caller;
 * predict, bits and residual_min are chosen and filled in here (the smallest of the predictions).  q: integers of
 * the uniform arrays, floats' bits for raw ones, in the order of the file, nsdf_parameter_count(desc) of them.
 * Returns 0, or -1 when memory ran out or a back end is not in this build. */
int nsdf_write_network_part(nsdf_buffer *payload, nsdf_network_desc *desc, const int32_t *q);

/* The same for any kind of part.  `write` appends the description of `desc`, whose tensors are `list`, once predictions
 * are chosen; it returns 0, or -1. */
typedef int (*nsdf_write_desc_fn)(nsdf_buffer *part, const void *desc);
int nsdf_write_part(nsdf_buffer *payload, uint16_t kind, nsdf_tensor_list *list, nsdf_write_desc_fn write,
                    const void *desc, const int32_t *q);
void nsdf_write_tensor_desc(nsdf_buffer *b, const nsdf_tensor_desc *t);

/* Begin a SEGM payload with this many parts. */
void nsdf_write_segment_start(nsdf_buffer *payload, uint32_t part_count);

#endif
