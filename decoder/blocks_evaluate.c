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

/* ---- Inside the balls -------------------------------------------------------------------------------------- */

static void add_slopes(const nsdf_block *block, uint32_t degree, const float d[3], float root, float weight,
                       float value, nsdf_block_sums *s, size_t p) {
    const float fall = -2.0f * block->life * root;
    float away[3], slope[3];
    nsdf_quadratic_slope(block->shape, d, away);
    nsdf_block_slope(block->terms, degree, d, slope);
    for (int axis = 0; axis < 3; axis++) {
        const float w = fall * away[axis];
        s->weight_slope[axis][p] += w;
        s->value_slope[axis][p] += w * value + weight * slope[axis];
    }
}

static void add_ball(const nsdf_block *block, uint32_t degree, const float x[3], int slopes, size_t p,
                     nsdf_block_sums *sums) {
    const float d[3] = {x[0] - block->centre[0], x[1] - block->centre[1], x[2] - block->centre[2]};
    const float root = 1.0f - nsdf_quadratic_value(block->shape, d);
    if (!(root > 0.0f))
        return;
    const float weight = block->life * root * root, value = nsdf_block_value(block->terms, degree, d);
    sums->weight[p] += weight;
    sums->value[p] += weight * value;
    if (slopes)
        add_slopes(block, degree, d, root, weight, value, sums, p);
}

void nsdf_blocks_describe(const nsdf_blocks *b, nsdf_near_blocks *near) {
    uint32_t i = 0;
    for (; i < near->count; i++) {
        const nsdf_block_group *group = &b->groups[near->number[i] / NSDF_BLOCK_GROUP];
        const uint32_t k = near->number[i] % NSDF_BLOCK_GROUP;
        for (int axis = 0; axis < 3; axis++)
            near->centre[axis][i] = group->centre[axis][k];
        near->reach[i] = group->reach[k];
    }
    for (; i % NSDF_BLOCK_GROUP != 0; i++) {
        for (int axis = 0; axis < 3; axis++)
            near->centre[axis][i] = 1e9f;
        near->reach[i] = 0.0f;
    }
}

/* The blocks that may hold some of the points; returns whether there are not too many. */
static int find_near(const nsdf_blocks *b, const nsdf_block_kernels *kernels, const float *const x[3], size_t count,
                     nsdf_near_blocks *near) {
    const uint32_t groups = nsdf_block_groups(b->desc->block_count);
    near->count = kernels->meet(b->boxes, b->group_boxes, groups, x, count, NSDF_NEAR_MOST, near->number);
    if (near->count > NSDF_NEAR_MOST)
        return 0;
    nsdf_blocks_describe(b, near);
    return 1;
}

/* Point p alone: of the blocks in the boxes that hold it, or of all where those are too many as well. */
static void add_point(const nsdf_blocks *b, const nsdf_block_kernels *kernels, size_t p, int slopes, part *t) {
    const float *const at[3] = {&t->x[0][p], &t->x[1][p], &t->x[2][p]}, x[3] = {*at[0], *at[1], *at[2]};
    const uint32_t degree = b->desc->degree;
    nsdf_near_blocks own;
    if (find_near(b, kernels, at, 1, &own)) {
        for (uint32_t i = 0; i < own.count; i++)
            add_ball(&b->blocks[own.number[i]], degree, x, slopes, p, &t->sums);
        return;
    }
    for (uint32_t k = 0; k < b->desc->block_count; k++)
        if (b->blocks[k].radius > 0.0f)
            add_ball(&b->blocks[k], degree, x, slopes, p, &t->sums);
}

/* Blocks in ascending order, as the sums are defined.  `near` is NULL where they are too many for a run of points: then
 * they may be few enough for these, or for each. */
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
        add_point(b, kernels, p, slopes, t);
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

/* Points of a part that no ball holds. */
typedef struct far_points {
    size_t count;
    uint32_t list[NSDF_BLOCK_POINTS]; /* their places in the part */
} far_points;

/* A little more than the squared distance from x to a block's centre. */
static float square_beyond(const nsdf_blocks *b, uint32_t k, const float x[3]) {
    float square = 0.0f;
    for (int axis = 0; axis < 3; axis++) {
        const float away = b->groups[k / NSDF_BLOCK_GROUP].centre[axis][k % NSDF_BLOCK_GROUP] - x[axis];
        square += away * away;
    }
    return 1.0001f * square + 1e-12f;
}

/* The search for the nearest centres of far points. */
typedef struct far_search {
    const nsdf_blocks *blocks;
    const nsdf_block_kernels *kernels;
    float reach;             /* centres that are further away need not be found */
    uint32_t near;           /* a block that may be near, or block_count: shortens the search */
    nsdf_near_blocks listed; /* of one part, if has_list: blocks among which the nearest ones are */
    int has_list;
} far_search;

