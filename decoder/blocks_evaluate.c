/* Values and gradients of the blocks at points. */
#include "block_kernels.h"
#include "block_polynomial.h"

#include <math.h>
#include <string.h>

/* Further than any domain is long. */
static const float nowhere = 64.0f;

/* Points that are worked on at once. */
typedef struct part {
    float x[3][NSDF_BLOCK_POINTS], f[NSDF_BLOCK_POINTS], slope[3][NSDF_BLOCK_POINTS];
    nsdf_block_sums sums;
} part;

static uint32_t cell_of(const nsdf_blocks *b, float x, int axis) {
    const float at = (x - b->low[axis]) * b->inverse_cell[axis];
    return !(at > 0.0f) ? 0 : at >= (float)b->cells[axis] ? b->cells[axis] - 1 : (uint32_t)at;
}

/* ---- Inside the balls -------------------------------------------------------------------------------------- */

static inline void to_ball(const nsdf_block *block, const float x[3], float u[3]) {
    const float *m = block->map;
    for (int row = 0; row < 3; row++)
        u[row] = m[4 * row] * x[0] + m[4 * row + 1] * x[1] + m[4 * row + 2] * x[2] + m[4 * row + 3];
}

static void add_slopes(const nsdf_block *block, uint32_t degree, const float u[3], float root, float weight,
                       float value, nsdf_block_sums *s, size_t p) {
    float slope[3];
    nsdf_block_slope(block->terms, degree, u, slope);
    for (int axis = 0; axis < 3; axis++) {
        const float *m = block->map + axis;
        const float along = m[0] * u[0] + m[4] * u[1] + m[8] * u[2]; /* half the slope of |u|^2 */
        const float w = -4.0f * block->life * root * along;
        s->weight_slope[axis][p] += w;
        s->value_slope[axis][p] += w * value + weight * (m[0] * slope[0] + m[4] * slope[1] + m[8] * slope[2]);
    }
}

