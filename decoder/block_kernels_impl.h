/* Included once per instruction set with TARGET (an attribute, or nothing) and NAME defined.  Loops run over whole
 * tiles so that the compiler turns them into vectors. */
#include "block_kernels.h"
#include "block_polynomial.h"

#include <math.h>
#include <string.h>

/* `degree` is a constant where these are inlined, so that no lane asks for it. */
#define INLINE TARGET static inline __attribute__((always_inline))

typedef struct local_points {
    float u[3][NSDF_TILE];
} local_points;

TARGET static void to_ball(const float *restrict m, const float x[3][NSDF_TILE], local_points *restrict out) {
    for (int row = 0; row < 3; row++)
        for (int p = 0; p < NSDF_TILE; p++)
            out->u[row][p] =
                m[4 * row] * x[0][p] + m[4 * row + 1] * x[1][p] + m[4 * row + 2] * x[2][p] + m[4 * row + 3];
}

/* 1 - |u|^2; returns whether it is positive somewhere.  Compilers have no vectors for the greatest of floats, but for
 * whole numbers. */
TARGET static int roots(const local_points *restrict at, float root[restrict NSDF_TILE]) {
    int inside = 0;
    for (int p = 0; p < NSDF_TILE; p++) {
        const float square = at->u[0][p] * at->u[0][p] + at->u[1][p] * at->u[1][p] + at->u[2][p] * at->u[2][p];
        root[p] = 1.0f - square;
        inside |= root[p] > 0.0f;
    }
    return inside;
}

/* Values alone; of two loops, since the compiler would rather branch than select in one. */
INLINE void add_values(const nsdf_block *block, uint32_t degree, const local_points *restrict at,
                       const float root[restrict NSDF_TILE], nsdf_block_sums *restrict sums) {
    const float life = block->life;
    float t[NSDF_BLOCK_TERMS], value[NSDF_TILE];
    memcpy(t, block->terms, sizeof t);
    for (int p = 0; p < NSDF_TILE; p++) {
        const float u[3] = {at->u[0][p], at->u[1][p], at->u[2][p]};
        value[p] = nsdf_block_value(t, degree, u);
    }
    for (int p = 0; p < NSDF_TILE; p++) {
        const float weight = life * root[p] * root[p], part = weight * value[p];
        sums->weight[p] += root[p] > 0.0f ? weight : 0.0f;
        sums->value[p] += root[p] > 0.0f ? part : 0.0f;
    }
}

/* Values, and slopes with respect to x. */
INLINE void add_slopes(const nsdf_block *block, uint32_t degree, const local_points *restrict at,
                       const float root[restrict NSDF_TILE], nsdf_block_sums *restrict sums) {
    const float life = block->life;
    float t[NSDF_BLOCK_TERMS], m[12];
    memcpy(t, block->terms, sizeof t);
    memcpy(m, block->map, sizeof m);
    for (int p = 0; p < NSDF_TILE; p++) {
        const float u[3] = {at->u[0][p], at->u[1][p], at->u[2][p]}, value = nsdf_block_value(t, degree, u);
        const float weight = life * root[p] * root[p], fall = -4.0f * life * root[p];
        float slope[3];
        nsdf_block_slope(t, degree, u, slope);
        sums->weight[p] += root[p] > 0.0f ? weight : 0.0f;
        sums->value[p] += root[p] > 0.0f ? weight * value : 0.0f;
        for (int axis = 0; axis < 3; axis++) {
            /* half the slope of |u|^2 */
            const float along = m[axis] * u[0] + m[4 + axis] * u[1] + m[8 + axis] * u[2], w = fall * along;
            const float v = w * value + weight * (m[axis] * slope[0] + m[4 + axis] * slope[1] + m[8 + axis] * slope[2]);
            sums->weight_slope[axis][p] += root[p] > 0.0f ? w : 0.0f;
            sums->value_slope[axis][p] += root[p] > 0.0f ? v : 0.0f;
        }
    }
}

INLINE void add_inside(const nsdf_block *block, uint32_t degree, int slopes, const local_points *restrict at,
                       const float root[restrict NSDF_TILE], nsdf_block_sums *restrict sums) {
    if (slopes)
        add_slopes(block, degree, at, root, sums);
    else
        add_values(block, degree, at, root, sums);
}

