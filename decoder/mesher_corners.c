/* Evaluates corners of the active cells and follows the surface into cells that were dropped wrongly.  In rounds: the
 * bricks are looked at for edges on which the sign changes and for cells that are missing, and ask for corners; these
 * are evaluated.  Each step writes to a brick from its own and its neighbours' earlier results, all bricks at once. */
#include "mesher_internal.h"

#include <string.h>

static const uint64_t no_bits[8];

/* ---- Looking ----------------------------------------------------------------------------------------------- */

void nsdf_gather_corners(const nsdf_mesher *mesher, const uint32_t neighbours[8], nsdf_corner_rows *rows) {
    const uint64_t *known[8], *negative[8];
    for (int i = 0; i < 8; i++) {
        const nsdf_brick *brick = neighbours[i] == NSDF_NO_BRICK ? NULL : nsdf_grid_brick(mesher, neighbours[i]);
        known[i] = brick ? brick->known : no_bits;
        negative[i] = brick ? brick->negative : no_bits;
    }
    for (int z = 0; z < 9; z++) {
        for (int y = 0; y < 9; y++) {
            const int i = 2 * (y >> 3) + 4 * (z >> 3), shift = 8 * (y & 7);
            rows->known[z][y] = (uint16_t)((known[i][z & 7] >> shift & 0xff) | (known[i + 1][z & 7] >> shift & 1) << 8);
            rows->negative[z][y] =
                (uint16_t)((negative[i][z & 7] >> shift & 0xff) | (negative[i + 1][z & 7] >> shift & 1) << 8);
        }
    }
}

void nsdf_mixed_cells(const nsdf_corner_rows *rows, uint64_t cells[8]) {
    uint32_t inside[9][9], outside[9][9]; /* pairs of corners along x with one inside, with one outside */
    for (int z = 0; z < 9; z++) {
        for (int y = 0; y < 9; y++) {
            const uint32_t in = rows->negative[z][y], out = rows->known[z][y] & ~in;
            inside[z][y] = in | in >> 1;
            outside[z][y] = out | out >> 1;
        }
    }
    for (int z = 0; z < 8; z++) {
        cells[z] = 0;
        for (int y = 0; y < 8; y++) {
            const uint32_t in = inside[z][y] | inside[z][y + 1] | inside[z + 1][y] | inside[z + 1][y + 1];
            const uint32_t out = outside[z][y] | outside[z][y + 1] | outside[z + 1][y] | outside[z + 1][y + 1];
            cells[z] |= (uint64_t)(in & out & 0xff) << 8 * y;
        }
    }
}

/* Edges between known corners of different sign that start in the brick. */
static void find_edges(nsdf_brick *brick, const nsdf_corner_rows *rows) {
    for (int z = 0; z < 8; z++) {
        uint64_t edges[3] = {0, 0, 0};
        for (int y = 0; y < 8; y++) {
            const uint32_t known = rows->known[z][y], negative = rows->negative[z][y];
            const uint32_t x = (negative ^ negative >> 1) & known & known >> 1;
            const uint32_t along_y = (negative ^ rows->negative[z][y + 1]) & known & rows->known[z][y + 1];
            const uint32_t along_z = (negative ^ rows->negative[z + 1][y]) & known & rows->known[z + 1][y];
            edges[0] |= (uint64_t)(x & 0xff) << 8 * y;
            edges[1] |= (uint64_t)(along_y & 0xff) << 8 * y;
            edges[2] |= (uint64_t)(along_z & 0xff) << 8 * y;
        }
        for (int a = 0; a < 3; a++)
            brick->edges[a][z] = edges[a];
    }
}

/* Whether both signs occur among the known corners with x = 0 (if bit 0 of `side` is set), y = 0 (bit 1), z = 0
 * (bit 2). */
static int side_is_mixed(const nsdf_corner_rows *rows, uint32_t side) {
    const uint32_t mask = side & 1 ? 1 : 0x1ff;
    uint32_t in = 0, out = 0;
    for (int z = 0; z < (side & 4 ? 1 : 9); z++) {
        for (int y = 0; y < (side & 2 ? 1 : 9); y++) {
            in |= rows->negative[z][y] & mask;
            out |= rows->known[z][y] & ~rows->negative[z][y] & mask;
        }
    }
    return in && out;
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
    nsdf_corner_rows rows;
    uint64_t missing = 0;
    nsdf_grid_neighbours(mesher, index, neighbours);
    if (!is_changed(mesher, neighbours))
        return;
    nsdf_gather_corners(mesher, neighbours, &rows);
    nsdf_mixed_cells(&rows, brick->crossed);
    find_edges(brick, &rows); /* each is one of a crossed cell of the brick */
    for (int z = 0; z < 8; z++) {
        missing |= brick->crossed[z] & ~brick->cells[z];
        brick->cells[z] |= brick->crossed[z];
    }
    if (missing)
        brick->upper = nsdf_brick_upper(brick);
    for (uint32_t side = 1; side < 7; side++)
        brick->lower |= (uint8_t)(side_is_mixed(&rows, side) << side);
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
