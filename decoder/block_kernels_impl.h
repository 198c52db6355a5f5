/* Included once per instruction set with TARGET (an attribute, or nothing), NAME, LANES and LANE_BITS(mask) defined,
 * and where there are instructions for them ROUGH_INVERSE_ROOT(v), with a relative error of 2^-11 at most, and
 * LIST_LANES(mask, from, to) and LIST_BITS(bits, first, to), as list_lanes and list_bits below. */
#include <math.h>
#include <stdint.h>
#include <string.h>

/* `degree` is a constant where these are inlined, so that no lane asks for it. */
#define INLINE TARGET static inline __attribute__((always_inline))

/* Numbers that are worked on at once, as many as a register holds; operators of GNU C work lane by lane. */
typedef float lanes __attribute__((vector_size(4 * LANES)));
typedef int32_t lane_masks __attribute__((vector_size(4 * LANES)));

#define NSDF_POLYNOMIAL_REAL lanes
#define NSDF_POLYNOMIAL_INLINE INLINE
#include "block_kernels.h"
#include "block_polynomial.h"

INLINE lanes load(const float *from) {
    lanes v;
    memcpy(&v, from, sizeof v);
    return v;
}

INLINE void store(float *to, lanes v) {
    memcpy(to, &v, sizeof v);
}

/* Lanes that the mask has; 0 in the others. */
INLINE lanes masked(lane_masks mask, lanes v) {
    return (lanes)(mask & (lane_masks)v);
}

/* Number of the lowest bit that is set; bits != 0. */
INLINE uint32_t lowest(uint32_t bits) {
    return (uint32_t)__builtin_ctz(bits);
}

/* Stores `first` and the number of the bit for each that is set, one after another, and perhaps more up to sixteen;
 * returns how many. */
#ifndef LIST_BITS
#define LIST_BITS list_bits
INLINE uint32_t list_bits(uint32_t bits, uint32_t first, uint32_t *to) {
    uint32_t count = 0;
    for (; bits; bits &= bits - 1)
        to[count++] = first + lowest(bits);
    return count;
}
#endif

/* ---- Points in balls --------------------------------------------------------------------------------------- */

/* Four numbers, for what is done across the points. */
typedef float quad __attribute__((vector_size(16)));
typedef int32_t quad_masks __attribute__((vector_size(16)));

INLINE quad smaller(quad a, quad b) {
    const quad_masks less = a < b;
    return (quad)((less & (quad_masks)a) | (~less & (quad_masks)b));
}

/* Points for which balls are selected together: with fewer lanes the half, whose box is smaller. */
enum { SPAN = LANES > 8 ? 16 : 8 };

/* The least of the numbers of a span, times `sign`. */
INLINE float least_of(const float *x, float sign) {
    quad q[SPAN / 4], least;
    memcpy(q, x, sizeof q);
    least = sign * q[0];
    for (int i = 1; i < SPAN / 4; i++)
        least = smaller(least, sign * q[i]);
    const float one = least[0] < least[1] ? least[0] : least[1], two = least[2] < least[3] ? least[2] : least[3];
    return one < two ? one : two;
}

/* The box of points: its middle, and half of its sides, a little larger for rounding. */
INLINE void bound_span(const float *const x[3], float middle[3], float half[3]) {
    for (int axis = 0; axis < 3; axis++) {
        const float low = least_of(x[axis], 1.0f), high = -least_of(x[axis], -1.0f);
        middle[axis] = 0.5f * (low + high);
        half[axis] = 0.5001f * (high - low) + 1e-6f;
    }
}

/* Stores the numbers whose lanes the mask has, one after another, and perhaps more up to LANES; returns how many. */
#ifndef LIST_LANES
#define LIST_LANES list_lanes
INLINE uint32_t list_lanes(lane_masks mask, const uint32_t *from, uint32_t *to) {
    uint32_t count = 0;
    for (uint32_t bits = LANE_BITS(mask); bits; bits &= bits - 1)
        to[count++] = from[lowest(bits)];
    return count;
}
#endif

/* Lists the near blocks whose balls may meet the box of a span of points. */
INLINE uint32_t select_near(const nsdf_near_blocks *near, const float *const x[3], uint32_t *list) {
    float middle[3], half[3];
    uint32_t count = 0;
    bound_span(x, middle, half);
    for (uint32_t first = 0; first < near->count; first += LANES) {
        const lanes reach = load(near->reach + first);
        lanes square = {0};
        for (int axis = 0; axis < 3; axis++) {
            const lanes away = load(near->centre[axis] + first) - middle[axis];
            const lanes beyond = (lanes)((lane_masks)away & INT32_MAX) - half[axis];
            square += masked(beyond > 0.0f, beyond * beyond);
        }
        count += LIST_LANES(~(square > reach * reach), near->number + first, list + count);
    }
    return count;
}

