/* Coarse to fine: cubes of 32 cells, of 16, down to 2; those that cannot have the surface in them are dropped. */
#include "mesher_internal.h"

enum { COARSEST = 32, FINEST = 2 };

static nsdf_status cover_with_cubes(nsdf_mesher *mesher) {
    const uint32_t *cells = mesher->grid.cells;
    uint64_t total = 1;
    for (int a = 0; a < 3; a++)
        total *= (cells[a] + COARSEST - 1) / COARSEST;
    const nsdf_status status = nsdf_mesher_reserve(mesher, &mesher->cubes, total, 0, sizeof(nsdf_cube));
    if (status != NSDF_OK)
        return status;
    nsdf_cube *cube = mesher->cubes.data;
    for (uint32_t z = 0; z < cells[2]; z += COARSEST)
        for (uint32_t y = 0; y < cells[1]; y += COARSEST)
            for (uint32_t x = 0; x < cells[0]; x += COARSEST)
                *cube++ = (nsdf_cube){{(uint16_t)x, (uint16_t)y, (uint16_t)z}};
    mesher->cube_count = total;
    return NSDF_OK;
}

/* The corner in the middle of a cube, or nearest to it within the grid. */
static nsdf_status evaluate_centres(nsdf_mesher *mesher, uint32_t size) {
    nsdf_status status = nsdf_mesher_reserve(mesher, &mesher->points, mesher->cube_count, 0, sizeof(nsdf_grid_point));
    if (status != NSDF_OK)
        return status;
    const nsdf_cube *cubes = mesher->cubes.data;
    nsdf_grid_point *points = mesher->points.data;
    status = nsdf_mesher_reserve(mesher, &mesher->exact, mesher->cube_count, 0, sizeof(uint8_t));
    if (status != NSDF_OK)
        return status;
    for (uint64_t i = 0; i < mesher->cube_count; i++)
        for (int a = 0; a < 3; a++)
            points[i].at[a] = (uint16_t)nsdf_min_u32(cubes[i].at[a] + size / 2, mesher->grid.cells[a]);
    mesher->point_count = mesher->cube_count;
    mesher->measuring = size;
    status = nsdf_grid_evaluate_points(mesher);
    mesher->measuring = 0;
    return status;
}

/* Squared radius of the ball about a cube's centre that holds the cube, in cells, and whether it touches the border. */
static uint32_t reach_of_cube(const nsdf_mesher *mesher, const nsdf_cube *cube, uint32_t size, const uint16_t centre[3],
                              int *border) {
    uint32_t square = 0;
    *border = 0;
    for (int a = 0; a < 3; a++) {
        const uint32_t cells = mesher->grid.cells[a], high = nsdf_min_u32(cube->at[a] + size, cells);
        const uint32_t below = (uint32_t)centre[a] - cube->at[a], above = high - centre[a];
        const uint32_t reach = below > above ? below : above;
        square += reach * reach;
        *border |= cube->at[a] == 0 || high == cells;
    }
    return square;
}

/* Whether the bound leaves room for a change of sign between the corners of the cube.  A cube that is inside the
 * surface and touches the border has the cap there. */
static int may_hold_surface(const nsdf_mesher *mesher, const nsdf_cube *cube, uint32_t size, const uint16_t centre[3],
                            float value) {
    int border;
    const double square = reach_of_cube(mesher, cube, size, centre, &border);
    const double change = (double)mesher->job->bound * mesher->grid.step, size_square = (double)value * (double)value;
    return !(size_square > change * change * square) || (border && value < 0);
}

static void drop_cubes(nsdf_mesher *mesher, uint32_t size) {
    nsdf_cube *cubes = mesher->cubes.data;
    const nsdf_grid_point *points = mesher->points.data;
    const float *values = mesher->point_values.data;
    uint64_t kept = 0;
    for (uint64_t i = 0; i < mesher->cube_count; i++)
        if (may_hold_surface(mesher, &cubes[i], size, points[i].at, values[i]))
            cubes[kept++] = cubes[i];
    mesher->cube_count = kept;
}

/* Halves of a cube along one axis: 2, or 1 where the grid ends before the second. */
static uint32_t halves(const nsdf_mesher *mesher, const nsdf_cube *cube, int axis, uint32_t half) {
    return cube->at[axis] + half < mesher->grid.cells[axis] ? 2 : 1;
}

static nsdf_status split_cubes(nsdf_mesher *mesher, uint32_t half) {
    nsdf_status status = nsdf_mesher_reserve(mesher, &mesher->split, 8 * mesher->cube_count, 0, sizeof(nsdf_cube));
    if (status != NSDF_OK)
        return status;
    const nsdf_cube *cube = mesher->cubes.data;
    nsdf_cube *out = mesher->split.data;
    for (uint64_t i = 0; i < mesher->cube_count; i++, cube++) {
        const uint32_t nx = halves(mesher, cube, 0, half), ny = halves(mesher, cube, 1, half);
        const uint32_t nz = halves(mesher, cube, 2, half);
        for (uint32_t z = 0; z < nz; z++)
            for (uint32_t y = 0; y < ny; y++)
                for (uint32_t x = 0; x < nx; x++)
                    *out++ = (nsdf_cube){{(uint16_t)(cube->at[0] + x * half), (uint16_t)(cube->at[1] + y * half),
                                          (uint16_t)(cube->at[2] + z * half)}};
    }
    mesher->cube_count = (uint64_t)(out - (nsdf_cube *)mesher->split.data);
    const nsdf_array swap = mesher->cubes;
    mesher->cubes = mesher->split;
    mesher->split = swap;
    return NSDF_OK;
}

