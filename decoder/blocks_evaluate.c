/* Values and gradients of the blocks at points. */
#include "block_kernels.h"
#include "block_polynomial.h"

#include <math.h>
#include <string.h>

/* Further than any domain is long. */
static const float nowhere = 64.0f;

/* Tiles that meet more cells than this, or fewer points than that in common, go point by point. */
enum { MOST_CELLS = 64, MOST_WORDS = NSDF_MAX_BLOCKS / 64 };

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

typedef struct point_box {
    float low[3], high[3];
} point_box;

static point_box box_of(const tile *t) {
    point_box box;
    for (int axis = 0; axis < 3; axis++) {
        box.low[axis] = box.high[axis] = t->x[axis][0];
        for (int p = 1; p < NSDF_TILE; p++) {
            box.low[axis] = t->x[axis][p] < box.low[axis] ? t->x[axis][p] : box.low[axis];
            box.high[axis] = t->x[axis][p] > box.high[axis] ? t->x[axis][p] : box.high[axis];
        }
    }
    return box;
}

/* The blocks listed in the cells that the box meets, as bits; returns 0 when there are too many cells. */
static int blocks_in_box(const nsdf_blocks *b, const point_box *box, uint64_t *set) {
    uint32_t first[3], last[3], count = 1;
    for (int axis = 0; axis < 3; axis++) {
        first[axis] = cell_of(b, box->low[axis], axis);
        last[axis] = cell_of(b, box->high[axis], axis);
        count *= last[axis] - first[axis] + 1;
    }
    if (count > MOST_CELLS)
        return 0;
    memset(set, 0, (b->desc->block_count + 63) / 64 * sizeof *set);
    for (uint32_t z = first[2]; z <= last[2]; z++)
        for (uint32_t y = first[1]; y <= last[1]; y++) {
            const uint32_t *start = b->start + (z * b->cells[1] + y) * b->cells[0];
            for (uint32_t i = start[first[0]]; i < start[last[0] + 1]; i++)
                set[b->entries[i] / 64] |= (uint64_t)1 << b->entries[i] % 64;
        }
    return 1;
}

static int is_apart(const float reach[6], const point_box *box) {
    for (int axis = 0; axis < 3; axis++)
        if (reach[axis] > box->high[axis] || reach[3 + axis] < box->low[axis])
            return 1;
    return 0;
}

static uint32_t lowest_bit(uint64_t bits) {
    uint32_t n = 0;
    for (uint32_t half = 32; half > 0; half /= 2)
        if (!(bits << (64 - half))) {
            bits >>= half;
            n += half;
        }
    return n;
}

/* Blocks in ascending order, as the sums are defined. */
static void add_tile(const nsdf_blocks *b, const nsdf_block_kernels *kernels, size_t count, int slopes, tile *t) {
    uint64_t set[MOST_WORDS];
    const point_box box = box_of(t);
    memset(&t->sums, 0, sizeof t->sums);
    if (!blocks_in_box(b, &box, set)) {
        for (size_t p = 0; p < count; p++)
            add_point(b, p, slopes, t);
        return;
    }
    for (uint32_t word = 0; word < (b->desc->block_count + 63) / 64; word++)
        for (uint64_t bits = set[word]; bits; bits &= bits - 1) {
            const uint32_t k = 64 * word + lowest_bit(bits);
            if (!is_apart(b->reach[k], &box))
                kernels->add(&b->blocks[k], b->desc->degree, slopes, (const float(*)[NSDF_TILE])t->x, &t->sums);
        }
}

/* ---- Outside ----------------------------------------------------------------------------------------------- */

/* Points of a tile that no ball holds. */
typedef struct far_points {
    size_t count;
    uint32_t list[NSDF_TILE]; /* their places in the tile */
    float x[3][NSDF_TILE];
    uint32_t nearest[NSDF_TILE];
    float distance[NSDF_TILE]; /* of the nearest centre */
    float size[NSDF_TILE];     /* |f| */
} far_points;

/* |f| from the nearest centre: less than the distance to the surface, where the balls cover it. */
static void measure_far(const nsdf_blocks *b, const nsdf_block_kernels *kernels, const tile *t, far_points *far) {
    float square[NSDF_TILE];
    for (size_t i = 0; i < NSDF_TILE; i++) {
        for (int axis = 0; axis < 3; axis++)
            far->x[axis][i] = t->x[axis][far->list[i < far->count ? i : 0]];
        square[i] = nowhere * nowhere;
    }
    kernels->find_nearest(b->places, b->desc->block_count, (const float(*)[NSDF_TILE])far->x, square, far->nearest);
    for (size_t i = 0; i < far->count; i++) {
        const float d = far->distance[i] = sqrtf(square[i]);
        const float radius = far->nearest[i] < b->desc->block_count ? b->blocks[far->nearest[i]].radius : 0.0f;
        far->size[i] = d - 0.5f * radius > 0.25f * radius ? d - 0.5f * radius : 0.25f * radius;
    }
}

/* The slope of |f|: along the way from the nearest centre, 0 where |f| is at its least or no block is there. */
static void set_far_slope(const nsdf_blocks *b, const far_points *far, size_t i, float sign, tile *t) {
    const uint32_t p = far->list[i], k = far->nearest[i];
    const int slopes = k < b->desc->block_count && far->size[i] > 0.25f * b->blocks[k].radius;
    for (int axis = 0; axis < 3; axis++)
        t->slope[axis][p] = slopes ? sign * (far->x[axis][i] - b->places[k].centre[axis]) / far->distance[i] : 0.0f;
}

/* Signs tell on which side of the blocks the points are. */
static void set_far(const nsdf_blocks *b, const nsdf_block_kernels *kernels, tile *t, far_points *far) {
    float wound[NSDF_TILE];
    measure_far(b, kernels, t, far);
    kernels->wind(b->places, b->desc->block_count, (const float(*)[NSDF_TILE])far->x, wound);
    for (size_t i = 0; i < far->count; i++) {
        const float sign = wound[i] > 0.5f ? -1.0f : 1.0f;
        t->f[far->list[i]] = sign * far->size[i];
        set_far_slope(b, far, i, sign, t);
    }
}

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
    if (far.count > 0)
        set_far(blocks, kernels, &t, &far);
    for (size_t p = 0; p < count; p++) {
        value[p] += t.f[p];
        for (size_t axis = 0; gradient && axis < 3; axis++)
            gradient[axis * stride + p] += t.slope[axis][p];
    }
}

void nsdf_blocks_measure(const nsdf_blocks *blocks, const nsdf_block_kernels *kernels, size_t count, size_t stride,
                         const float *xyz, float *value) {
    tile t;
    far_points far;
    gather(count, stride, xyz, &t);
    set_near(blocks, kernels, count, 0, &t, &far);
    if (far.count > 0)
        measure_far(blocks, kernels, &t, &far);
    for (size_t i = 0; i < far.count; i++)
        t.f[far.list[i]] = far.size[i];
    memcpy(value, t.f, count * sizeof *value);
}