/* Point p alone. */
static void add_point(const nsdf_blocks *b, size_t p, int slopes, part *t) {
    const float x[3] = {t->x[0][p], t->x[1][p], t->x[2][p]};
    const uint32_t degree = b->desc->degree;
    const uint32_t cell = (cell_of(b, x[2], 2) * b->cells[1] + cell_of(b, x[1], 1)) * b->cells[0] + cell_of(b, x[0], 0);
    for (uint32_t i = b->start[cell]; i < b->start[cell + 1]; i++) {
        const nsdf_block *block = &b->blocks[b->entries[i]];
        float u[3];
        to_ball(block, x, u);
        const float root = 1.0f - (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
        if (!(root > 0.0f))
            continue;
        const float weight = block->life * root * root, value = nsdf_block_value(block->terms, degree, u);
        t->sums.weight[p] += weight;
        t->sums.value[p] += weight * value;
        if (slopes)
            add_slopes(block, degree, u, root, weight, value, &t->sums, p);
    }
}

/* The blocks that may hold some of the points; returns whether there are not too many. */
static int find_near(const nsdf_blocks *b, const nsdf_block_kernels *kernels, const float *const x[3], size_t count,
                     nsdf_near_blocks *near) {
    const uint32_t groups = nsdf_block_groups(b->desc->block_count);
    const uint32_t met = kernels->meet(b->boxes, b->group_boxes, groups, x, count, NSDF_NEAR_MOST, near->number);
    if (met > NSDF_NEAR_MOST)
        return 0;
    near->count = met;
    for (uint32_t i = 0; i < met; i++) {
        const nsdf_block_group *group = &b->groups[near->number[i] / NSDF_BLOCK_GROUP];
        const uint32_t k = near->number[i] % NSDF_BLOCK_GROUP;
        for (int axis = 0; axis < 3; axis++)
            near->centre[axis][i] = group->centre[axis][k];
        near->reach[i] = group->reach[k];
    }
    for (uint32_t i = met; i % NSDF_BLOCK_GROUP != 0; i++) {
        for (int axis = 0; axis < 3; axis++)
            near->centre[axis][i] = 1e9f;
        near->reach[i] = 0.0f;
    }
    return 1;
}

/* Blocks in ascending order, as the sums are defined.  `near` is NULL where they are too many for a run of points: then
 * they may be few enough for these. */
static void add_part(const nsdf_blocks *b, const nsdf_block_kernels *kernels, const nsdf_near_blocks *near,
                     size_t count, int slopes, part *t) {
    const float *const x[3] = {t->x[0], t->x[1], t->x[2]};
    nsdf_near_blocks own;
    if (!near && find_near(b, kernels, x, count, &own))
        near = &own;
    if (near) {
        kernels->sum(b->blocks, near, b->desc->degree, slopes, (const float(*)[NSDF_BLOCK_POINTS])t->x, &t->sums);
        return;
    }
    memset(&t->sums, 0, sizeof t->sums);
    for (size_t p = 0; p < count; p++)
        add_point(b, p, slopes, t);
}

/* ---- Outside ----------------------------------------------------------------------------------------------- */

/* A point that no ball holds: |f| from the nearest centre, less than the distance to the surface where the balls cover
 * it. */
typedef struct far_point {
    float x[3];
    uint32_t nearest;
    float distance; /* of the nearest centre */
    float size;     /* |f| */
} far_point;

/* A little more than the squared distance from x to a block's centre. */
static float square_beyond(const nsdf_blocks *b, uint32_t k, const float x[3]) {
    float square = 0.0f;
    for (int axis = 0; axis < 3; axis++) {
        const float away = b->groups[k / NSDF_BLOCK_GROUP].centre[axis][k % NSDF_BLOCK_GROUP] - x[axis];
        square += away * away;
    }
    return 1.0001f * square + 1e-12f;
}

/* Where |f| is above `enough`, the size may be anything above it: no centre is then as near as that and half the
 * largest radius.  *near is a block that may be near, or block_count, and becomes the nearest one: it shortens the
 * search for the next point. */
static far_point measure_far(const nsdf_blocks *b, const nsdf_block_kernels *kernels, const part *t, uint32_t p,
                             float enough, uint32_t *near) {
    far_point far = {{t->x[0][p], t->x[1][p], t->x[2][p]}, 0, 0.0f, 0.0f};
    const float reach = enough < nowhere ? 1.0001f * (enough + 0.5f * b->largest_radius) : nowhere;
    float square = reach * reach;
    if (*near < b->desc->block_count)
        square = fminf(square, square_beyond(b, *near, far.x));
    far.nearest = kernels->find_nearest(b->groups, b->balls, nsdf_block_groups(b->desc->block_count), far.x, &square);
    if (far.nearest < b->desc->block_count)
        *near = far.nearest;
    const float d = far.distance = sqrtf(square);
    const float radius = far.nearest < b->desc->block_count ? b->blocks[far.nearest].radius : 0.0f;
    far.size = d - 0.5f * radius > 0.25f * radius ? d - 0.5f * radius : 0.25f * radius;
    return far;
}

/* The sign tells on which side of the blocks the point is.  The slope of |f| is along the way from the nearest centre,
 * 0 where |f| is at its least or no block is there. */
static void set_far(const nsdf_blocks *b, const nsdf_block_kernels *kernels, uint32_t p, part *t, uint32_t *near) {
    const far_point far = measure_far(b, kernels, t, p, nowhere, near);
    const int wound = kernels->is_wound(b->groups, nsdf_block_groups(b->desc->block_count), far.x);
    const float sign = wound ? -1.0f : 1.0f;
    const uint32_t k = far.nearest;
    const int slopes = k < b->desc->block_count && far.size > 0.25f * b->blocks[k].radius;
    t->f[p] = sign * far.size;
    for (int axis = 0; axis < 3; axis++)
        t->slope[axis][p] =
            slopes ? sign * (far.x[axis] - b->groups[k / NSDF_BLOCK_GROUP].centre[axis][k % NSDF_BLOCK_GROUP]) /
                         far.distance
                   : 0.0f;
}

/* Points of a part that no ball holds. */
typedef struct far_points {
    size_t count;
    uint32_t list[NSDF_BLOCK_POINTS]; /* their places in the part */
} far_points;

/* Values, and slopes if wanted, at the points that some ball holds; lists the others. */
static void set_near(const nsdf_blocks *b, const nsdf_block_kernels *kernels, const nsdf_near_blocks *near,
                     size_t count, int slopes, part *t, far_points *far) {
    far->count = 0;
    add_part(b, kernels, near, count, slopes, t);
    for (uint32_t p = 0; p < NSDF_BLOCK_POINTS; p++)
        t->f[p] = t->sums.value[p] / t->sums.weight[p];
    for (int axis = 0; slopes && axis < 3; axis++)
        for (uint32_t p = 0; p < NSDF_BLOCK_POINTS; p++)
            t->slope[axis][p] =
                (t->sums.value_slope[axis][p] - t->f[p] * t->sums.weight_slope[axis][p]) / t->sums.weight[p];
    for (uint32_t p = 0; p < count; p++)
        if (!(t->sums.weight[p] > 0.0f))
            far->list[far->count++] = p;
}

/* The last points of a run are followed by copies of the first one. */
static size_t gather(size_t from, size_t count, size_t stride, const float *xyz, part *t) {
    const size_t n = count - from < NSDF_BLOCK_POINTS ? count - from : NSDF_BLOCK_POINTS;
    for (size_t axis = 0; axis < 3; axis++) {
        memcpy(t->x[axis], xyz + axis * stride + from, n * sizeof(float));
        for (size_t p = n; p < NSDF_BLOCK_POINTS; p++)
            t->x[axis][p] = t->x[axis][0];
    }
    return n;
}

void nsdf_blocks_evaluate(const nsdf_blocks *blocks, const nsdf_block_kernels *kernels, size_t count, size_t stride,
                          const float *xyz, float *value, float *gradient) {
    const float *const x[3] = {xyz, xyz + stride, xyz + 2 * stride};
    nsdf_near_blocks near;
    uint32_t nearest = blocks->desc->block_count;
    const int few = find_near(blocks, kernels, x, count, &near);
    for (size_t from = 0; from < count; from += NSDF_BLOCK_POINTS) {
        part t;
        far_points far;
        const size_t n = gather(from, count, stride, xyz, &t);
        set_near(blocks, kernels, few ? &near : NULL, n, gradient != NULL, &t, &far);
        for (size_t i = 0; i < far.count; i++)
            set_far(blocks, kernels, far.list[i], &t, &nearest);
        for (size_t p = 0; p < n; p++)
            value[from + p] += t.f[p];
        for (size_t axis = 0; gradient && axis < 3; axis++)
            for (size_t p = 0; p < n; p++)
                gradient[axis * stride + from + p] += t.slope[axis][p];
    }
}

void nsdf_blocks_measure(const nsdf_blocks *blocks, const nsdf_block_kernels *kernels, size_t count, size_t stride,
                         const float *xyz, float enough, float *value, uint8_t *exact) {
    const float *const x[3] = {xyz, xyz + stride, xyz + 2 * stride};
    nsdf_near_blocks near;
    uint32_t nearest = blocks->desc->block_count;
    const int few = find_near(blocks, kernels, x, count, &near);
    memset(exact, 1, count);
    for (size_t from = 0; from < count; from += NSDF_BLOCK_POINTS) {
        part t;
        far_points far;
        const size_t n = gather(from, count, stride, xyz, &t);
        set_near(blocks, kernels, few ? &near : NULL, n, 0, &t, &far);
        for (size_t i = 0; i < far.count; i++) {
            t.f[far.list[i]] = measure_far(blocks, kernels, &t, far.list[i], enough, &nearest).size;
            exact[from + far.list[i]] = 0;
        }
        memcpy(value + from, t.f, n * sizeof *value);
    }
}