/* Activates the 2^3 cells of a cube. */
static nsdf_status activate_cube(nsdf_mesher *mesher, const nsdf_cube *cube) {
    const uint32_t x = cube->at[0], y = cube->at[1], z = cube->at[2], *cells = mesher->grid.cells;
    uint32_t index;
    const nsdf_status status = nsdf_grid_need_brick(mesher, x / 8, y / 8, z / 8, &index);
    if (status != NSDF_OK)
        return status;
    nsdf_brick *brick = nsdf_grid_brick(mesher, index);
    for (uint32_t k = 0; k < 8; k++) {
        const uint32_t cx = x + (k & 1), cy = y + (k >> 1 & 1), cz = z + (k >> 2);
        if (cx < cells[0] && cy < cells[1] && cz < cells[2])
            brick->cells[cz & 7] |= (uint64_t)1 << (8 * (cy & 7) + (cx & 7));
    }
    return NSDF_OK;
}

/* The bricks that hold the corners of active cells. */
static nsdf_status need_corners(nsdf_mesher *mesher) {
    for (uint32_t i = 0; i < mesher->brick_count; i++)
        nsdf_grid_brick(mesher, i)->upper = nsdf_brick_upper(nsdf_grid_brick(mesher, i));
    return nsdf_grid_need_neighbours(mesher);
}

/* Keeps the values that are there, also of cubes that are dropped, in the bricks that are there. */
static nsdf_status add_centres(nsdf_mesher *mesher) {
    const nsdf_grid_point *centres = mesher->points.data;
    const float *values = mesher->point_values.data;
    const uint8_t *exact = mesher->job->field.measure ? mesher->exact.data : NULL;
    nsdf_status status = NSDF_OK;
    for (uint64_t i = 0; i < mesher->cube_count && status == NSDF_OK; i++) {
        const uint16_t *at = centres[i].at;
        const uint32_t brick = nsdf_grid_brick_at(mesher, at[0] / 8, at[1] / 8, at[2] / 8);
        if (brick != NSDF_NO_BRICK && (!exact || exact[i]))
            nsdf_mesher_add_centre(mesher, brick, at, values[i]);
        status = nsdf_mesher_ask(mesher, i, 1 << 15);
    }
    return status;
}

static nsdf_status activate_cubes(nsdf_mesher *mesher) {
    const nsdf_cube *cubes = mesher->cubes.data;
    const nsdf_grid_point *centres = mesher->points.data;
    const float *values = mesher->point_values.data;
    nsdf_status status = NSDF_OK;
    for (uint64_t i = 0; i < mesher->cube_count && status == NSDF_OK; i++) {
        if (may_hold_surface(mesher, &cubes[i], FINEST, centres[i].at, values[i]))
            status = activate_cube(mesher, &cubes[i]);
        if (status == NSDF_OK)
            status = nsdf_mesher_ask(mesher, i, 4096);
    }
    if (status == NSDF_OK)
        status = need_corners(mesher);
    return status == NSDF_OK ? add_centres(mesher) : status;
}

/* The cells of a brick along one axis that lie in the grid, as a count. */
static uint32_t cells_in_brick(const nsdf_mesher *mesher, uint32_t brick, int axis) {
    const uint32_t first = brick * NSDF_BRICK_SIDE;
    return first < mesher->grid.cells[axis] ? nsdf_min_u32(mesher->grid.cells[axis] - first, NSDF_BRICK_SIDE) : 0;
}

static nsdf_status activate_whole_brick(nsdf_mesher *mesher, uint32_t x, uint32_t y, uint32_t z) {
    uint32_t index;
    const nsdf_status status = nsdf_grid_need_brick(mesher, x, y, z, &index);
    if (status != NSDF_OK)
        return status;
    nsdf_brick *brick = (nsdf_brick *)mesher->bricks.data + index;
    const uint32_t nx = cells_in_brick(mesher, x, 0), ny = cells_in_brick(mesher, y, 1);
    const uint32_t nz = cells_in_brick(mesher, z, 2);
    uint64_t slice = 0;
    for (uint32_t row = 0; row < ny; row++)
        slice |= (uint64_t)((1u << nx) - 1) << 8 * row;
    for (uint32_t i = 0; i < nz; i++)
        brick->cells[i] = slice;
    return NSDF_OK;
}

static nsdf_status activate_all(nsdf_mesher *mesher) {
    const uint32_t *bricks = mesher->grid.bricks;
    nsdf_status status = NSDF_OK;
    for (uint32_t z = 0; z < bricks[2]; z++)
        for (uint32_t y = 0; y < bricks[1]; y++)
            for (uint32_t x = 0; x < bricks[0] && status == NSDF_OK; x++) {
                status = activate_whole_brick(mesher, x, y, z);
                if (status == NSDF_OK)
                    status = nsdf_mesher_ask(mesher, mesher->brick_count, 512);
            }
    return status == NSDF_OK ? need_corners(mesher) : status;
}

nsdf_status nsdf_mesher_find_cells(nsdf_mesher *mesher) {
    if (mesher->job->dense)
        return activate_all(mesher);
    nsdf_status status = cover_with_cubes(mesher);
    for (uint32_t size = COARSEST; status == NSDF_OK; size /= 2) {
        status = evaluate_centres(mesher, size);
        if (status != NSDF_OK)
            break;
        if (size == FINEST)
            return activate_cubes(mesher);
        drop_cubes(mesher, size);
        status = split_cubes(mesher, size / 2);
    }
    return status;
}
