/* Evaluates corners of the active cells and follows the surface into cells that were dropped wrongly.  In rounds: the
 * bricks are looked at for edges on which the sign changes and for cells that are missing, and ask for corners; these
 * are evaluated.  Each step writes to a brick from its own and its neighbours' earlier results, all bricks at once. */
#include "mesher_internal.h"

#include <string.h>

static const uint64_t no_bits[8];

/* ---- Looking ----------------------------------------------------------------------------------------------- */

/* The signs of a brick's corners, and of those of its upper neighbours, number dx + 2 dy + 4 dz. */
typedef struct corner_signs {
    const uint64_t *known[8], *negative[8];
} corner_signs;

static corner_signs signs_of(const nsdf_mesher *mesher, const uint32_t neighbours[8]) {
    corner_signs signs;
    for (int i = 0; i < 8; i++) {
        const nsdf_brick *brick = neighbours[i] == NSDF_NO_BRICK ? NULL : nsdf_grid_brick(mesher, neighbours[i]);
        signs.known[i] = brick ? brick->known : no_bits;
        signs.negative[i] = brick ? brick->negative : no_bits;
    }
    return signs;
}

/* Corners of z = 0 to 8 with the wanted sign, in the brick and its three neighbours in that z. */
static void corners_of_sign(const corner_signs *signs, int inside, uint32_t z, uint64_t sets[4]) {
    for (uint32_t i = 0, above = z >> 3 << 2; i < 4; i++) {
        const uint64_t negative = signs->negative[i + above][z & 7];
        sets[i] = inside ? negative : signs->known[i + above][z & 7] & ~negative;
    }
}

/* Sets of one z moved down by one along x, or y; what comes from the brick above along that axis is in `upper`. */
static uint64_t ahead_x(uint64_t set, uint64_t upper) {
    return (set >> 1 & ~NSDF_COLUMN_7) | (upper << 7 & NSDF_COLUMN_7);
}

static uint64_t ahead_y(uint64_t set, uint64_t upper) {
    return set >> 8 | upper << 56;
}

/* Cells that have a corner of that sign in the layer of corners of one z, at their upper or lower side. */
static uint64_t cells_at(const corner_signs *signs, int inside, uint32_t z) {
    uint64_t sets[4];
    corners_of_sign(signs, inside, z, sets);
    const uint64_t row = sets[0] | ahead_x(sets[0], sets[1]);
    return row | ahead_y(row, sets[2] | ahead_x(sets[2], sets[3]));
}

/* Cells that have both a negative and another known corner. */
static void find_mixed_cells(const corner_signs *signs, uint64_t cells[8]) {
    uint64_t in = cells_at(signs, 1, 0), out = cells_at(signs, 0, 0);
    for (uint32_t z = 0; z < 8; z++) {
        const uint64_t next_in = cells_at(signs, 1, z + 1), next_out = cells_at(signs, 0, z + 1);
        cells[z] = (in | next_in) & (out | next_out);
        in = next_in;
        out = next_out;
    }
}

/* Edges between known corners of different sign that start in the brick. */
static void find_edges(nsdf_brick *brick, const corner_signs *s) {
    for (uint32_t z = 0; z < 8; z++) {
        const uint64_t known = s->known[0][z], negative = s->negative[0][z];
        const uint32_t above = z < 7 ? 0 : 4;
        brick->edges[0][z] = (negative ^ ahead_x(negative, s->negative[1][z])) & known & ahead_x(known, s->known[1][z]);
        brick->edges[1][z] = (negative ^ ahead_y(negative, s->negative[2][z])) & known & ahead_y(known, s->known[2][z]);
        brick->edges[2][z] = (negative ^ s->negative[above][(z + 1) & 7]) & known & s->known[above][(z + 1) & 7];
    }
}

/* Which sides of the brick have known corners of both signs, as bits: side number n is where x = 0 (if bit 0 of n is
 * set), y = 0 (bit 1), z = 0 (bit 2), and the axes that are left go from 0 to 8. */