TARGET static void add_block(const nsdf_block *block, uint32_t degree, int slopes, const float x[3][NSDF_TILE],
                             nsdf_block_sums *sums) {
    local_points at;
    float root[NSDF_TILE];
    to_ball(block->map, x, &at);
    if (!roots(&at, root))
        return;
    if (degree >= 3)
        add_inside(block, 3, slopes, &at, root, sums);
    else if (degree == 2)
        add_inside(block, 2, slopes, &at, root, sums);
    else
        add_inside(block, 1, slopes, &at, root, sums);
}

TARGET static float least_of(const float d[NSDF_BLOCK_GROUP]) {
    float half[NSDF_BLOCK_GROUP / 2];
    for (int i = 0; i < NSDF_BLOCK_GROUP / 2; i++)
        half[i] = d[i] < d[i + 8] ? d[i] : d[i + 8];
    for (int i = 0; i < 4; i++)
        half[i] = half[i] < half[i + 4] ? half[i] : half[i + 4];
    const float a = half[0] < half[2] ? half[0] : half[2], b = half[1] < half[3] ? half[1] : half[3];
    return a < b ? a : b;
}

/* Low and, negated, high. */
TARGET static void bound_points(const float x[3][NSDF_TILE], float box[2][3]) {
    for (int axis = 0; axis < 3; axis++) {
        float low[NSDF_BLOCK_GROUP], high[NSDF_BLOCK_GROUP];
        for (int i = 0; i < NSDF_BLOCK_GROUP; i++) {
            low[i] = x[axis][i];
            high[i] = -x[axis][i];
        }
        for (int p = NSDF_BLOCK_GROUP; p < NSDF_TILE; p += NSDF_BLOCK_GROUP)
            for (int i = 0; i < NSDF_BLOCK_GROUP; i++) {
                low[i] = x[axis][p + i] < low[i] ? x[axis][p + i] : low[i];
                high[i] = -x[axis][p + i] < high[i] ? -x[axis][p + i] : high[i];
            }
        box[0][axis] = least_of(low);
        box[1][axis] = least_of(high);
    }
}

/* Which of the boxes meet the points' box; returns whether any does. */
TARGET static int test_boxes(const nsdf_block_boxes *boxes, const float box[2][3], int32_t met[NSDF_BLOCK_GROUP]) {
    int32_t any = 0;
    for (int i = 0; i < NSDF_BLOCK_GROUP; i++) {
        met[i] = (boxes->low[0][i] <= -box[1][0]) & (boxes->high[0][i] >= box[0][0]) &
                 (boxes->low[1][i] <= -box[1][1]) & (boxes->high[1][i] >= box[0][1]) &
                 (boxes->low[2][i] <= -box[1][2]) & (boxes->high[2][i] >= box[0][2]);
        any |= met[i];
    }
    return any;
}

TARGET static uint32_t meet(const nsdf_block_boxes *boxes, const nsdf_block_boxes *group_boxes, uint32_t groups,
                            const float x[3][NSDF_TILE], uint32_t most, uint32_t *list) {
    int32_t group_met[NSDF_BLOCK_GROUP], met[NSDF_BLOCK_GROUP];
    float box[2][3];
    uint32_t count = 0;
    bound_points(x, box);
    for (uint32_t s = 0; s < nsdf_block_groups(groups); s++) {
        if (!test_boxes(&group_boxes[s], (const float(*)[3])box, group_met))
            continue;
        for (uint32_t i = 0; i < NSDF_BLOCK_GROUP && s * NSDF_BLOCK_GROUP + i < groups; i++) {
            const uint32_t g = s * NSDF_BLOCK_GROUP + i;
            if (!group_met[i] || !test_boxes(&boxes[g], (const float(*)[3])box, met))
                continue;
            for (uint32_t k = 0; k < NSDF_BLOCK_GROUP; k++) {
                if (met[k] && count == most)
                    return most + 1;
                if (met[k])
                    list[count++] = g * NSDF_BLOCK_GROUP + k;
            }
        }
    }
    return count;
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

static const nsdf_block_kernels table = {NAME, add_block, meet, find_nearest, wind};
