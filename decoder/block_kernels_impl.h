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

TARGET static void find_nearest(const nsdf_block_place *places, uint32_t count, const float x[3][NSDF_TILE],
                                float square[restrict NSDF_TILE], uint32_t nearest[restrict NSDF_TILE]) {
    for (int p = 0; p < NSDF_TILE; p++)
        nearest[p] = count;
    for (uint32_t k = 0; k < count; k++) {
        const nsdf_block_place place = places[k];
        for (int p = 0; p < NSDF_TILE; p++) {
            const float dx = place.centre[0] - x[0][p], dy = place.centre[1] - x[1][p], dz = place.centre[2] - x[2][p];
            const float d = dx * dx + dy * dy + dz * dz;
            nearest[p] = d < square[p] ? k : nearest[p];
            square[p] = d < square[p] ? d : square[p];
        }
    }
}

TARGET static void wind(const nsdf_block_place *places, uint32_t count, const float x[3][NSDF_TILE],
                        float sum[restrict NSDF_TILE]) {
    for (int p = 0; p < NSDF_TILE; p++)
        sum[p] = 0.0f;
    for (uint32_t k = 0; k < count; k++) {
        const nsdf_block_place place = places[k];
        for (int p = 0; p < NSDF_TILE; p++) {
            const float dx = place.centre[0] - x[0][p], dy = place.centre[1] - x[1][p], dz = place.centre[2] - x[2][p];
            const float square = dx * dx + dy * dy + dz * dz + 1e-12f;
            sum[p] += (place.dipole[0] * dx + place.dipole[1] * dy + place.dipole[2] * dz) / (square * sqrtf(square));
        }
    }
}

static const nsdf_block_kernels table = {NAME, add_block, find_nearest, wind};