static uint32_t find_mixed_sides(const corner_signs *signs) {
    static const uint64_t parts[4] = {UINT64_MAX, 0x0101010101010101u, 0xff, 1};
    uint64_t all[2][8], lowest[2][8];
    uint32_t mixed = 0;
    for (int i = 0; i < 8; i++) {
        all[0][i] = all[1][i] = 0;
        for (int z = 0; z < 8; z++) {
            all[1][i] |= signs->negative[i][z];
            all[0][i] |= signs->known[i][z] & ~signs->negative[i][z];
        }
        lowest[1][i] = signs->negative[i][0];
        lowest[0][i] = signs->known[i][0] & ~signs->negative[i][0];
    }
    for (uint32_t side = 1; side < 7; side++) {
        uint64_t found[2] = {0, 0};
        for (uint32_t i = 0; i < 8; i++)
            for (int sign = 0; !(i & side) && sign < 2; sign++)
                found[sign] |= ((side | i) & 4 ? lowest : all)[sign][i] & parts[(side | i) & 3];
        mixed |= (uint32_t)(found[0] && found[1]) << side;
    }
    return mixed;
}

/* Whether corners around its cells became known since the brick was looked at. */
static int is_changed(const nsdf_mesher *mesher, const uint32_t neighbours[8]) {
    for (int i = 0; i < 8; i++)
        if (neighbours[i] != NSDF_NO_BRICK && nsdf_grid_brick(mesher, neighbours[i])->fresh)
            return 1;
    return 0;
}

/* Crossed cells become active; those of the bricks below may have the surface in them too: makes those bricks, which
 * are looked at in the next round. */
static void look_at(const nsdf_mesher *mesher, uint32_t index) {
    nsdf_brick *brick = nsdf_grid_brick(mesher, index);
    uint32_t neighbours[8];
    uint64_t missing = 0;
    nsdf_grid_neighbours(mesher, index, neighbours);
    if (!is_changed(mesher, neighbours))
        return;
    const corner_signs signs = signs_of(mesher, neighbours);
    find_mixed_cells(&signs, brick->crossed);
    find_edges(brick, &signs); /* each is one of a crossed cell of the brick */
    for (int z = 0; z < 8; z++) {
        missing |= brick->crossed[z] & ~brick->cells[z];
        brick->cells[z] |= brick->crossed[z];
    }
    if (missing)
        brick->upper = nsdf_brick_upper(brick);
    brick->lower |= (uint8_t)find_mixed_sides(&signs);
}

/* ---- Asking ------------------------------------------------------------------------------------------------ */

/* In one z of a brick, corners of cells of that z, also of those in the bricks below along x and y: of the active ones,
 * or of those that are crossed. */
static uint64_t corners_of_cells(const nsdf_brick *const lower[4], int crossed, uint32_t z) {
    uint64_t cells[4];
    for (int i = 0; i < 4; i++)
        cells[i] = crossed ? lower[i]->crossed[z] : lower[i]->cells[z];
    const uint64_t row = cells[0] | nsdf_step_x(cells[0], cells[1]);
    return row | nsdf_step_y(row, cells[2] | nsdf_step_x(cells[2], cells[3]));
}

/* Corners whose sign is not known, and those of crossed cells whose value is not. */
static void ask_for(const nsdf_mesher *mesher, uint32_t index) {
    nsdf_brick *brick = nsdf_grid_brick(mesher, index);
    const nsdf_brick *lower[8];
    nsdf_grid_lower(mesher, index, lower);
    uint64_t active_below = corners_of_cells(lower + 4, 0, 7), crossed_below = corners_of_cells(lower + 4, 1, 7);
    brick->point_count = 0;
    for (uint32_t z = 0; z < 8; z++) {
        const uint64_t active = corners_of_cells(lower, 0, z), crossed = corners_of_cells(lower, 1, z);
        brick->wanted[z] =
            ((active | active_below) & ~brick->known[z]) | ((crossed | crossed_below) & ~brick->evaluated[z]);
        brick->point_count += nsdf_mesher_popcount(brick->wanted[z]);
        active_below = active;
        crossed_below = crossed;
    }
}

static nsdf_status reserve_points(nsdf_mesher *mesher) {
    mesher->point_count = 0;
    for (uint32_t i = 0; i < mesher->brick_count; i++) {
        nsdf_brick *brick = nsdf_grid_brick(mesher, i);
        if (mesher->point_count > UINT32_MAX)
            return NSDF_LIMIT;
        brick->first_point = (uint32_t)mesher->point_count;
        mesher->point_count += brick->point_count;
    }
    return nsdf_mesher_reserve(mesher, &mesher->points, mesher->point_count, 0, sizeof(nsdf_grid_point));
}

