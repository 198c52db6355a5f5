/* Values and gradients of the blocks at points. */
#include "block_kernels.h"
#include "block_polynomial.h"

#include <math.h>
#include <string.h>

/* Further than any domain is long. */
static const float nowhere = 64.0f;

/* Tiles that may meet more balls go point by point. */
enum { MOST_BLOCKS = 256 };

typedef struct tile {
    float x[3][NSDF_TILE], f[NSDF_TILE], slope[3][NSDF_TILE];
    nsdf_block_sums sums;
} tile;

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
static void add_point(const nsdf_blocks *b, size_t p, int slopes, tile *t) {
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

/* Blocks in ascending order, as the sums are defined. */
static void add_tile(const nsdf_blocks *b, const nsdf_block_kernels *kernels, size_t count, int slopes, tile *t) {
    uint32_t list[MOST_BLOCKS];
    const uint32_t groups = nsdf_block_groups(b->desc->block_count);
    const uint32_t met =
        kernels->meet(b->boxes, b->group_boxes, groups, (const float(*)[NSDF_TILE])t->x, MOST_BLOCKS, list);
    memset(&t->sums, 0, sizeof t->sums);
    if (met > MOST_BLOCKS) {
        for (size_t p = 0; p < count; p++)
            add_point(b, p, slopes, t);
        return;
    }
    for (uint32_t i = 0; i < met; i++)
        kernels->add(&b->blocks[list[i]], b->desc->degree, slopes, (const float(*)[NSDF_TILE])t->x, &t->sums);
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

static far_point measure_far(const nsdf_blocks *b, const nsdf_block_kernels *kernels, const tile *t, uint32_t p) {
    far_point far = {{t->x[0][p], t->x[1][p], t->x[2][p]}, 0, 0.0f, 0.0f};
    float square = nowhere * nowhere;
    far.nearest = kernels->find_nearest(b->groups, b->balls, nsdf_block_groups(b->desc->block_count), far.x, &square);
    const float d = far.distance = sqrtf(square);
    const float radius = far.nearest < b->desc->block_count ? b->blocks[far.nearest].radius : 0.0f;
    far.size = d - 0.5f * radius > 0.25f * radius ? d - 0.5f * radius : 0.25f * radius;
    return far;
}

/* The sign tells on which side of the blocks the point is.  The slope of |f| is along the way from the nearest centre,
 * 0 where |f| is at its least or no block is there. */
static void set_far(const nsdf_blocks *b, const nsdf_block_kernels *kernels, uint32_t p, tile *t) {
    const far_point far = measure_far(b, kernels, t, p);
    const float wound = kernels->wind(b->groups, nsdf_block_groups(b->desc->block_count), far.x);
    const float sign = wound > 0.5f ? -1.0f : 1.0f;
    const uint32_t k = far.nearest;
    const int slopes = k < b->desc->block_count && far.size > 0.25f * b->blocks[k].radius;
    t->f[p] = sign * far.size;
    for (int axis = 0; axis < 3; axis++)
        t->slope[axis][p] =
            slopes ? sign * (far.x[axis] - b->groups[k / NSDF_BLOCK_GROUP].centre[axis][k % NSDF_BLOCK_GROUP]) /
                         far.distance
                   : 0.0f;
}

/* Points of a tile that no ball holds. */
typedef struct far_points {
    size_t count;
    uint32_t list[NSDF_TILE]; /* their places in the tile */
} far_points;

/* Values, and slopes if wanted, at the points that some ball holds; lists the others. */
static void set_near(const nsdf_blocks *b, const nsdf_block_kernels *kernels, size_t count, int slopes, tile *t,
                     far_points *far) {
    far->count = 0;
    add_tile(b, kernels, count, slopes, t);
    for (uint32_t p = 0; p < count; p++) {
        const float weight = t->sums.weight[p], f = t->sums.value[p] / weight;
        if (!(weight > 0.0f)) {
            far->list[far->count++] = p;
            continue;
        }
        t->f[p] = f;
        for (int axis = 0; slopes && axis < 3; axis++)
            t->slope[axis][p] = (t->sums.value_slope[axis][p] - f * t->sums.weight_slope[axis][p]) / weight;
    }
}

static void gather(size_t count, size_t stride, const float *xyz, tile *t) {
    for (size_t axis = 0; axis < 3; axis++)
        for (size_t p = 0; p < NSDF_TILE; p++)
            t->x[axis][p] = xyz[axis * stride + (p < count ? p : 0)];
}

void nsdf_blocks_evaluate(const nsdf_blocks *blocks, const nsdf_block_kernels *kernels, size_t count, size_t stride,
                          const float *xyz, float *value, float *gradient) {
    tile t;
    far_points far;
    gather(count, stride, xyz, &t);
    set_near(blocks, kernels, count, gradient != NULL, &t, &far);
    for (size_t i = 0; i < far.count; i++)
        set_far(blocks, kernels, far.list[i], &t);
    for (size_t p = 0; p < count; p++) {
        value[p] += t.f[p];
        for (size_t axis = 0; gradient && axis < 3; axis++)
            gradient[axis * stride + p] += t.slope[axis][p];
    }
}

void nsdf_blocks_measure(const nsdf_blocks *blocks, const nsdf_block_kernels *kernels, size_t count, size_t stride,
                         const float *xyz, float enough, float *value, uint8_t *exact) {
    tile t;
    far_points far;
    (void)enough;
    gather(count, stride, xyz, &t);
    set_near(blocks, kernels, count, 0, &t, &far);
    memset(exact, 1, count);
    for (size_t i = 0; i < far.count; i++) {
        t.f[far.list[i]] = measure_far(blocks, kernels, &t, far.list[i]).size;
        exact[far.list[i]] = 0;
    }
    memcpy(value, t.f, count * sizeof *value);
}