typedef struct lane_sums {
    lanes weight, value, weight_slope[3], value_slope[3];
} lane_sums;

/* Points as seen from a ball's centre, and 1 - |u|^2 of those that the ball holds, 0 of the others. */
typedef struct lane_places {
    lanes d[3], root;
} lane_places;

INLINE void place_in_ball(const nsdf_block *block, const lanes x[3], lane_places *at) {
    for (int axis = 0; axis < 3; axis++)
        at->d[axis] = x[axis] - block->centre[axis];
    const lanes root = 1.0f - nsdf_quadratic_value(block->shape, at->d);
    at->root = masked(root > 0.0f, root);
}

/* One block at points in its ball or beyond, where all it adds is 0; slopes only if wanted. */
INLINE void add_block(const nsdf_block *block, uint32_t degree, int slopes, const lane_places *at, lane_sums *sums) {
    const float life = block->life;
    const lanes *d = at->d, root = at->root;
    const lanes weight = life * root * root, value = nsdf_block_value(block->terms, degree, d);
    lanes away[3], slope[3];
    sums->weight += weight;
    sums->value += weight * value;
    if (!slopes)
        return;
    const lanes fall = -2.0f * life * root;
    nsdf_quadratic_slope(block->shape, d, away);
    nsdf_block_slope(block->terms, degree, d, slope);
    for (int axis = 0; axis < 3; axis++) {
        const lanes w = fall * away[axis];
        sums->weight_slope[axis] += w;
        sums->value_slope[axis] += w * value + weight * slope[axis];
    }
}

INLINE void sum_list(const nsdf_block *blocks, const uint32_t *list, uint32_t count, uint32_t degree, int slopes,
                     const lanes x[3], lane_sums *sums) {
    for (uint32_t i = 0; i < count; i++) {
        lane_places at;
        place_in_ball(&blocks[list[i]], x, &at);
        add_block(&blocks[list[i]], degree, slopes, &at, sums);
    }
}

INLINE void sum_lanes(const nsdf_block *blocks, const uint32_t *list, uint32_t count, uint32_t degree, int slopes,
                      const float x[3][NSDF_BLOCK_POINTS], int first, nsdf_block_sums *sums) {
    const lanes at[3] = {load(x[0] + first), load(x[1] + first), load(x[2] + first)};
    lane_sums s = {{0}, {0}, {{0}, {0}, {0}}, {{0}, {0}, {0}}};
    sum_list(blocks, list, count, degree, slopes, at, &s);
    store(sums->weight + first, s.weight);
    store(sums->value + first, s.value);
    for (int axis = 0; slopes && axis < 3; axis++) {
        store(sums->weight_slope[axis] + first, s.weight_slope[axis]);
        store(sums->value_slope[axis] + first, s.value_slope[axis]);
    }
}

INLINE void sum_degree(const nsdf_block *blocks, const nsdf_near_blocks *near, uint32_t degree, int slopes,
                       const float x[3][NSDF_BLOCK_POINTS], nsdf_block_sums *sums) {
    for (int first = 0; first < NSDF_BLOCK_POINTS; first += SPAN) {
        uint32_t list[NSDF_NEAR_MOST + LANES];
        const float *const span[3] = {x[0] + first, x[1] + first, x[2] + first};
        const uint32_t count = select_near(near, span, list);
        for (int i = first; i < first + SPAN; i += LANES)
            sum_lanes(blocks, list, count, degree, slopes, x, i, sums);
    }
}

INLINE void sum_any_degree(const nsdf_block *blocks, const nsdf_near_blocks *near, uint32_t degree, int slopes,
                           const float x[3][NSDF_BLOCK_POINTS], nsdf_block_sums *sums) {
    if (degree >= 3)
        sum_degree(blocks, near, 3, slopes, x, sums);
    else if (degree == 2)
        sum_degree(blocks, near, 2, slopes, x, sums);
    else
        sum_degree(blocks, near, 1, slopes, x, sums);
}

TARGET static void sum_near(const nsdf_block *blocks, const nsdf_near_blocks *near, uint32_t degree, int slopes,
                            const float x[3][NSDF_BLOCK_POINTS], nsdf_block_sums *sums) {
    if (slopes)
        sum_any_degree(blocks, near, degree, 1, x, sums);
    else
        sum_any_degree(blocks, near, degree, 0, x, sums);
}

