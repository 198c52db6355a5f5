/* Included once per instruction set with TARGET (an attribute, or nothing), NAME, LANES and LANE_BITS(mask) defined. */
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

/* ---- Points in balls --------------------------------------------------------------------------------------- */

/* A ball around points: a middle and a radius, a little larger for rounding. */
INLINE void bound_ball(const float x[3][NSDF_BLOCK_POINTS], float ball[4]) {
    float most = 0.0f;
    for (int axis = 0; axis < 3; axis++) {
        float low = x[axis][0], high = x[axis][0];
        for (int p = 1; p < NSDF_BLOCK_POINTS; p++) {
            low = x[axis][p] < low ? x[axis][p] : low;
            high = x[axis][p] > high ? x[axis][p] : high;
        }
        ball[axis] = 0.5f * (low + high);
    }
    for (int p = 0; p < NSDF_BLOCK_POINTS; p++) {
        const float dx = x[0][p] - ball[0], dy = x[1][p] - ball[1], dz = x[2][p] - ball[2];
        const float square = dx * dx + dy * dy + dz * dz;
        most = square > most ? square : most;
    }
    ball[3] = 1.0001f * sqrtf(most) + 1e-6f;
}

/* Lists the near blocks whose balls may meet that of the points. */
INLINE uint32_t select_near(const nsdf_near_blocks *near, const float x[3][NSDF_BLOCK_POINTS], uint32_t *list) {
    float ball[4];
    uint32_t count = 0;
    bound_ball(x, ball);
    for (uint32_t first = 0; first < near->count; first += LANES) {
        const lanes dx = load(near->centre[0] + first) - ball[0], dy = load(near->centre[1] + first) - ball[1];
        const lanes dz = load(near->centre[2] + first) - ball[2], reach = load(near->reach + first) + ball[3];
        const lane_masks apart = dx * dx + dy * dy + dz * dz > reach * reach;
        for (uint32_t bits = LANE_BITS(~apart); bits; bits &= bits - 1)
            list[count++] = near->number[first + lowest(bits)];
    }
    return count;
}

typedef struct lane_sums {
    lanes weight, value, weight_slope[3], value_slope[3];
} lane_sums;

