/* Included once per instruction set with TARGET (an attribute, or nothing) and NAME defined.  Loops run over whole
 * tiles so that the compiler turns them into vectors. */
#include "block_kernels.h"
#include "block_polynomial.h"

#include <math.h>

typedef struct local_points {
    float u[3][NSDF_TILE];
} local_points;

TARGET static void to_ball(const float *restrict m, const float x[3][NSDF_TILE], local_points *restrict out) {
    for (int row = 0; row < 3; row++)
        for (int p = 0; p < NSDF_TILE; p++)
            out->u[row][p] =
                m[4 * row] * x[0][p] + m[4 * row + 1] * x[1][p] + m[4 * row + 2] * x[2][p] + m[4 * row + 3];
}

/* 1 - |u|^2; returns whether it is positive somewhere. */
TARGET static int roots(const local_points *restrict at, float root[restrict NSDF_TILE]) {
    float most = 0.0f;
    for (int p = 0; p < NSDF_TILE; p++) {
        const float square = at->u[0][p] * at->u[0][p] + at->u[1][p] * at->u[1][p] + at->u[2][p] * at->u[2][p];
        root[p] = 1.0f - square;
    }
    for (int p = 0; p < NSDF_TILE; p++)
        most = root[p] > most ? root[p] : most;
    return most > 0.0f;
}

/* The polynomial, with terms in the order of nsdf_block_term. */
TARGET static void polynomials(const float *restrict t, uint32_t degree, const local_points *restrict at,
                               float value[restrict NSDF_TILE]) {
    for (int p = 0; p < NSDF_TILE; p++) {
        const float x = at->u[0][p], y = at->u[1][p], z = at->u[2][p];
        value[p] = t[0] + t[1] * x + t[2] * y + t[3] * z;
    }
    for (int p = 0; degree >= 2 && p < NSDF_TILE; p++) {
        const float x = at->u[0][p], y = at->u[1][p], z = at->u[2][p];
        value[p] += x * (t[4] * x + t[5] * y + t[6] * z) + y * (t[7] * y + t[8] * z) + z * (t[9] * z);
    }
    for (int p = 0; degree >= 3 && p < NSDF_TILE; p++) {
        const float x = at->u[0][p], y = at->u[1][p], z = at->u[2][p];
        value[p] += x * x * (t[10] * x + t[11] * y + t[12] * z) + x * (y * (t[13] * y + t[14] * z) + t[15] * z * z) +
                    y * y * (t[16] * y + t[17] * z) + z * z * (t[18] * y + t[19] * z);
    }
}

TARGET static void add_slopes(const nsdf_block *block, uint32_t degree, const local_points *restrict at,
                              const float root[restrict NSDF_TILE], const float weight[restrict NSDF_TILE],
                              const float value[restrict NSDF_TILE], nsdf_block_sums *restrict sums) {
    float map[9];
    for (int i = 0; i < 9; i++)
        map[i] = block->map[i / 3 * 4 + i % 3];
    const float *t = block->terms, life = block->life;
    for (int p = 0; p < NSDF_TILE; p++) {
        const float u[3] = {at->u[0][p], at->u[1][p], at->u[2][p]};
        float slope[3];
        nsdf_block_slope(t, degree, u, slope);
        const float inside = root[p] > 0.0f ? 1.0f : 0.0f, fall = -4.0f * life * (root[p] > 0.0f ? root[p] : 0.0f);
        for (int axis = 0; axis < 3; axis++) {
            /* half the slope of |u|^2 */
            const float along = map[axis] * u[0] + map[3 + axis] * u[1] + map[6 + axis] * u[2];
            const float w = inside > 0.0f ? fall * along : 0.0f;
            const float v =
                w * value[p] + weight[p] * (map[axis] * slope[0] + map[3 + axis] * slope[1] + map[6 + axis] * slope[2]);
            sums->weight_slope[axis][p] += w;
            sums->value_slope[axis][p] += inside > 0.0f ? v : 0.0f;
        }
    }
}

TARGET static void add_block(const nsdf_block *block, uint32_t degree, int slopes, const float x[3][NSDF_TILE],
                             nsdf_block_sums *sums) {
    local_points at;
    float root[NSDF_TILE], weight[NSDF_TILE], value[NSDF_TILE];
    to_ball(block->map, x, &at);
    if (!roots(&at, root))
        return;
    polynomials(block->terms, degree, &at, value);
    const float life = block->life;
    for (int p = 0; p < NSDF_TILE; p++) {
        weight[p] = root[p] > 0.0f ? life * root[p] * root[p] : 0.0f;
        sums->weight[p] += weight[p];
        sums->value[p] += root[p] > 0.0f ? weight[p] * value[p] : 0.0f;
    }
    if (slopes)
        add_slopes(block, degree, &at, root, weight, value, sums);
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
