/* Writing a block part. */
#ifndef NSDF_BLOCKS_WRITE_H
#define NSDF_BLOCKS_WRITE_H

#include "blocks_read.h"
#include "network_write.h"

/* Fills the tensors' shapes from block_count, bone_count, influences and degree; poses get `knots` control points,
 * coefficients of degree 0 `level_knots`; either is constant when that is 0.  Quantisers are left to the caller. */
void nsdf_blocks_layout(nsdf_blocks_desc *desc, uint32_t knots, uint32_t level_knots);

/* As nsdf_write_network_part. */
int nsdf_write_blocks_part(nsdf_buffer *payload, nsdf_blocks_desc *desc, const int32_t *q);

#endif
