/* Signs of corners that follow from values near them.  The centres of cubes of two cells are corners with odd
 * coordinates, evaluated while cells were found; a corner that differs from one by one in n coordinates is sqrt(n)
 * cells from it, and has its sign when the value is larger than the bound allows to change on the way. */
#include "mesher_internal.h"

#include <math.h>
#include <string.h>

/* The bound is that of half diagonals of cubes, whose ends the surface seldom meets; here each corner counts. */
static const double margin = 1.1;

void nsdf_mesher_add_centre(const nsdf_mesher *mesher, uint32_t brick, const uint16_t at[3], float value) {
    nsdf_brick *b = nsdf_grid_brick(mesher, brick);
    const uint64_t bit = (uint64_t)1 << (8 * (at[1] & 7) + (at[0] & 7));
    b->evaluated[at[2] & 7] |= bit;
    b->known[at[2] & 7] |= bit;
    nsdf_grid_store(mesher, brick, at, value);
    if (mesher->job->field.jumps && !mesher->job->field.measure)
        return;
    for (int a = 0; a < 3; a++)
        if (at[a] == 0 || at[a] >= mesher->grid.cells[a])
            return;
    const double reach = margin * (double)mesher->job->bound * mesher->grid.step, size = fabs((double)value);
    for (int n = 0; n < 3 && size > reach * sqrt(n + 1); n++)
        b->far[value < 0][n][(at[2] & 7) >> 1] |= bit;
}

/* Centres of one z in a brick [0][0] and in those below it along x [0][1], y [1][0] and both. */
typedef struct quad {
    uint64_t in[2][2];
} quad;

static quad centres(const nsdf_brick *const lower[8], int inside, int n, uint32_t z) {
    quad q;
    for (int i = 0; i < 4; i++)
        q.in[i >> 1][i & 1] = lower[i]->far[inside][n][z >> 1];
    return q;
}

/* The same of the two z above and below an even one. */
static quad centres_beside(const nsdf_brick *const lower[8], int inside, int n, uint32_t z) {
    quad q;
    for (int i = 0; i < 4; i++)
        q.in[i >> 1][i & 1] = lower[i]->far[inside][n][z >> 1] |
                              (z > 0 ? lower[i]->far[inside][n][(z >> 1) - 1] : lower[i + 4]->far[inside][n][3]);
    return q;
}

/* Both neighbours along an axis; centres have odd coordinates, so that the lower neighbour is in the same brick. */
static uint64_t beside_x(uint64_t set, uint64_t lower) {
    return set >> 1 | nsdf_step_x(set, lower);
}

static uint64_t beside_y(uint64_t set, uint64_t lower) {
    return set >> 8 | nsdf_step_y(set, lower);
}

/* Neighbours of centres within their z that differ in one coordinate, in two. */
static uint64_t straight(const quad *q) {
    return beside_x(q->in[0][0], q->in[0][1]) | beside_y(q->in[0][0], q->in[1][0]);
}

static uint64_t diagonal(const quad *q) {
    return beside_y(beside_x(q->in[0][0], q->in[0][1]), beside_x(q->in[1][0], q->in[1][1]));
}

static uint64_t signs_around(const nsdf_brick *const lower[8], int inside, uint32_t z) {
    if (z & 1) {
        const quad one = centres(lower, inside, 0, z), two = centres(lower, inside, 1, z);
        return straight(&one) | diagonal(&two);
    }
    const quad one = centres_beside(lower, inside, 0, z), two = centres_beside(lower, inside, 1, z);
    const quad three = centres_beside(lower, inside, 2, z);
    return one.in[0][0] | straight(&two) | diagonal(&three);
}

/* Whether the corners of one z along an axis from a brick's first are at the grid's border, as bits. */
static uint32_t border(const nsdf_mesher *mesher, const nsdf_brick *b, int axis) {
    const uint32_t first = 8u * b->at[axis], last = mesher->grid.cells[axis];
    return (first == 0 ? 1u : 0u) | (last >= first && last - first < 8 ? 1u << (last - first) : 0u);
}

/* Corners at the border of the grid in one z: none of them counts as inside. */
static uint64_t border_corners(const nsdf_mesher *mesher, const nsdf_brick *b, uint32_t z) {
    const uint32_t x = border(mesher, b, 0), y = border(mesher, b, 1);
    uint64_t set = border(mesher, b, 2) >> z & 1 ? UINT64_MAX : x * 0x0101010101010101u;
    for (uint32_t row = 0; row < 8; row++)
        set |= y >> row & 1 ? (uint64_t)0xff << 8 * row : 0;
    return set;
}

void nsdf_mesher_claim_signs(const nsdf_mesher *mesher, uint32_t brick) {
    nsdf_brick *b = nsdf_grid_brick(mesher, brick);
    const nsdf_brick *lower[8];
    nsdf_grid_lower(mesher, brick, lower);
    for (uint32_t z = 0; z < 8; z++) {
        const uint64_t outside = signs_around(lower, 0, z) & ~b->evaluated[z];
        const uint64_t inside = signs_around(lower, 1, z) & ~b->evaluated[z];
        const uint64_t negative = inside & ~outside & ~border_corners(mesher, b, z);
        b->known[z] |= negative | (outside & ~inside);
        b->negative[z] |= negative;
    }
}