/* ---- Boxes ------------------------------------------------------------------------------------------------- */

/* Low and, negated, high, of `count` points. */
TARGET static void bound_points(const float *const x[3], size_t count, float box[2][3]) {
    for (int axis = 0; axis < 3; axis++) {
        lanes low = x[axis][0] - (lanes){0}, high = -x[axis][0] - (lanes){0};
        size_t p = 0;
        for (; p + LANES <= count; p += LANES) {
            const lanes at = load(x[axis] + p), negated = -at;
            const lane_masks lower = at < low, higher = negated < high;
            low = (lanes)((lower & (lane_masks)at) | (~lower & (lane_masks)low));
            high = (lanes)((higher & (lane_masks)negated) | (~higher & (lane_masks)high));
        }
        box[0][axis] = low[0];
        box[1][axis] = high[0];
        for (int i = 1; i < LANES; i++) {
            box[0][axis] = low[i] < box[0][axis] ? low[i] : box[0][axis];
            box[1][axis] = high[i] < box[1][axis] ? high[i] : box[1][axis];
        }
        for (; p < count; p++) {
            box[0][axis] = x[axis][p] < box[0][axis] ? x[axis][p] : box[0][axis];
            box[1][axis] = -x[axis][p] < box[1][axis] ? -x[axis][p] : box[1][axis];
        }
    }
}

/* Which of the boxes meet the points' box, as bits. */
INLINE uint32_t test_boxes(const nsdf_block_boxes *boxes, const float box[2][3]) {
    uint32_t met = 0;
    for (int first = 0; first < NSDF_BLOCK_GROUP; first += LANES) {
        lane_masks meets = load(boxes->low[0] + first) <= -box[1][0];
        meets &= load(boxes->high[0] + first) >= box[0][0];
        for (int axis = 1; axis < 3; axis++) {
            meets &= load(boxes->low[axis] + first) <= -box[1][axis];
            meets &= load(boxes->high[axis] + first) >= box[0][axis];
        }
        met |= LANE_BITS(meets) << first;
    }
    return met;
}

TARGET static uint32_t meet(const nsdf_block_boxes *boxes, const nsdf_block_boxes *group_boxes, uint32_t groups,
                            const float *const x[3], size_t points, uint32_t most, uint32_t *list) {
    float box[2][3];
    uint32_t count = 0;
    bound_points(x, points, box);
    for (uint32_t s = 0; s < groups; s += NSDF_BLOCK_GROUP) {
        uint32_t met[NSDF_BLOCK_GROUP];
        const uint32_t sets = test_boxes(&group_boxes[s / NSDF_BLOCK_GROUP], (const float(*)[3])box);
        const uint32_t n = LIST_BITS(sets, s, met);
        for (uint32_t i = 0; i < n && met[i] < groups && count <= most; i++) {
            const uint32_t bits = test_boxes(&boxes[met[i]], (const float(*)[3])box);
            count += LIST_BITS(bits, met[i] * NSDF_BLOCK_GROUP, list + count);
        }
    }
    return count <= most ? count : most + 1;
}

/* ---- Points in no ball ------------------------------------------------------------------------------------- */

/* Squared distances from x, of as many as there are lanes. */
INLINE lanes squares_from(const float *const at[3], const float x[3]) {
    const lanes dx = load(at[0]) - x[0], dy = load(at[1]) - x[1], dz = load(at[2]) - x[2];
    return dx * dx + dy * dy + dz * dz;
}

/* The least squared distance in each lane, and which block or group has it. */
typedef struct lane_nearest {
    lanes square;
    lane_masks number; /* less the lane; -1: none */
} lane_nearest;

INLINE void take_nearer(lanes square, uint32_t first, lane_nearest *near) {
    const lane_masks nearer = square < near->square;
    near->square = (lanes)((nearer & (lane_masks)square) | (~nearer & (lane_masks)near->square));
    near->number = (nearer & (int32_t)first) | (~nearer & near->number);
}

INLINE void search_group(const nsdf_block_group *group, uint32_t first, const float x[3], lane_nearest *near) {
    for (uint32_t i = 0; i < NSDF_BLOCK_GROUP; i += LANES) {
        const float *const centre[3] = {group->centre[0] + i, group->centre[1] + i, group->centre[2] + i};
        take_nearer(squares_from(centre, x), first + i, near);
    }
}

