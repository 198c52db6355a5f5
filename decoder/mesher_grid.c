/* The grid: coordinates, bricks and the values at corners. */
#include "mesher_internal.h"

#include <math.h>
#include <string.h>

/* Cells along a side of the domain: enough to cover it, and at least two, so that some corner lies inside. */
static uint32_t cells_along(double side, double step) {
    const double cells = ceil(side / step - 1e-3); /* rounding in side / step must not add a cell */
    return cells < 2 ? 2 : (uint32_t)cells;
}

/* Coordinates are clamped to the domain, beyond which the field means nothing. */
static void place_corners(float *corner, uint32_t cells, float low, float high, double step) {
    const double first = 0.5 * ((double)low + (double)high - cells * step);
    for (uint32_t i = 0; i <= cells; i++) {
        const float x = (float)(first + i * step);
        corner[i] = x < low ? low : x > high ? high : x;
    }
    corner[0] = low;
    corner[cells] = high;
}

nsdf_status nsdf_grid_begin(nsdf_mesher *mesher) {
    const nsdf_mesher_job *job = mesher->job;
    nsdf_grid *grid = &mesher->grid;
    double side[3], longest = 0;
    for (int a = 0; a < 3; a++) {
        side[a] = (double)job->domain_max[a] - (double)job->domain_min[a];
        longest = fmax(longest, side[a]);
    }
    grid->step = longest / job->resolution;
    uint64_t corners = 0, bricks = 1;
    for (int a = 0; a < 3; a++) {
        grid->cells[a] = cells_along(side[a], grid->step);
        grid->bricks[a] = grid->cells[a] / NSDF_BRICK_SIDE + 1;
        corners += grid->cells[a] + 1;
        bricks *= grid->bricks[a];
    }
    nsdf_status status = nsdf_mesher_reserve(mesher, &mesher->coordinates, corners, 0, sizeof(float));
    if (status == NSDF_OK)
        status = nsdf_mesher_reserve(mesher, &mesher->table, bricks, 0, sizeof(uint32_t));
    if (status != NSDF_OK)
        return status;
    float *corner = mesher->coordinates.data;
    for (int a = 0; a < 3; a++) {
        grid->corners[a] = corner;
        place_corners(corner, grid->cells[a], job->domain_min[a], job->domain_max[a], grid->step);
        corner += grid->cells[a] + 1;
    }
    memset(mesher->table.data, 0xff, (size_t)bricks * sizeof(uint32_t));
    mesher->brick_count = 0;
    mesher->point_count = 0;
    return NSDF_OK;
}

static size_t table_index(const nsdf_grid *grid, uint32_t x, uint32_t y, uint32_t z) {
    return ((size_t)z * grid->bricks[1] + y) * grid->bricks[0] + x;
}

uint32_t nsdf_grid_brick_at(const nsdf_mesher *mesher, uint32_t x, uint32_t y, uint32_t z) {
    const nsdf_grid *grid = &mesher->grid;
    if (x >= grid->bricks[0] || y >= grid->bricks[1] || z >= grid->bricks[2])
        return NSDF_NO_BRICK;
    return ((const uint32_t *)mesher->table.data)[table_index(grid, x, y, z)];
}

nsdf_status nsdf_grid_need_brick(nsdf_mesher *mesher, uint32_t x, uint32_t y, uint32_t z, uint32_t *brick) {
    *brick = nsdf_grid_brick_at(mesher, x, y, z);
    if (*brick != NSDF_NO_BRICK)
        return NSDF_OK;
    const uint32_t n = mesher->brick_count;
    if (n == NSDF_NO_BRICK)
        return NSDF_LIMIT;
    nsdf_status status = nsdf_mesher_reserve(mesher, &mesher->bricks, (uint64_t)n + 1, n, sizeof(nsdf_brick));
    if (status == NSDF_OK)
        status = nsdf_mesher_reserve(mesher, &mesher->values, (uint64_t)n + 1, n, NSDF_BRICK_CORNERS * sizeof(float));
    if (status != NSDF_OK)
        return status;
    nsdf_brick *b = (nsdf_brick *)mesher->bricks.data + n;
    memset(b, 0, sizeof *b);
    b->at[0] = (uint16_t)x;
    b->at[1] = (uint16_t)y;
    b->at[2] = (uint16_t)z;
    b->fresh = 1;
    ((uint32_t *)mesher->table.data)[table_index(&mesher->grid, x, y, z)] = n;
    mesher->brick_count = n + 1;
    *brick = n;
    return NSDF_OK;
}