/* One block at points x; slopes only if wanted. */
INLINE void add_block(const nsdf_block *block, uint32_t degree, int slopes, const lanes x[3], lane_sums *sums) {
    const float *m = block->map, life = block->life;
    lanes u[3], slope[3];
    for (int row = 0; row < 3; row++)
        u[row] = m[4 * row] * x[0] + m[4 * row + 1] * x[1] + m[4 * row + 2] * x[2] + m[4 * row + 3];
    const lanes root = 1.0f - (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    const lane_masks inside = root > 0.0f;
    const lanes weight = life * root * root, value = nsdf_block_value(block->terms, degree, u);
    sums->weight += masked(inside, weight);
    sums->value += masked(inside, weight * value);
    if (!slopes)
        return;
    const lanes fall = -4.0f * life * root;
    nsdf_block_slope(block->terms, degree, u, slope);
    for (int axis = 0; axis < 3; axis++) {
        /* half the slope of |u|^2 */
        const lanes along = m[axis] * u[0] + m[4 + axis] * u[1] + m[8 + axis] * u[2], w = fall * along;
        const lanes v = w * value + weight * (m[axis] * slope[0] + m[4 + axis] * slope[1] + m[8 + axis] * slope[2]);
        sums->weight_slope[axis] += masked(inside, w);
        sums->value_slope[axis] += masked(inside, v);
    }
}

INLINE void sum_listed(const nsdf_block *blocks, const uint32_t *list, uint32_t count, uint32_t degree, int slopes,
                       const float x[3][NSDF_BLOCK_POINTS], nsdf_block_sums *sums) {
    for (int first = 0; first < NSDF_BLOCK_POINTS; first += LANES) {
        const lanes at[3] = {load(x[0] + first), load(x[1] + first), load(x[2] + first)};
        lane_sums s = {{0}, {0}, {{0}, {0}, {0}}, {{0}, {0}, {0}}};
        for (uint32_t i = 0; i < count; i++)
            add_block(&blocks[list[i]], degree, slopes, at, &s);
        store(sums->weight + first, s.weight);
        store(sums->value + first, s.value);
        for (int axis = 0; slopes && axis < 3; axis++) {
            store(sums->weight_slope[axis] + first, s.weight_slope[axis]);
            store(sums->value_slope[axis] + first, s.value_slope[axis]);
        }
    }
}

INLINE void sum_degree(const nsdf_block *blocks, const uint32_t *list, uint32_t count, uint32_t degree, int slopes,
                       const float x[3][NSDF_BLOCK_POINTS], nsdf_block_sums *sums) {
    if (degree >= 3)
        sum_listed(blocks, list, count, 3, slopes, x, sums);
    else if (degree == 2)
        sum_listed(blocks, list, count, 2, slopes, x, sums);
    else
        sum_listed(blocks, list, count, 1, slopes, x, sums);
}

TARGET static void sum_near(const nsdf_block *blocks, const nsdf_near_blocks *near, uint32_t degree, int slopes,
                            const float x[3][NSDF_BLOCK_POINTS], nsdf_block_sums *sums) {
    uint32_t list[NSDF_NEAR_MOST];
    const uint32_t count = select_near(near, x, list);
    if (slopes)
        sum_degree(blocks, list, count, degree, 1, x, sums);
    else
        sum_degree(blocks, list, count, degree, 0, x, sums);
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
    for (uint32_t s = 0; s < nsdf_block_groups(groups); s++) {
        for (uint32_t sets = test_boxes(&group_boxes[s], (const float(*)[3])box); sets; sets &= sets - 1) {
            const uint32_t g = s * NSDF_BLOCK_GROUP + lowest(sets);
            if (g >= groups)
                break;
            for (uint32_t met = test_boxes(&boxes[g], (const float(*)[3])box); met; met &= met - 1) {
                if (count == most)
                    return most + 1;
                list[count++] = g * NSDF_BLOCK_GROUP + lowest(met);
            }
        }
    }
    return count;
}

/* ---- Points in no ball ------------------------------------------------------------------------------------- */

TARGET static float least_of(const float d[NSDF_BLOCK_GROUP]) {
    float half[NSDF_BLOCK_GROUP / 2];
    for (int i = 0; i < NSDF_BLOCK_GROUP / 2; i++)
        half[i] = d[i] < d[i + 8] ? d[i] : d[i + 8];
    for (int i = 0; i < 4; i++)
        half[i] = half[i] < half[i + 4] ? half[i] : half[i + 4];
    const float a = half[0] < half[2] ? half[0] : half[2], b = half[1] < half[3] ? half[1] : half[3];
    return a < b ? a : b;
}

/* Distances to the middles of balls. */
TARGET static void measure_balls(const nsdf_group_balls *balls, const float x[3],
                                 float out[restrict NSDF_BLOCK_GROUP]) {
    for (int i = 0; i < NSDF_BLOCK_GROUP; i++) {
        const float dx = balls->middle[0][i] - x[0], dy = balls->middle[1][i] - x[1], dz = balls->middle[2][i] - x[2];
        out[i] = sqrtf(dx * dx + dy * dy + dz * dz);
    }
}

/* The group whose ball has the nearest middle. */
TARGET static uint32_t nearest_ball(const nsdf_group_balls *balls, uint32_t sets, const float x[3]) {
    float least[NSDF_BLOCK_GROUP];
    uint32_t set[NSDF_BLOCK_GROUP], found = 0;
    for (int i = 0; i < NSDF_BLOCK_GROUP; i++) {
        least[i] = 1e10f;
        set[i] = 0;
    }
    for (uint32_t s = 0; s < sets; s++) {
        float away[NSDF_BLOCK_GROUP];
        measure_balls(&balls[s], x, away);
        for (int i = 0; i < NSDF_BLOCK_GROUP; i++) {
            set[i] = away[i] < least[i] ? s : set[i];
            least[i] = away[i] < least[i] ? away[i] : least[i];
        }
    }
    for (uint32_t i = 1; i < NSDF_BLOCK_GROUP; i++)
        found = least[i] < least[found] ? i : found;
    return set[found] * NSDF_BLOCK_GROUP + found;
}

TARGET static void search_group(const nsdf_block_group *group, uint32_t first, const float x[3], float *square,
                                uint32_t *nearest) {
    float d[NSDF_BLOCK_GROUP];
    for (int i = 0; i < NSDF_BLOCK_GROUP; i++) {
        const float dx = group->centre[0][i] - x[0], dy = group->centre[1][i] - x[1], dz = group->centre[2][i] - x[2];
        d[i] = dx * dx + dy * dy + dz * dz;
    }
    if (!(least_of(d) < *square))
        return;
    for (int i = 0; i < NSDF_BLOCK_GROUP; i++)
        if (d[i] < *square) {
            *square = d[i];
            *nearest = first + (uint32_t)i;
        }
}

/* Groups whose balls are further away than some centre are left out. */
TARGET static uint32_t find_nearest(const nsdf_block_group *group, const nsdf_group_balls *balls, uint32_t groups,
                                    const float x[3], float *square) {
    const uint32_t sets = nsdf_block_groups(groups), probe = nearest_ball(balls, sets, x);
    uint32_t nearest = groups * NSDF_BLOCK_GROUP, unused;
    float bound = *square;
    search_group(&group[probe < groups ? probe : 0], 0, x, &bound, &unused);
    const float limit = 1.0001f * sqrtf(bound) + 1e-6f;
    for (uint32_t s = 0; s < sets; s++) {
        float spare[NSDF_BLOCK_GROUP];
        measure_balls(&balls[s], x, spare);
        for (int i = 0; i < NSDF_BLOCK_GROUP; i++)
            spare[i] -= balls[s].radius[i] + limit;
        if (least_of(spare) > 0.0f)
            continue;
        for (uint32_t i = 0; i < NSDF_BLOCK_GROUP && s * NSDF_BLOCK_GROUP + i < groups; i++)
            if (spare[i] <= 0.0f)
                search_group(&group[s * NSDF_BLOCK_GROUP + i], (s * NSDF_BLOCK_GROUP + i) * NSDF_BLOCK_GROUP, x, square,
                             &nearest);
    }
    return nearest;
}

/* Sums by places within the groups, then over the places. */
TARGET static float wind(const nsdf_block_group *group, uint32_t groups, const float x[3]) {
    float sums[NSDF_BLOCK_GROUP], sum = 0.0f;
    for (int i = 0; i < NSDF_BLOCK_GROUP; i++)
        sums[i] = 0.0f;
    for (uint32_t g = 0; g < groups; g++)
        for (int i = 0; i < NSDF_BLOCK_GROUP; i++) {
            const float dx = group[g].centre[0][i] - x[0], dy = group[g].centre[1][i] - x[1];
            const float dz = group[g].centre[2][i] - x[2], square = dx * dx + dy * dy + dz * dz + 1e-12f;
            const float flow = group[g].dipole[0][i] * dx + group[g].dipole[1][i] * dy + group[g].dipole[2][i] * dz;
            sums[i] += flow / (square * sqrtf(square));
        }
    for (int i = 0; i < NSDF_BLOCK_GROUP; i++)
        sum += sums[i];
    return sum;
}

static const nsdf_block_kernels table = {NAME, sum_near, meet, find_nearest, wind};
