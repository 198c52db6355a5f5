/* Blocks side by side, for points that no ball holds. */
#include "blocks.h"

#include <math.h>

#define NOWHERE 1e9f

void nsdf_blocks_set_place(nsdf_blocks *b, uint32_t k, const float centre[3], const float dipole[3], float reach,
                           const float box[6]) {
    nsdf_block_group *g = &b->groups[k / NSDF_BLOCK_GROUP];
    nsdf_block_boxes *boxes = &b->boxes[k / NSDF_BLOCK_GROUP];
    for (int axis = 0; axis < 3; axis++) {
        g->centre[axis][k % NSDF_BLOCK_GROUP] = centre[axis];
        g->dipole[axis][k % NSDF_BLOCK_GROUP] = dipole[axis];
        boxes->low[axis][k % NSDF_BLOCK_GROUP] = box[axis];
        boxes->high[axis][k % NSDF_BLOCK_GROUP] = box[3 + axis];
    }
    g->reach[k % NSDF_BLOCK_GROUP] = reach;
}

void nsdf_blocks_remove_place(nsdf_blocks *b, uint32_t k) {
    static const float centre[3] = {NOWHERE, NOWHERE, NOWHERE}, dipole[3] = {0.0f, 0.0f, 0.0f};
    static const float box[6] = {NOWHERE, NOWHERE, NOWHERE, -NOWHERE, -NOWHERE, -NOWHERE};
    nsdf_blocks_set_place(b, k, centre, dipole, 0.0f, box);
}

/* The middle is the mean of the centres; the radius a little larger, for rounding. */
static void bound_group(const nsdf_block_group *g, float ball[4]) {
    float sum[3] = {0.0f, 0.0f, 0.0f}, most = 0.0f, count = 0.0f;
    for (int i = 0; i < NSDF_BLOCK_GROUP; i++)
        for (int axis = 0; axis < 3 && g->centre[0][i] != NOWHERE; axis++) {
            sum[axis] += g->centre[axis][i];
            count += axis == 0 ? 1.0f : 0.0f;
        }
    for (int axis = 0; axis < 3; axis++)
        ball[axis] = count > 0.0f ? sum[axis] / count : NOWHERE;
    for (int i = 0; i < NSDF_BLOCK_GROUP; i++) {
        const float x = g->centre[0][i] - ball[0], y = g->centre[1][i] - ball[1], z = g->centre[2][i] - ball[2];
        const float square = x * x + y * y + z * z;
        most = g->centre[0][i] != NOWHERE && square > most ? square : most;
    }
    ball[3] = 1.00001f * sqrtf(most);
}

static void box_group(const nsdf_block_boxes *blocks, nsdf_block_boxes *out, uint32_t at) {
    for (int axis = 0; axis < 3; axis++) {
        float low = NOWHERE, high = -NOWHERE;
        for (int i = 0; i < NSDF_BLOCK_GROUP; i++) {
            low = blocks->low[axis][i] < low ? blocks->low[axis][i] : low;
            high = blocks->high[axis][i] > high ? blocks->high[axis][i] : high;
        }
        out->low[axis][at] = low;
        out->high[axis][at] = high;
    }
}

void nsdf_blocks_bound_group(nsdf_blocks *b, uint32_t group) {
    const uint32_t lane = group % NSDF_BLOCK_GROUP;
    nsdf_group_balls *set = &b->balls[group / NSDF_BLOCK_GROUP];
    float ball[4];
    bound_group(&b->groups[group], ball);
    for (int axis = 0; axis < 3; axis++)
        set->middle[axis][lane] = ball[axis];
    set->radius[lane] = ball[3];
    box_group(&b->boxes[group], &b->group_boxes[group / NSDF_BLOCK_GROUP], lane);
}

void nsdf_blocks_clear_groups(nsdf_blocks *b) {
    const uint32_t groups = nsdf_block_groups(b->desc->block_count), sets = nsdf_block_groups(groups);
    for (uint32_t k = 0; k < groups * NSDF_BLOCK_GROUP; k++)
        nsdf_blocks_remove_place(b, k);
    for (uint32_t i = 0; i < sets * NSDF_BLOCK_GROUP; i++) {
        nsdf_group_balls *set = &b->balls[i / NSDF_BLOCK_GROUP];
        nsdf_block_boxes *boxes = &b->group_boxes[i / NSDF_BLOCK_GROUP];
        for (int axis = 0; axis < 3; axis++) {
            set->middle[axis][i % NSDF_BLOCK_GROUP] = NOWHERE;
            boxes->low[axis][i % NSDF_BLOCK_GROUP] = NOWHERE;
            boxes->high[axis][i % NSDF_BLOCK_GROUP] = -NOWHERE;
        }
        set->radius[i % NSDF_BLOCK_GROUP] = 0.0f;
    }
}
