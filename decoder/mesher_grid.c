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
    memset((float *)mesher->values.data + (size_t)n * NSDF_BRICK_CORNERS, 0, NSDF_BRICK_CORNERS * sizeof(float));
    b->at[0] = (uint16_t)x;
    b->at[1] = (uint16_t)y;
    b->at[2] = (uint16_t)z;
    b->check = 1;
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

static int at_border(const nsdf_mesher *mesher, const nsdf_grid_point *centre) {
    const uint32_t half = mesher->measuring / 2;
    for (int a = 0; a < 3; a++)
        if (centre->at[a] <= half || centre->at[a] + half >= mesher->grid.cells[a])
            return 1;
    return 0;
}

/* Sizes; where the border may have a cap, signs too. */
static void measure_batch(const nsdf_mesher *mesher, nsdf_mesher_scratch *scratch, uint32_t worker,
                          const nsdf_grid_point *points, size_t count, float *value) {
    const nsdf_field *field = &mesher->job->field;
    const float *const xyz[3] = {scratch->point[0], scratch->point[1], scratch->point[2]};
    const float *const border[3] = {scratch->position[0], scratch->position[1], scratch->position[2]};
    float *const no_gradient[3] = {NULL, NULL, NULL};
    size_t border_count = 0;
    field->measure(field->user, worker, count, xyz, value);
    for (uint32_t i = 0; i < count; i++) {
        if (!at_border(mesher, &points[i]))
            continue;
        for (int a = 0; a < 3; a++)
            scratch->position[a][border_count] = xyz[a][i];
        scratch->list[border_count++] = i;
    }
    if (border_count > 0)
        field->evaluate(field->user, worker, border_count, border, scratch->value, no_gradient);
    for (size_t i = 0; i < border_count; i++)
        value[scratch->list[i]] = scratch->value[i];
}

static void evaluate_batch(void *data, uint32_t index, uint32_t worker) {
    const nsdf_mesher *mesher = data;
    nsdf_mesher_scratch *scratch = (nsdf_mesher_scratch *)mesher->scratch.data + worker;
    const uint64_t first = (uint64_t)index * NSDF_MESHER_BATCH, left = mesher->point_count - first;
    const size_t count = left < NSDF_MESHER_BATCH ? (size_t)left : NSDF_MESHER_BATCH;
    const nsdf_grid_point *points = (const nsdf_grid_point *)mesher->points.data + first;
    for (size_t i = 0; i < count; i++)
        for (int a = 0; a < 3; a++)
            scratch->point[a][i] = mesher->grid.corners[a][points[i].at[a]];
    const float *const xyz[3] = {scratch->point[0], scratch->point[1], scratch->point[2]};
    float *const no_gradient[3] = {NULL, NULL, NULL};
    const nsdf_field *field = &mesher->job->field;
    float *value = (float *)mesher->point_values.data + first;
    if (mesher->measuring && field->measure)
        measure_batch(mesher, scratch, worker, points, count, value);
    else
        field->evaluate(field->user, worker, count, xyz, value, no_gradient);
}

nsdf_status nsdf_grid_evaluate_points(nsdf_mesher *mesher) {
    const nsdf_status status =
        nsdf_mesher_reserve(mesher, &mesher->point_values, mesher->point_count, 0, sizeof(float));
    if (status != NSDF_OK)
        return status;
    mesher->evaluated += mesher->point_count;
    return nsdf_mesher_parallel(mesher, (mesher->point_count + NSDF_MESHER_BATCH - 1) / NSDF_MESHER_BATCH,
                                evaluate_batch);
}

/* Hostile parameters can make any value: NaN counts as outside, and differences stay finite. */
static float tame(float value) {
    if (value >= -NSDF_FIELD_LIMIT && value <= NSDF_FIELD_LIMIT)
        return value;
    return value < 0 ? -NSDF_FIELD_LIMIT : NSDF_FIELD_LIMIT;
}

void nsdf_grid_store(nsdf_mesher *mesher, const nsdf_grid_point *point, float value) {
    int border = 0;
    for (int a = 0; a < 3; a++)
        border |= point->at[a] == 0 || point->at[a] == mesher->grid.cells[a];
    value = tame(value);
    if (border && value < 0)
        value = NSDF_BORDER_VALUE;
    ((float *)mesher->values.data)[(size_t)point->brick * NSDF_BRICK_CORNERS + point->local] = value;
}
