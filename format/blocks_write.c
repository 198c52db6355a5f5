#include "blocks_write.h"

#include <stdlib.h>

static void lay_out(nsdf_tensor_desc *t, uint32_t rows, uint32_t cols, uint32_t knots) {
    t->kind = knots > 0 ? NSDF_TENSOR_SPLINE : NSDF_TENSOR_CONSTANT;
    t->rows = rows;
    t->cols = cols;
    t->knots = knots;
    nsdf_tensor_layout(t);
}

void nsdf_blocks_layout(nsdf_blocks_desc *desc, uint32_t knots, uint32_t level_knots) {
    const uint32_t k = desc->block_count, b = desc->bone_count;
    nsdf_tensor_desc *t = desc->list.tensors;
    desc->list.count = NSDF_BLOCK_COEFFICIENTS + desc->degree + 1;
    lay_out(&t[NSDF_BLOCK_CENTRES], k, 3, 0);
    lay_out(&t[NSDF_BLOCK_RADII], k, 1, 0);
    lay_out(&t[NSDF_BLOCK_LIVES], k, 2, 0);
    lay_out(&t[NSDF_BLOCK_BONES], k, desc->influences, 0);
    lay_out(&t[NSDF_BLOCK_WEIGHTS], k, desc->influences, 0);
    lay_out(&t[NSDF_BLOCK_ANCHORS], b, 4, 0);
    lay_out(&t[NSDF_BLOCK_POSES], b, 12, knots);
    for (uint32_t d = 0; d <= desc->degree; d++)
        lay_out(&t[NSDF_BLOCK_COEFFICIENTS + d], k, nsdf_degree_terms(d), d == 0 ? level_knots : 0);
}

/* The description is read back, as a network's is. */
static int write_desc(nsdf_buffer *b, const void *blocks) {
    const nsdf_blocks_desc *d = blocks;
    nsdf_buffer_u8(b, d->list.entropy);
    nsdf_buffer_u8(b, (uint8_t)d->degree);
    nsdf_buffer_u8(b, (uint8_t)d->influences);
    nsdf_buffer_u16(b, (uint16_t)d->bone_count);
    nsdf_buffer_u32(b, d->block_count);
    nsdf_buffer_f32(b, d->fade);
    for (uint32_t t = 0; t < d->list.count; t++)
        nsdf_write_tensor_desc(b, &d->list.tensors[t]);
    nsdf_blocks_desc *back = b->failed ? NULL : malloc(sizeof *back);
    if (!back)
        return -1;
    size_t end = 0;
    nsdf_parse status = nsdf_read_blocks_desc(b->data, b->size, back, &end, NULL);
    int same = status == NSDF_PARSE_OK && end == b->size &&
               nsdf_parameter_count(&back->list) == nsdf_parameter_count(&d->list);
    free(back);
    return same ? 0 : -1;
}

int nsdf_write_blocks_part(nsdf_buffer *payload, nsdf_blocks_desc *desc, const int32_t *q) {
    return nsdf_write_part(payload, NSDF_PART_BLOCKS, &desc->list, write_desc, desc, q);
}
