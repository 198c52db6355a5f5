/* Evaluates the corners of the active cells and follows the surface into cells that were dropped wrongly. */
#include "mesher_internal.h"

#include <string.h>

static const uint64_t no_bits[8];

static nsdf_brick *brick_at(const nsdf_mesher *mesher, uint32_t index) {
    return (nsdf_brick *)mesher->bricks.data + index;
}

/* ---- Asking for corners ------------------------------------------------------------------------------------ */

/* Puts those of the corners that are not known yet into the list of points. */
static nsdf_status request_corners(nsdf_mesher *mesher, uint32_t index, const uint64_t corners[8]) {
    nsdf_brick *brick = brick_at(mesher, index);
    uint64_t wanted = 0;
    for (int z = 0; z < 8; z++)
        wanted += nsdf_mesher_popcount(corners[z] & ~brick->known[z]);
    if (wanted == 0)
        return NSDF_OK;
    const nsdf_status status = nsdf_mesher_reserve(mesher, &mesher->points, mesher->point_count + wanted,
                                                   mesher->point_count, sizeof(nsdf_grid_point));
    if (status != NSDF_OK)
        return status;
    nsdf_grid_point *point = (nsdf_grid_point *)mesher->points.data + mesher->point_count;
    for (uint32_t z = 0; z < 8; z++) {
        for (uint64_t bits = corners[z] & ~brick->known[z]; bits; bits &= bits - 1, point++) {
            const uint32_t bit = nsdf_mesher_lowest(bits);
            point->at[0] = (uint16_t)(8u * brick->at[0] + (bit & 7));
            point->at[1] = (uint16_t)(8u * brick->at[1] + (bit >> 3));
            point->at[2] = (uint16_t)(8u * brick->at[2] + z);
            point->local = (uint16_t)(64 * z + bit);
            point->brick = index;
        }
        brick->known[z] |= corners[z];
    }
    mesher->point_count += wanted;
    brick->fresh = 1;
    return NSDF_OK;
}

/* Corners of a brick's active cells as rows of 9 bits. */
static void corners_of_cells(const nsdf_brick *brick, uint16_t rows[9][9]) {
    memset(rows, 0, 81 * sizeof **rows);
    for (int z = 0; z < 8; z++) {
        for (int y = 0; y < 8; y++) {
            const uint32_t cells = (uint32_t)(brick->cells[z] >> 8 * y & 0xff);
            const uint16_t corners = (uint16_t)(cells | cells << 1);
            rows[z][y] |= corners;
            rows[z][y + 1] |= corners;
            rows[z + 1][y] |= corners;
            rows[z + 1][y + 1] |= corners;
        }
    }
}

/* The part of the rows that belongs to neighbour dx + 2 dy + 4 dz; returns whether there is any. */
static int corners_of_neighbour(uint16_t rows[9][9], uint32_t neighbour, uint64_t corners[8]) {
    const uint32_t x = (neighbour & 1) * 8, y_first = (neighbour >> 1 & 1) * 8, z_first = (neighbour >> 2) * 8;
    uint64_t any = 0;
    memset(corners, 0, 8 * sizeof *corners);
    for (uint32_t z = z_first; z < (z_first ? 9 : 8); z++)
        for (uint32_t y = y_first; y < (y_first ? 9 : 8); y++)
            corners[z & 7] |= (uint64_t)(rows[z][y] >> x & 0xff) << 8 * (y & 7);
    for (int z = 0; z < 8; z++)
        any |= corners[z];
    return any != 0;
}

static nsdf_status request_cells(nsdf_mesher *mesher, uint32_t index) {
    uint16_t rows[9][9];
    uint64_t corners[8];
    corners_of_cells(brick_at(mesher, index), rows);
    for (uint32_t i = 0; i < 8; i++) {
        if (!corners_of_neighbour(rows, i, corners))
            continue;
        const uint16_t *at = brick_at(mesher, index)->at;
        uint32_t owner;
        nsdf_status status =
            nsdf_grid_need_brick(mesher, at[0] + (i & 1), at[1] + (i >> 1 & 1), at[2] + (i >> 2), &owner);
        if (status == NSDF_OK)
            status = request_corners(mesher, owner, corners);
        if (status != NSDF_OK)
            return status;
    }
    return NSDF_OK;
}

/* ---- Values ------------------------------------------------------------------------------------------------ */