void nsdf_grid_neighbours(const nsdf_mesher *mesher, uint32_t brick, uint32_t neighbours[8]) {
    const uint16_t *at = ((const nsdf_brick *)mesher->bricks.data)[brick].at;
    for (uint32_t i = 0; i < 8; i++)
        neighbours[i] = nsdf_grid_brick_at(mesher, at[0] + (i & 1), at[1] + (i >> 1 & 1), at[2] + (i >> 2));
}

void nsdf_grid_lower(const nsdf_mesher *mesher, uint32_t brick, const nsdf_brick *lower[8]) {
    static const nsdf_brick nothing;
    const uint16_t *at = nsdf_grid_brick(mesher, brick)->at;
    for (uint32_t i = 0; i < 8; i++) {
        const uint32_t dx = i & 1, dy = i >> 1 & 1, dz = i >> 2;
        const int within = at[0] >= dx && at[1] >= dy && at[2] >= dz;
        const uint32_t index = within ? nsdf_grid_brick_at(mesher, at[0] - dx, at[1] - dy, at[2] - dz) : NSDF_NO_BRICK;
        lower[i] = index == NSDF_NO_BRICK ? &nothing : nsdf_grid_brick(mesher, index);
    }
}

/* `up` is whether the neighbours lie above. */
static nsdf_status need_neighbours(nsdf_mesher *mesher, uint32_t brick, uint32_t which, int up) {
    nsdf_status status = NSDF_OK;
    for (uint32_t i = 1; which >> i && status == NSDF_OK; i++) {
        const uint16_t *at = nsdf_grid_brick(mesher, brick)->at;
        const uint32_t dx = i & 1, dy = i >> 1 & 1, dz = i >> 2;
        uint32_t unused;
        if (!(which >> i & 1) || (!up && (at[0] < dx || at[1] < dy || at[2] < dz)))
            continue;
        status = up ? nsdf_grid_need_brick(mesher, at[0] + dx, at[1] + dy, at[2] + dz, &unused)
                    : nsdf_grid_need_brick(mesher, at[0] - dx, at[1] - dy, at[2] - dz, &unused);
    }
    return status;
}

/* Bricks that are made here need none yet. */
nsdf_status nsdf_grid_need_neighbours(nsdf_mesher *mesher) {
    const uint32_t count = mesher->brick_count;
    nsdf_status status = NSDF_OK;
    for (uint32_t i = 0; i < count && status == NSDF_OK; i++) {
        nsdf_brick *brick = nsdf_grid_brick(mesher, i);
        const uint32_t upper = brick->upper, lower = brick->lower;
        brick->upper = brick->lower = 0;
        if (upper)
            status = need_neighbours(mesher, i, upper, 1);
        if (lower && status == NSDF_OK)
            status = need_neighbours(mesher, i, lower, 0);
        if (status == NSDF_OK)
            status = nsdf_mesher_ask(mesher, i, 4096);
    }
    return status;
}

uint8_t nsdf_brick_upper(const nsdf_brick *brick) {
    uint64_t all = 0;
    for (int z = 0; z < 8; z++)
        all |= brick->cells[z];
    const uint64_t row_7 = (uint64_t)0xff << 56, sets[2] = {all, brick->cells[7]};
    uint32_t which = 0;
    for (uint32_t dz = 0; dz < 2; dz++) {
        which |= (uint32_t)((sets[dz] & NSDF_COLUMN_7) != 0) << (4 * dz + 1);
        which |= (uint32_t)((sets[dz] & row_7) != 0) << (4 * dz + 2);
        which |= (uint32_t)((sets[dz] & NSDF_COLUMN_7 & row_7) != 0) << (4 * dz + 3);
    }
    return (uint8_t)(which | (uint32_t)(brick->cells[7] != 0) << 4);
}

static int at_border(const nsdf_mesher *mesher, const nsdf_grid_point *centre) {
    const uint32_t half = mesher->measuring / 2;
    for (int a = 0; a < 3; a++)
        if (centre->at[a] <= half || centre->at[a] + half >= mesher->grid.cells[a])
            return 1;
    return 0;
}

