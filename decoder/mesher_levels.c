/* Coarse to fine: cubes of 32 cells, of 16, down to 2; those that cannot have the surface in them are dropped. */
#include "mesher_internal.h"

enum { COARSEST = 32, FINEST = 2, CUBES_PER_TASK = 1024 };

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

/* ---- Centres ------------------------------------------------------------------------------------------------ */

/* What is known of a cube, in `exact`. */
enum { HAS_VALUE = 1, IS_KEPT = 2 };

/* Tasks that are CUBES_PER_TASK cubes each. */
static nsdf_status for_cubes(nsdf_mesher *mesher, nsdf_task_fn fn) {
    return nsdf_mesher_parallel(mesher, (mesher->cube_count + CUBES_PER_TASK - 1) / CUBES_PER_TASK, fn);
}

static uint64_t end_of_task(const nsdf_mesher *mesher, uint32_t task) {
    const uint64_t end = ((uint64_t)task + 1) * CUBES_PER_TASK;
    return end < mesher->cube_count ? end : mesher->cube_count;
}

/* The corners in the middle of cubes, or nearest to it within the grid. */
static void place_centres(void *data, uint32_t task, uint32_t worker) {
    const nsdf_mesher *mesher = data;
    const nsdf_cube *cubes = mesher->cubes.data;
    nsdf_grid_point *points = mesher->points.data;
    const uint32_t half = mesher->measuring / 2;
    (void)worker;
    for (uint64_t i = (uint64_t)task * CUBES_PER_TASK, end = end_of_task(mesher, task); i < end; i++)
        for (int a = 0; a < 3; a++)
            points[i].at[a] = (uint16_t)nsdf_min_u32(cubes[i].at[a] + half, mesher->grid.cells[a]);
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

/* The same for most cubes, which are whole and do not touch the border: whether it is one of them. */
static int is_inner(const nsdf_mesher *mesher, const nsdf_cube *cube, uint32_t size) {
    int inner = 1;
    for (int a = 0; a < 3; a++)
        inner &= cube->at[a] > 0 && cube->at[a] + size < mesher->grid.cells[a];
    return inner;
}

static void judge_cubes(void *data, uint32_t task, uint32_t worker) {
    const nsdf_mesher *mesher = data;
    const nsdf_cube *cubes = mesher->cubes.data;
    const nsdf_grid_point *points = mesher->points.data;
    const float *values = mesher->point_values.data;
    const uint32_t size = mesher->measuring;
    const double change = (double)mesher->job->bound * mesher->grid.step;
    const double most = change * change * (double)(3 * (size / 2) * (size / 2));
    uint8_t *known = mesher->exact.data;
    (void)worker;
    for (uint64_t i = (uint64_t)task * CUBES_PER_TASK, end = end_of_task(mesher, task); i < end; i++) {
        const int kept = is_inner(mesher, &cubes[i], size)
                             ? !((double)values[i] * (double)values[i] > most)
                             : may_hold_surface(mesher, &cubes[i], size, points[i].at, values[i]);
        known[i] = (uint8_t)((mesher->job->field.measure ? known[i] : HAS_VALUE) | (kept ? IS_KEPT : 0));
    }
}

/* Evaluates the centres of cubes of one size, and tells which may hold the surface. */
static nsdf_status measure_cubes(nsdf_mesher *mesher, uint32_t size) {
    nsdf_status status = nsdf_mesher_reserve(mesher, &mesher->points, mesher->cube_count, 0, sizeof(nsdf_grid_point));
    if (status == NSDF_OK)
        status = nsdf_mesher_reserve(mesher, &mesher->exact, mesher->cube_count, 0, sizeof(uint8_t));
    mesher->point_count = mesher->cube_count;
    mesher->measuring = size;
    if (status == NSDF_OK)
        status = for_cubes(mesher, place_centres);
    if (status == NSDF_OK)
        status = nsdf_grid_evaluate_points(mesher);
    if (status == NSDF_OK)
        status = for_cubes(mesher, judge_cubes);
    mesher->measuring = 0;
    return status;
}

static void drop_cubes(nsdf_mesher *mesher) {
    nsdf_cube *cubes = mesher->cubes.data;
    const uint8_t *known = mesher->exact.data;
    uint64_t kept = 0;
    for (uint64_t i = 0; i < mesher->cube_count; i++)
        if (known[i] & IS_KEPT)
            cubes[kept++] = cubes[i];
    mesher->cube_count = kept;
}

/* ---- Halves ------------------------------------------------------------------------------------------------- */

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

/* ---- Bricks ------------------------------------------------------------------------------------------------- */

/* Cubes of two cells come brick by brick, since those of eight cells did and halves follow each other: whether the
 * cube's brick is that of the one before it. */
static int goes_on(const nsdf_cube *cubes, uint64_t i) {
    return i > 0 && cubes[i].at[0] / 8 == cubes[i - 1].at[0] / 8 && cubes[i].at[1] / 8 == cubes[i - 1].at[1] / 8 &&
           cubes[i].at[2] / 8 == cubes[i - 1].at[2] / 8;
}

/* The cubes of a brick, from number `first` on; returns the number after them. */
static uint64_t end_of_brick(const nsdf_mesher *mesher, uint64_t first) {
    uint64_t end = first + 1;
    while (end < mesher->cube_count && goes_on(mesher->cubes.data, end))
        end++;
    return end;
}

static uint32_t brick_of(const nsdf_mesher *mesher, const nsdf_cube *cube) {
    return nsdf_grid_brick_at(mesher, cube->at[0] / 8, cube->at[1] / 8, cube->at[2] / 8);
}

/* Makes the bricks of the cubes that are kept. */
static nsdf_status need_bricks(nsdf_mesher *mesher) {
    const nsdf_cube *cubes = mesher->cubes.data;
    const uint8_t *known = mesher->exact.data;
    nsdf_status status = NSDF_OK;
    for (uint64_t i = 0, end, n = 0; i < mesher->cube_count && status == NSDF_OK; i = end, n++) {
        uint32_t kept = 0, unused;
        end = end_of_brick(mesher, i);
        for (uint64_t k = i; k < end; k++)
            kept |= known[k];
        if (kept & IS_KEPT)
            status = nsdf_grid_need_brick(mesher, cubes[i].at[0] / 8, cubes[i].at[1] / 8, cubes[i].at[2] / 8, &unused);
        if (status == NSDF_OK)
            status = nsdf_mesher_ask(mesher, n, 1024);
    }
    return status;
}

/* Activates the 2^3 cells of a cube. */
static void activate_cube(const nsdf_mesher *mesher, const nsdf_cube *cube, nsdf_brick *brick) {
    const uint32_t x = cube->at[0], y = cube->at[1], z = cube->at[2], *cells = mesher->grid.cells;
    const uint64_t row = x + 1 < cells[0] ? 3 : 1, square = y + 1 < cells[1] ? row | row << 8 : row;
    brick->cells[z & 7] |= square << (8 * (y & 7) + (x & 7));
    if (z + 1 < cells[2])
        brick->cells[(z & 7) + 1] |= square << (8 * (y & 7) + (x & 7));
}

typedef void visit_cube(const nsdf_mesher *mesher, uint64_t i, nsdf_brick *brick);

/* Visits the cubes, of the bricks that are there, of which the first is among the task's. */
static void visit_cubes(const nsdf_mesher *mesher, uint32_t task, visit_cube *visit) {
    const nsdf_cube *cubes = mesher->cubes.data;
    const uint64_t last = end_of_task(mesher, task);
    uint64_t first = (uint64_t)task * CUBES_PER_TASK;
    while (first < last && goes_on(cubes, first))
        first++;
    for (uint64_t end; first < last; first = end) {
        const uint32_t brick = brick_of(mesher, &cubes[first]);
        end = end_of_brick(mesher, first);
        for (uint64_t i = first; i < end && brick != NSDF_NO_BRICK; i++)
            visit(mesher, i, nsdf_grid_brick(mesher, brick));
    }
}

static void activate_if_kept(const nsdf_mesher *mesher, uint64_t i, nsdf_brick *brick) {
    if (((const uint8_t *)mesher->exact.data)[i] & IS_KEPT)
        activate_cube(mesher, (const nsdf_cube *)mesher->cubes.data + i, brick);
}

static void activate_task(void *data, uint32_t task, uint32_t worker) {
    (void)worker;
    visit_cubes(data, task, activate_if_kept);
}

/* Keeps the values that are there, also of cubes that are dropped. */
static void keep_value(const nsdf_mesher *mesher, uint64_t i, nsdf_brick *brick) {
    const nsdf_grid_point *centre = (const nsdf_grid_point *)mesher->points.data + i;
    const uint32_t index = (uint32_t)(brick - (const nsdf_brick *)mesher->bricks.data);
    if (((const uint8_t *)mesher->exact.data)[i] & HAS_VALUE)
        nsdf_mesher_add_centre(mesher, index, centre->at, ((const float *)mesher->point_values.data)[i]);
}

static void keep_values_task(void *data, uint32_t task, uint32_t worker) {
    (void)worker;
    visit_cubes(data, task, keep_value);
}

/* The bricks that hold the corners of active cells. */
static nsdf_status need_corners(nsdf_mesher *mesher) {
    for (uint32_t i = 0; i < mesher->brick_count; i++)
        nsdf_grid_brick(mesher, i)->upper = nsdf_brick_upper(nsdf_grid_brick(mesher, i));
    return nsdf_grid_need_neighbours(mesher);
}

/* Each brick's cubes are one task's: no two write to the same. */
static nsdf_status activate_cubes(nsdf_mesher *mesher) {
    nsdf_status status = need_bricks(mesher);
    if (status == NSDF_OK)
        status = for_cubes(mesher, activate_task);
    if (status == NSDF_OK)
        status = need_corners(mesher);
    return status == NSDF_OK ? for_cubes(mesher, keep_values_task) : status;
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
        status = measure_cubes(mesher, size);
        if (status != NSDF_OK)
            break;
        if (size == FINEST)
            return activate_cubes(mesher);
        drop_cubes(mesher);
        status = split_cubes(mesher, size / 2);
    }
    return status;
}
