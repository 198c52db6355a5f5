#include "blocks_read.h"

#include <math.h>
#include <string.h>

#include "tensor_read.h"

static void read_front(nsdf_cursor *c, nsdf_blocks_desc *d) {
    d->list.entropy = nsdf_take_u8(c);
    d->degree = nsdf_take_u8(c);
    d->influences = nsdf_take_u8(c);
    nsdf_cursor_expect(c, d->list.entropy < NSDF_ENTROPY_COUNT, c->at - 3, "entropy back end above 3");
    nsdf_cursor_expect(c, d->degree <= NSDF_MAX_DEGREE, c->at - 2, "degree above 3");
    nsdf_cursor_expect(c, d->influences >= 1 && d->influences <= NSDF_MAX_INFLUENCES, c->at - 1,
                       "influences outside 1 to 8");
    d->bone_count = nsdf_take_u16(c);
    nsdf_cursor_expect(c, d->bone_count >= 1 && d->bone_count <= NSDF_MAX_BONES, c->at - 2,
                       "number of bones outside 1 to 1024");
    d->block_count = nsdf_take_u32(c);
    nsdf_cursor_expect(c, d->block_count >= 1 && d->block_count <= NSDF_MAX_BLOCKS, c->at - 4,
                       "number of blocks outside 1 to 65536");
    d->fade = nsdf_take_f32(c);
    nsdf_cursor_expect(c, d->fade >= 0.0f && d->fade <= 1.0f, c->at - 4, "fade outside 0 to 1");
}

/* Moves in time or does not; low-rank tensors have no use here. */
static void read_moving(nsdf_cursor *c, nsdf_tensor_desc *t, uint32_t rows, uint32_t cols, const char *what) {
    const size_t at = c->at;
    nsdf_read_tensor(c, t, rows, cols, 0);
    nsdf_cursor_expect(c, t->kind != NSDF_TENSOR_LOW_RANK, at, what);
}

static void read_tensors(nsdf_cursor *c, nsdf_blocks_desc *d) {
    const uint32_t k = d->block_count, b = d->bone_count;
    nsdf_tensor_desc *t = d->list.tensors;
    d->list.count = NSDF_BLOCK_COEFFICIENTS + d->degree + 1;
    nsdf_read_tensor(c, &t[NSDF_BLOCK_CENTRES], k, 3, 1);
    nsdf_read_tensor(c, &t[NSDF_BLOCK_RADII], k, 1, 1);
    nsdf_read_tensor(c, &t[NSDF_BLOCK_LIVES], k, 2, 1);
    nsdf_read_tensor(c, &t[NSDF_BLOCK_BONES], k, d->influences, 1);
    nsdf_read_tensor(c, &t[NSDF_BLOCK_WEIGHTS], k, d->influences, 1);
    nsdf_read_tensor(c, &t[NSDF_BLOCK_ANCHORS], b, 4, 1);
    read_moving(c, &t[NSDF_BLOCK_POSES], b, 12, "poses that are a low-rank tensor");
    for (uint32_t degree = 0; degree <= d->degree && c->status == NSDF_PARSE_OK; degree++)
        read_moving(c, &t[NSDF_BLOCK_COEFFICIENTS + degree], k, nsdf_degree_terms(degree),
                    "coefficients that are a low-rank tensor");
}

nsdf_parse nsdf_read_blocks_desc(const uint8_t *part, size_t size, nsdf_blocks_desc *desc, size_t *coded_offset,
                                 nsdf_fault *fault) {
    nsdf_cursor c = nsdf_cursor_start(part, size, 0);
    memset(desc, 0, sizeof *desc);
    read_front(&c, desc);
    if (c.status == NSDF_PARSE_OK)
        read_tensors(&c, desc);
    nsdf_cursor_expect(&c, nsdf_parameter_count(&desc->list) <= NSDF_MAX_PARAMETERS, c.at, "more than 2^28 parameters");
    if (c.status == NSDF_PARSE_OK)
        *coded_offset = c.at;
    return nsdf_cursor_finish(&c, fault);
}

static nsdf_parse bad_values(nsdf_fault *fault, const char *what) {
    if (fault)
        *fault = (nsdf_fault){0, what};
    return NSDF_PARSE_CORRUPT;
}

nsdf_parse nsdf_check_blocks(const nsdf_blocks_desc *desc, const float *values, nsdf_fault *fault) {
    const float *radii = values + nsdf_block_offset(desc, NSDF_BLOCK_RADII);
    const float *bones = values + nsdf_block_offset(desc, NSDF_BLOCK_BONES);
    const float *anchors = values + nsdf_block_offset(desc, NSDF_BLOCK_ANCHORS);
    for (size_t i = 0; i < desc->block_count; i++)
        if (!(radii[i] > 0.0f))
            return bad_values(fault, "a block with a radius of 0 or below");
    for (size_t i = 0; i < (size_t)desc->block_count * desc->influences; i++)
        if (!(bones[i] >= 0.0f && bones[i] < (float)desc->bone_count && bones[i] == floorf(bones[i])))
            return bad_values(fault, "a block on a bone that there is not");
    for (size_t i = 0; i < desc->bone_count; i++)
        if (!(anchors[4 * i + 3] > 0.0f))
            return bad_values(fault, "a bone with an extent of 0 or below");
    return NSDF_PARSE_OK;
}
