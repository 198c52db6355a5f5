/* Evaluation of a composed segment, tile by tile. */
#include "segment_field.h"

#include <string.h>

/* value += scale * output + offset for the whole tile; the same for the gradient without the offset. */
static void add_network(const nsdf_network *network, const nsdf_net_kernels *kernels, float *scratch, const float *xyz,
                        float *value, float *gradient) {
    float output[NSDF_TILE], slope[3 * NSDF_TILE];
    nsdf_network_evaluate(network, kernels, scratch, xyz, output, gradient ? slope : NULL);
    for (int p = 0; p < NSDF_TILE; p++)
        value[p] += network->value_scale * output[p] + network->value_offset;
    for (int p = 0; gradient && p < 3 * NSDF_TILE; p++)
        gradient[p] += network->value_scale * slope[p];
}

static void add_part(const nsdf_segment_part *part, const nsdf_segment_field *field, float *scratch, const float *xyz,
                     float *value, float *gradient) {
    if (part->kind == NSDF_PART_BLOCKS)
        nsdf_blocks_evaluate(&part->at.blocks, field->block_kernels, NSDF_TILE, NSDF_TILE, xyz, value, gradient);
    else
        add_network(&part->at.network, field->kernels, scratch, xyz, value, gradient);
}

/* The last tile of a call is filled up with copies of its first point. */
static void gather(size_t from, size_t count, const float *const xyz[3], float *tile) {
    for (int axis = 0; axis < 3; axis++) {
        float *row = tile + axis * NSDF_TILE;
        memcpy(row, xyz[axis] + from, count * sizeof *row);
        for (size_t p = count; p < NSDF_TILE; p++)
            row[p] = row[0];
    }
}

/* The sum over the parts of a segment; slope may be NULL.  Both hold what is added to. */
static void add_segment(const nsdf_segment *segment, const nsdf_segment_field *field, float *scratch, const float *tile,
                        float *sum, float *slope) {
    for (uint32_t i = 0; i < segment->part_count; i++)
        add_part(&segment->parts[i], field, scratch, tile, sum, slope);
}

/* Makes the first segment's tile that of a cross-fade.  Between fields that agree about what is inside, as those of
 * neighbouring segments do but for their errors, the mixed surface lies between the two. */
static void mix_second(const nsdf_segment_field *field, float *scratch, const float *tile, float *sum, float *slope) {
    float value[NSDF_TILE] = {0.0f}, gradient[3 * NSDF_TILE] = {0.0f};
    add_segment(field->segments[1], field, scratch, tile, value, slope ? gradient : NULL);
    for (int p = 0; p < NSDF_TILE; p++)
        sum[p] = field->share[0] * sum[p] + field->share[1] * value[p];
    for (int p = 0; slope && p < 3 * NSDF_TILE; p++)
        slope[p] = field->share[0] * slope[p] + field->share[1] * gradient[p];
}

/* One segment that is a single part of blocks, or NULL. */
static const nsdf_blocks *blocks_alone(const nsdf_segment_field *field) {
    const nsdf_segment *first = field->segments[0];
    const int alone = !field->segments[1] && first->part_count == 1 && first->parts[0].kind == NSDF_PART_BLOCKS;
    return alone ? &first->parts[0].at.blocks : NULL;
}

/* Points from number `from` on, as [3][NSDF_BLOCK_RUN]; returns how many. */
static size_t gather_run(size_t from, size_t count, const float *const xyz[3], float run[3 * NSDF_BLOCK_RUN]) {
    const size_t n = count - from < NSDF_BLOCK_RUN ? count - from : NSDF_BLOCK_RUN;
    for (int axis = 0; axis < 3; axis++)
        memcpy(run + axis * NSDF_BLOCK_RUN, xyz[axis] + from, n * sizeof *run);
    return n;
}

static void evaluate_blocks(const nsdf_segment_field *field, const nsdf_blocks *blocks, size_t count,
                            const float *const xyz[3], float *value, float *const grad[3]) {
    memset(value, 0, count * sizeof *value);
    for (size_t from = 0; from < count; from += NSDF_BLOCK_RUN) {
        float run[3 * NSDF_BLOCK_RUN], slope[3 * NSDF_BLOCK_RUN] = {0.0f};
        const size_t n = gather_run(from, count, xyz, run);
        nsdf_blocks_evaluate(blocks, field->block_kernels, n, NSDF_BLOCK_RUN, run, value + from, grad ? slope : NULL);
        for (int axis = 0; grad && axis < 3; axis++)
            memcpy(grad[axis] + from, slope + axis * NSDF_BLOCK_RUN, n * sizeof *slope);
    }
}

void nsdf_segment_field_evaluate(void *user, uint32_t worker, size_t count, const float *const xyz[3], float *value,
                                 float *const grad[3]) {
    const nsdf_segment_field *field = user;
    const nsdf_blocks *blocks = blocks_alone(field);
    /* A segment of blocks only has no scratch. */
    float *scratch = field->scratch ? field->scratch + worker * field->scratch_stride : NULL;
    const int wants_gradient = grad && grad[0];
    if (blocks) {
        evaluate_blocks(field, blocks, count, xyz, value, wants_gradient ? grad : NULL);
        return;
    }
    for (size_t from = 0; from < count; from += NSDF_TILE) {
        const size_t n = count - from < NSDF_TILE ? count - from : NSDF_TILE;
        float tile[3 * NSDF_TILE], sum[NSDF_TILE] = {0.0f}, slope[3 * NSDF_TILE] = {0.0f};
        gather(from, n, xyz, tile);
        add_segment(field->segments[0], field, scratch, tile, sum, wants_gradient ? slope : NULL);
        if (field->segments[1])
            mix_second(field, scratch, tile, sum, wants_gradient ? slope : NULL);
        memcpy(value + from, sum, n * sizeof *value);
        for (int axis = 0; wants_gradient && axis < 3; axis++)
            memcpy(grad[axis] + from, slope + axis * NSDF_TILE, n * sizeof *value);
    }
}

void nsdf_segment_field_measure(void *user, uint32_t worker, size_t count, const float *const xyz[3], float enough,
                                float *value, uint8_t *exact) {
    const nsdf_segment_field *field = user;
    (void)worker;
    for (size_t from = 0; from < count; from += NSDF_BLOCK_RUN) {
        float run[3 * NSDF_BLOCK_RUN];
        const size_t n = gather_run(from, count, xyz, run);
        nsdf_blocks_measure(blocks_alone(field), field->block_kernels, n, NSDF_BLOCK_RUN, run, enough, value + from,
                            exact + from);
    }
}

static int has_blocks(const nsdf_segment *segment) {
    for (uint32_t i = 0; segment && i < segment->part_count; i++)
        if (segment->parts[i].kind == NSDF_PART_BLOCKS)
            return 1;
    return 0;
}

nsdf_field nsdf_segment_field_view(nsdf_segment_field *field) {
    /* What is quicker than evaluation gives no signs, which a mix needs. */
    nsdf_field view = {field, nsdf_segment_field_evaluate, blocks_alone(field) ? nsdf_segment_field_measure : NULL,
                       has_blocks(field->segments[0]) || has_blocks(field->segments[1])};
    return view;
}