/* A brick's cells have corners in the bricks at its upper faces, so a change here concerns those below. */
static void mark_for_check(nsdf_mesher *mesher, const nsdf_brick *brick) {
    for (uint32_t i = 0; i < 8; i++) {
        const uint32_t dx = i & 1, dy = i >> 1 & 1, dz = i >> 2;
        if (brick->at[0] < dx || brick->at[1] < dy || brick->at[2] < dz)
            continue;
        const uint32_t lower = nsdf_grid_brick_at(mesher, brick->at[0] - dx, brick->at[1] - dy, brick->at[2] - dz);
        if (lower != NSDF_NO_BRICK)
            brick_at(mesher, lower)->check = 1;
    }
}

static nsdf_status update_signs(nsdf_mesher *mesher) {
    nsdf_status status = NSDF_OK;
    for (uint32_t index = 0; index < mesher->brick_count && status == NSDF_OK; index++) {
        status = nsdf_mesher_ask(mesher, index, 512);
        nsdf_brick *brick = brick_at(mesher, index);
        if (!brick->fresh)
            continue;
        const float *value = (const float *)mesher->values.data + (size_t)index * NSDF_BRICK_CORNERS;
        for (int z = 0; z < 8; z++, value += 64) {
            uint64_t negative = 0;
            for (int i = 0; i < 64; i++)
                negative |= (uint64_t)(value[i] < 0) << i;
            brick->negative[z] = negative & brick->known[z];
        }
        brick->fresh = 0;
        mark_for_check(mesher, brick);
    }
    return status;
}

static nsdf_status evaluate_requested(nsdf_mesher *mesher) {
    nsdf_status status = nsdf_grid_evaluate_points(mesher);
    const nsdf_grid_point *points = mesher->points.data;
    const float *values = mesher->point_values.data;
    for (uint64_t i = 0; i < mesher->point_count && status == NSDF_OK; i++) {
        nsdf_grid_store(mesher, &points[i], values[i]);
        status = nsdf_mesher_ask(mesher, i, 1 << 15);
    }
    mesher->point_count = 0;
    return status == NSDF_OK ? update_signs(mesher) : status;
}

/* ---- Following the surface --------------------------------------------------------------------------------- */

void nsdf_gather_corners(const nsdf_mesher *mesher, const uint32_t neighbours[8], nsdf_corner_rows *rows) {
    const uint64_t *known[8], *negative[8];
    for (int i = 0; i < 8; i++) {
        const nsdf_brick *brick = neighbours[i] == NSDF_NO_BRICK ? NULL : brick_at(mesher, neighbours[i]);
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

/* Cells of the bricks below may have the surface in them too; makes those bricks, which are looked at later. */
static nsdf_status need_lower_bricks(nsdf_mesher *mesher, uint32_t index, const nsdf_corner_rows *rows) {
    for (uint32_t side = 1; side < 7; side++) {
        const uint16_t *at = brick_at(mesher, index)->at;
        const uint32_t dx = side & 1, dy = side >> 1 & 1, dz = side >> 2;
        if (at[0] < dx || at[1] < dy || at[2] < dz || !side_is_mixed(rows, side))
            continue;
        uint32_t lower;
        const nsdf_status status = nsdf_grid_need_brick(mesher, at[0] - dx, at[1] - dy, at[2] - dz, &lower);
        if (status != NSDF_OK)
            return status;
    }
    return NSDF_OK;
}

static nsdf_status check_brick(nsdf_mesher *mesher, uint32_t index) {
    uint32_t neighbours[8];
    nsdf_corner_rows rows;
    uint64_t mixed[8], missing = 0;
    brick_at(mesher, index)->check = 0;
    nsdf_grid_neighbours(mesher, index, neighbours);
    nsdf_gather_corners(mesher, neighbours, &rows);
    nsdf_mixed_cells(&rows, mixed);
    nsdf_brick *brick = brick_at(mesher, index);
    for (int z = 0; z < 8; z++) {
        missing |= mixed[z] & ~brick->cells[z];
        brick->cells[z] |= mixed[z];
    }
    const nsdf_status status = need_lower_bricks(mesher, index, &rows);
    return status == NSDF_OK && missing ? request_cells(mesher, index) : status;
}

nsdf_status nsdf_mesher_evaluate_corners(nsdf_mesher *mesher) {
    nsdf_status status = NSDF_OK;
    mesher->point_count = 0;
    for (uint32_t i = 0; i < mesher->brick_count && status == NSDF_OK; i++) {
        status = request_cells(mesher, i);
        if (status == NSDF_OK)
            status = nsdf_mesher_ask(mesher, i, 512);
    }
    while (status == NSDF_OK) {
        status = evaluate_requested(mesher);
        for (uint32_t i = 0; i < mesher->brick_count && status == NSDF_OK; i++)
            if (brick_at(mesher, i)->check)
                status = check_brick(mesher, i);
        if (mesher->point_count == 0)
            break;
    }
    return status;
}