/* Sizes, as far as they decide whether cubes are dropped; where the border may have a cap, values. */
static void measure_batch(const nsdf_mesher *mesher, nsdf_mesher_scratch *scratch, uint32_t worker,
                          const nsdf_grid_point *points, size_t count, float *value, uint8_t *exact) {
    const nsdf_field *field = &mesher->job->field;
    const float *const xyz[3] = {scratch->point[0], scratch->point[1], scratch->point[2]};
    const float *const border[3] = {scratch->position[0], scratch->position[1], scratch->position[2]};
    float *const no_gradient[3] = {NULL, NULL, NULL};
    size_t border_count = 0;
    const float enough = (float)(1.001 * 0.5 * sqrt(3.0) * mesher->measuring * mesher->grid.step) * mesher->job->bound;
    field->measure(field->user, worker, count, xyz, enough, value, exact);
    for (uint32_t i = 0; i < count; i++) {
        if (!at_border(mesher, &points[i]))
            continue;
        for (int a = 0; a < 3; a++)
            scratch->position[a][border_count] = xyz[a][i];
        scratch->list[border_count++] = i;
    }
    if (border_count > 0)
        field->evaluate(field->user, worker, border_count, border, scratch->value, no_gradient);
    for (size_t i = 0; i < border_count; i++) {
        value[scratch->list[i]] = scratch->value[i];
        exact[scratch->list[i]] = 1;
    }
}

static void evaluate_batch(void *data, uint32_t index, uint32_t worker) {
    const nsdf_mesher *mesher = data;
    nsdf_mesher_scratch *scratch = (nsdf_mesher_scratch *)mesher->scratch.data + worker;
    const uint64_t first = (uint64_t)index * mesher->batch, left = mesher->point_count - first;
    const size_t count = left < mesher->batch ? (size_t)left : mesher->batch;
    const nsdf_grid_point *points = (const nsdf_grid_point *)mesher->points.data + first;
    for (size_t i = 0; i < count; i++)
        for (int a = 0; a < 3; a++)
            scratch->point[a][i] = mesher->grid.corners[a][points[i].at[a]];
    const float *const xyz[3] = {scratch->point[0], scratch->point[1], scratch->point[2]};
    float *const no_gradient[3] = {NULL, NULL, NULL};
    const nsdf_field *field = &mesher->job->field;
    float *value = (float *)mesher->point_values.data + first;
    if (mesher->measuring && field->measure)
        measure_batch(mesher, scratch, worker, points, count, value, (uint8_t *)mesher->exact.data + first);
    else
        field->evaluate(field->user, worker, count, xyz, value, no_gradient);
}

/* Few points are shared out too.  Values depend on no others, so that this depends on the workers. */
static uint32_t choose_batch(const nsdf_mesher *mesher) {
    enum { LEAST = 48, TASKS_PER_WORKER = 4 };
    const uint32_t workers = nsdf_tasks_workers(mesher->tasks);
    const uint64_t share = mesher->point_count / ((uint64_t)TASKS_PER_WORKER * workers) / LEAST * LEAST + LEAST;
    return workers == 1 || share > NSDF_MESHER_BATCH ? NSDF_MESHER_BATCH : (uint32_t)share;
}

nsdf_status nsdf_grid_evaluate_points(nsdf_mesher *mesher) {
    const nsdf_status status =
        nsdf_mesher_reserve(mesher, &mesher->point_values, mesher->point_count, 0, sizeof(float));
    if (status != NSDF_OK)
        return status;
    mesher->evaluated += mesher->point_count;
    mesher->batch = choose_batch(mesher);
    return nsdf_mesher_parallel(mesher, (mesher->point_count + mesher->batch - 1) / mesher->batch, evaluate_batch);
}

/* Hostile parameters can make any value: NaN counts as outside, and differences stay finite. */
static float tame(float value) {
    if (value >= -NSDF_FIELD_LIMIT && value <= NSDF_FIELD_LIMIT)
        return value;
    return value < 0 ? -NSDF_FIELD_LIMIT : NSDF_FIELD_LIMIT;
}

void nsdf_grid_store(const nsdf_mesher *mesher, uint32_t brick, const uint16_t at[3], float value) {
    int border = 0;
    for (int a = 0; a < 3; a++)
        border |= at[a] == 0 || at[a] == mesher->grid.cells[a];
    value = tame(value);
    if (border && value < 0)
        value = NSDF_BORDER_VALUE;
    const uint32_t x = at[0] & 7u, y = at[1] & 7u, z = at[2] & 7u;
    uint64_t *negative = &nsdf_grid_brick(mesher, brick)->negative[z];
    const uint64_t bit = (uint64_t)1 << (8 * y + x);
    ((float *)mesher->values.data)[(size_t)brick * NSDF_BRICK_CORNERS + 64 * z + 8 * y + x] = value;
    *negative = value < 0 ? *negative | bit : *negative & ~bit;
}