/* Of equally near ones the first. */
INLINE uint32_t first_nearest(const lane_nearest *near, uint32_t none, float *square) {
    uint32_t nearest = none;
    for (uint32_t bits = LANE_BITS(near->number >= 0); bits; bits &= bits - 1) {
        const uint32_t lane = lowest(bits), number = (uint32_t)near->number[lane] + lane;
        if (near->square[lane] < *square || (near->square[lane] == *square && number < nearest)) {
            *square = near->square[lane];
            nearest = number;
        }
    }
    return nearest;
}

/* The group whose ball has the nearest middle. */
INLINE uint32_t nearest_ball(const nsdf_group_balls *balls, uint32_t sets, const float x[3]) {
    float least = 1e20f;
    lane_nearest near = {least - (lanes){0}, (lane_masks){0} - 1};
    for (uint32_t i = 0; i < sets * NSDF_BLOCK_GROUP; i += LANES) {
        const nsdf_group_balls *set = &balls[i / NSDF_BLOCK_GROUP];
        const uint32_t lane = i % NSDF_BLOCK_GROUP;
        const float *const middle[3] = {set->middle[0] + lane, set->middle[1] + lane, set->middle[2] + lane};
        take_nearer(squares_from(middle, x), i, &near);
    }
    return first_nearest(&near, 0, &least);
}

/* Groups whose balls are further away than some centre are left out; the group with the nearest middle tells how far
 * that is, unless the caller wants only what is rather near. */
TARGET static uint32_t find_nearest(const nsdf_block_group *group, const nsdf_group_balls *balls, uint32_t groups,
                                    const float x[3], float *square) {
    const uint32_t sets = nsdf_block_groups(groups);
    lane_nearest near = {*square - (lanes){0}, (lane_masks){0} - 1};
    float bound = *square;
    if (bound > 1.0f) {
        const uint32_t probe = nearest_ball(balls, sets, x);
        lane_nearest probed = near;
        search_group(&group[probe < groups ? probe : 0], 0, x, &probed);
        (void)first_nearest(&probed, 0, &bound);
    }
    const float limit = 1.0001f * sqrtf(bound) + 1e-6f;
    for (uint32_t i = 0; i < sets * NSDF_BLOCK_GROUP; i += LANES) {
        const nsdf_group_balls *set = &balls[i / NSDF_BLOCK_GROUP];
        const uint32_t lane = i % NSDF_BLOCK_GROUP;
        const float *const middle[3] = {set->middle[0] + lane, set->middle[1] + lane, set->middle[2] + lane};
        const lanes reach = load(set->radius + lane) + limit;
        for (uint32_t bits = LANE_BITS(squares_from(middle, x) <= reach * reach); bits; bits &= bits - 1) {
            const uint32_t g = i + lowest(bits);
            if (g < groups)
                search_group(&group[g], g * NSDF_BLOCK_GROUP, x, &near);
        }
    }
    return first_nearest(&near, groups * NSDF_BLOCK_GROUP, square);
}

/* Squared distances to a box, of as many as there are lanes. */
INLINE lanes squares_to_box(const float *const at[3], const float low[3], const float high[3]) {
    lanes square = {0};
    for (int axis = 0; axis < 3; axis++) {
        const lanes x = load(at[axis]), below = low[axis] - x, above = x - high[axis];
        square += masked(below > 0.0f, below * below) + masked(above > 0.0f, above * above);
    }
    return square;
}

/* Which of sixteen places are no further from the box than `reach` and their radius (NULL: none), as bits. */
INLINE uint32_t test_reach(const float place[3][NSDF_BLOCK_GROUP], const float *radius, const float low[3],
                           const float high[3], float reach) {
    uint32_t met = 0;
    for (int first = 0; first < NSDF_BLOCK_GROUP; first += LANES) {
        const float *const at[3] = {place[0] + first, place[1] + first, place[2] + first};
        const lanes limit = radius ? load(radius + first) + reach : reach - (lanes){0};
        met |= LANE_BITS(squares_to_box(at, low, high) <= limit * limit) << first;
    }
    return met;
}