/* Where |f| is above `enough`, its size may be anything above that: no centre is then as near as that and half the
 * largest radius. */
static void begin_search(const nsdf_blocks *b, const nsdf_block_kernels *kernels, float enough, far_search *s) {
    s->blocks = b;
    s->kernels = kernels;
    s->reach = enough < nowhere ? 1.0001f * (enough + 0.5f * b->largest_radius) : nowhere;
    s->near = b->desc->block_count;
}

/* Lists what may be nearest to the far points from number `first` on, if that is worth it: when there are several, and
 * it is known how far the search has to go. */
static void list_nearest(far_search *s, const part *t, const far_points *far, size_t first) {
    const nsdf_blocks *b = s->blocks;
    float low[3], high[3], square = 0.0f;
    s->has_list = 0;
    if (far->count - first < 2 || (s->near == b->desc->block_count && !(s->reach < nowhere)))
        return;
    for (size_t i = first; i < far->count; i++) {
        const uint32_t p = far->list[i];
        const float x[3] = {t->x[0][p], t->x[1][p], t->x[2][p]};
        for (int axis = 0; axis < 3; axis++) {
            low[axis] = i == first || x[axis] < low[axis] ? x[axis] : low[axis];
            high[axis] = i == first || x[axis] > high[axis] ? x[axis] : high[axis];
        }
        square = fmaxf(square, s->near < b->desc->block_count ? square_beyond(b, s->near, x) : nowhere * nowhere);
    }
    s->has_list = s->kernels->list_centres(b->groups, b->balls, nsdf_block_groups(b->desc->block_count), low, high,
                                           fminf(s->reach, sqrtf(square)), &s->listed);
    if (s->has_list)
        nsdf_blocks_describe(b, &s->listed);
}

static far_point measure_far(far_search *s, const part *t, uint32_t p) {
    const nsdf_blocks *b = s->blocks;
    const uint32_t groups = nsdf_block_groups(b->desc->block_count), none = groups * NSDF_BLOCK_GROUP;
    far_point far = {{t->x[0][p], t->x[1][p], t->x[2][p]}, 0, 0.0f, 0.0f};
    float square = s->reach * s->reach;
    if (s->near < b->desc->block_count)
        square = fminf(square, square_beyond(b, s->near, far.x));
    far.nearest = s->has_list ? s->kernels->nearest_listed(&s->listed, none, far.x, &square)
                              : s->kernels->find_nearest(b->groups, b->balls, groups, far.x, &square);
    if (far.nearest < b->desc->block_count)
        s->near = far.nearest;
    const float d = far.distance = sqrtf(square);
    const float radius = far.nearest < b->desc->block_count ? b->blocks[far.nearest].radius : 0.0f;
    far.size = d - 0.5f * radius > 0.25f * radius ? d - 0.5f * radius : 0.25f * radius;
    return far;
}

/* The sign tells on which side of the blocks the point is.  The slope of |f| is along the way from the nearest centre,
 * 0 where |f| is at its least or no block is there. */
static void set_far(far_search *s, uint32_t p, part *t) {
    const nsdf_blocks *b = s->blocks;
    const far_point far = measure_far(s, t, p);
    const int wound = s->kernels->is_wound(b->groups, nsdf_block_groups(b->desc->block_count), far.x);
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
    far_search search;
    const int few = find_near(blocks, kernels, x, count, &near);
    begin_search(blocks, kernels, nowhere, &search);
    for (size_t from = 0; from < count; from += NSDF_BLOCK_POINTS) {
        part t;
        far_points far;
        const size_t n = gather(from, count, stride, xyz, &t);
        set_near(blocks, kernels, few ? &near : NULL, n, gradient != NULL, &t, &far);
        for (size_t i = 0; i < far.count; i++) {
            if (i == 0 || (i == 1 && !search.has_list))
                list_nearest(&search, &t, &far, i);
            set_far(&search, far.list[i], &t);
        }
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
    far_search search;
    const int few = find_near(blocks, kernels, x, count, &near);
    begin_search(blocks, kernels, enough, &search);
    memset(exact, 1, count);
    for (size_t from = 0; from < count; from += NSDF_BLOCK_POINTS) {
        part t;
        far_points far;
        const size_t n = gather(from, count, stride, xyz, &t);
        set_near(blocks, kernels, few ? &near : NULL, n, 0, &t, &far);
        for (size_t i = 0; i < far.count; i++) {
            if (i == 0)
                list_nearest(&search, &t, &far, 0);
            t.f[far.list[i]] = measure_far(&search, &t, far.list[i]).size;
            exact[from + far.list[i]] = 0;
        }
        memcpy(value + from, t.f, n * sizeof *value);
    }
}
