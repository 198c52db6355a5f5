/* Reading the block part of a segment. */
#ifndef NSDF_BLOCKS_READ_H
#define NSDF_BLOCKS_READ_H

#include "network_read.h"

/* As nsdf_read_network_desc, for a block part. */
nsdf_parse nsdf_read_blocks_desc(const uint8_t *part, size_t size, nsdf_blocks_desc *desc, size_t *coded_offset,
                                 nsdf_fault *fault);

/* What the description cannot promise: bones are whole numbers below bone_count, radii and extents positive.  `values`
 * are the part's parameters. */
nsdf_parse nsdf_check_blocks(const nsdf_blocks_desc *desc, const float *values, nsdf_fault *fault);

/* Where a tensor's parameters begin among the part's. */
static inline size_t nsdf_block_offset(const nsdf_blocks_desc *desc, uint32_t tensor) {
    size_t at = 0;
    for (uint32_t t = 0; t < tensor; t++)
        at += (size_t)nsdf_array_size(&desc->list.tensors[t].arrays[0]);
    return at;
}

#endif