TARGET static int list_centres(const nsdf_block_group *group, const nsdf_group_balls *balls, uint32_t groups,
                               const float low[3], const float high[3], float reach, nsdf_near_blocks *list) {
    const float limit = 1.0001f * reach + 1e-6f;
    uint32_t count = 0;
    for (uint32_t s = 0; s < groups; s += NSDF_BLOCK_GROUP) {
        const nsdf_group_balls *set = &balls[s / NSDF_BLOCK_GROUP];
        uint32_t met[NSDF_BLOCK_GROUP];
        const uint32_t sets = test_reach(set->middle, set->radius, low, high, limit), n = LIST_BITS(sets, s, met);
        for (uint32_t i = 0; i < n && met[i] < groups && count <= NSDF_NEAR_MOST; i++)
            count += LIST_BITS(test_reach(group[met[i]].centre, NULL, low, high, limit), met[i] * NSDF_BLOCK_GROUP,
                               list->number + count);
    }
    list->count = count;
    return count <= NSDF_NEAR_MOST;
}

TARGET static uint32_t nearest_listed(const nsdf_near_blocks *list, uint32_t none, const float x[3], float *square) {
    lane_nearest near = {*square - (lanes){0}, (lane_masks){0} - 1};
    for (uint32_t i = 0; i < list->count; i += LANES) {
        const float *const centre[3] = {list->centre[0] + i, list->centre[1] + i, list->centre[2] + i};
        take_nearer(squares_from(centre, x), i, &near);
    }
    const uint32_t found = first_nearest(&near, NSDF_NEAR_MOST, square);
    return found < list->count ? list->number[found] : none;
}

/* The generalised winding number.  Sums by places within the groups, then over the places. */
INLINE float wind(const nsdf_block_group *group, uint32_t groups, const float x[3]) {
    float sums[NSDF_BLOCK_GROUP], sum = 0.0f;
    for (int first = 0; first < NSDF_BLOCK_GROUP; first += LANES) {
        lanes part = {0};
        for (uint32_t g = 0; g < groups; g++) {
            const nsdf_block_group *b = &group[g];
            const lanes dx = load(b->centre[0] + first) - x[0], dy = load(b->centre[1] + first) - x[1];
            const lanes dz = load(b->centre[2] + first) - x[2], square = dx * dx + dy * dy + dz * dz + 1e-12f;
            lanes root;
            for (int i = 0; i < LANES; i++)
                root[i] = sqrtf(square[i]);
            part +=
                (load(b->dipole[0] + first) * dx + load(b->dipole[1] + first) * dy + load(b->dipole[2] + first) * dz) /
                (square * root);
        }
        store(sums + first, part);
    }
    for (int i = 0; i < NSDF_BLOCK_GROUP; i++)
        sum += sums[i];
    return sum;
}

#ifdef ROUGH_INVERSE_ROOT

/* As `wind`, without quotients and roots, which take most of its time; *size: the sum of the terms' sizes. */
INLINE float wind_roughly(const nsdf_block_group *group, uint32_t groups, const float x[3], float *size) {
    lanes parts = {0}, sizes = {0};
    float sum = 0.0f;
    for (uint32_t g = 0; g < groups; g++)
        for (int i = 0; i < NSDF_BLOCK_GROUP; i += LANES) {
            const nsdf_block_group *b = &group[g];
            const lanes dx = load(b->centre[0] + i) - x[0], dy = load(b->centre[1] + i) - x[1];
            const lanes dz = load(b->centre[2] + i) - x[2];
            const lanes root = ROUGH_INVERSE_ROOT(dx * dx + dy * dy + dz * dz + 1e-12f);
            const lanes along = load(b->dipole[0] + i) * dx + load(b->dipole[1] + i) * dy + load(b->dipole[2] + i) * dz;
            const lanes term = along * (root * root * root);
            parts += term;
            sizes += (lanes)((lane_masks)term & INT32_MAX);
        }
    *size = 0.0f;
    for (int i = 0; i < LANES; i++) {
        sum += parts[i];
        *size += sizes[i];
    }
    return sum;
}

/* Terms are wrong by three times the error of the inverse root, less than 2e-3 of their size, and adding up is, here
 * and there together, by 1.2e-7 for each group: what is further from 1/2 than the margin is on the side where the
 * number is. */
TARGET static int is_wound(const nsdf_block_group *group, uint32_t groups, const float x[3]) {
    float size;
    const float roughly = wind_roughly(group, groups, x, &size) - 0.5f;
    const float margin = (2e-3f + 2e-7f * (float)groups) * (1.0f + size);
    if (roughly > margin || roughly < -margin)
        return roughly > 0.0f;
    return wind(group, groups, x) > 0.5f;
}

#else

TARGET static int is_wound(const nsdf_block_group *group, uint32_t groups, const float x[3]) {
    return wind(group, groups, x) > 0.5f;
}

#endif

static const nsdf_block_kernels table = {NAME, sum_near, meet, find_nearest, list_centres, nearest_listed, is_wound};