/* Calls of a brick's corners that are wanted; points that follow each other lie near each other. */
static void list_points(const nsdf_mesher *mesher, uint32_t index) {
    nsdf_brick *brick = nsdf_grid_brick(mesher, index);
    nsdf_grid_point *point = (nsdf_grid_point *)mesher->points.data + brick->first_point;
    brick->fresh = brick->point_count > 0 || index >= mesher->looked_at;
    if (brick->point_count == 0)
        return;
    for (uint32_t part = 0; part < 8; part++) {
        const uint64_t columns = nsdf_part_columns(part);
        for (uint32_t z = part >> 2 << 2, end = z + 4; z < end; z++) {
            for (uint64_t bits = brick->wanted[z] & columns; bits; bits &= bits - 1, point++) {
                const uint32_t bit = nsdf_mesher_lowest(bits);
                point->at[0] = (uint16_t)(8u * brick->at[0] + (bit & 7));
                point->at[1] = (uint16_t)(8u * brick->at[1] + (bit >> 3));
                point->at[2] = (uint16_t)(8u * brick->at[2] + z);
            }
        }
    }
    for (int z = 0; z < 8; z++) {
        brick->evaluated[z] |= brick->wanted[z];
        brick->known[z] |= brick->wanted[z];
    }
}

static void store_points(const nsdf_mesher *mesher, uint32_t index) {
    const nsdf_brick *brick = nsdf_grid_brick(mesher, index);
    const nsdf_grid_point *points = (const nsdf_grid_point *)mesher->points.data + brick->first_point;
    const float *values = (const float *)mesher->point_values.data + brick->first_point;
    for (uint32_t i = 0; i < brick->point_count; i++)
        nsdf_grid_store(mesher, index, points[i].at, values[i]);
}

/* ---- Rounds ------------------------------------------------------------------------------------------------ */

typedef void brick_step(const nsdf_mesher *mesher, uint32_t index);

static void run_step(const nsdf_mesher *mesher, uint32_t task, brick_step *step) {
    const uint32_t first = task * NSDF_BRICKS_PER_TASK;
    const uint32_t count = nsdf_min_u32(mesher->brick_count - first, NSDF_BRICKS_PER_TASK);
    for (uint32_t i = first; i < first + count; i++)
        step(mesher, i);
}

static void claim_bricks(void *data, uint32_t task, uint32_t worker) {
    (void)worker;
    run_step(data, task, nsdf_mesher_claim_signs);
}

static void look_at_bricks(void *data, uint32_t task, uint32_t worker) {
    (void)worker;
    run_step(data, task, look_at);
}

static void ask_for_bricks(void *data, uint32_t task, uint32_t worker) {
    (void)worker;
    run_step(data, task, ask_for);
}

static void list_bricks(void *data, uint32_t task, uint32_t worker) {
    (void)worker;
    run_step(data, task, list_points);
}

static void store_bricks(void *data, uint32_t task, uint32_t worker) {
    (void)worker;
    run_step(data, task, store_points);
}

static nsdf_status ask_for_corners(nsdf_mesher *mesher) {
    mesher->looked_at = mesher->brick_count;
    nsdf_status status = nsdf_mesher_for_bricks(mesher, look_at_bricks);
    if (status == NSDF_OK)
        status = nsdf_grid_need_neighbours(mesher);
    if (status == NSDF_OK)
        status = nsdf_mesher_for_bricks(mesher, ask_for_bricks);
    if (status == NSDF_OK)
        status = reserve_points(mesher);
    return status == NSDF_OK ? nsdf_mesher_for_bricks(mesher, list_bricks) : status;
}

nsdf_status nsdf_mesher_evaluate_corners(nsdf_mesher *mesher) {
    nsdf_status status = nsdf_mesher_for_bricks(mesher, claim_bricks);
    while (status == NSDF_OK) {
        status = ask_for_corners(mesher);
        if (status != NSDF_OK || (mesher->point_count == 0 && mesher->brick_count == mesher->looked_at))
            break;
        status = nsdf_grid_evaluate_points(mesher);
        if (status == NSDF_OK)
            status = nsdf_mesher_for_bricks(mesher, store_bricks);
    }
    return status;
}
