/* Vertices on the grid edges where the sign changes, and the triangles of the cells.  Bricks in the order of the grid,
 * within a brick edges by axis, then z, y, x, and cells by z, y, x: the mesh depends on the field alone. */
#include "mesher_internal.h"
#include "mesher_tables.h"

/* Vertices keep this distance, in cells, from the corners: triangles keep an area, and no two vertices coincide. */
static const double least_fraction = 1e-3;

/* ---- Counting ---------------------------------------------------------------------------------------------- */

static void rank_edges(nsdf_brick *brick) {
    uint32_t count = 0;
    for (int a = 0; a < 3; a++) {
        for (int z = 0; z < 8; z++) {
            brick->rank[a][z] = (uint16_t)count;
            count += nsdf_mesher_popcount(brick->edges[a][z]);
        }
    }
    brick->vertex_count = count;
}

/* Bit c of the case is corner c; mesher_tables.h. */
static uint32_t case_of_cell(const nsdf_corner_rows *rows, uint32_t x, uint32_t y, uint32_t z) {
    return (rows->negative[z][y] >> x & 3u) | (rows->negative[z][y + 1] >> x & 3u) << 2 |
           (rows->negative[z + 1][y] >> x & 3u) << 4 | (rows->negative[z + 1][y + 1] >> x & 3u) << 6;
}

static void count_triangles(nsdf_brick *brick, const nsdf_corner_rows *rows) {
    uint64_t mixed[8];
    nsdf_mixed_cells(rows, mixed);
    brick->triangle_count = 0;
    for (uint32_t z = 0; z < 8; z++) {
        for (uint64_t bits = mixed[z]; bits; bits &= bits - 1) {
            const uint32_t bit = nsdf_mesher_lowest(bits), cell = case_of_cell(rows, bit & 7, bit >> 3, z);
            brick->triangle_count += (uint32_t)(nsdf_mc_first[cell + 1] - nsdf_mc_first[cell]);
        }
    }
}

static void count_bricks(void *data, uint32_t task, uint32_t worker) {
    const nsdf_mesher *mesher = data;
    const uint32_t first = task * NSDF_BRICKS_PER_TASK;
    const uint32_t count = nsdf_min_u32(mesher->brick_count - first, NSDF_BRICKS_PER_TASK);
    (void)worker;
    for (uint32_t i = first; i < first + count; i++) {
        uint32_t neighbours[8];
        nsdf_corner_rows rows;
        nsdf_grid_neighbours(mesher, i, neighbours);
        nsdf_gather_corners(mesher, neighbours, &rows);
        rank_edges(nsdf_grid_brick(mesher, i));
        count_triangles(nsdf_grid_brick(mesher, i), &rows);
    }
}

static nsdf_status order_bricks(nsdf_mesher *mesher) {
    const nsdf_status status = nsdf_mesher_reserve(mesher, &mesher->order, mesher->brick_count, 0, sizeof(uint32_t));
    if (status != NSDF_OK)
        return status;
    const uint32_t *table = mesher->table.data, *size = mesher->grid.bricks;
    const size_t total = (size_t)size[0] * size[1] * size[2];
    uint32_t *order = mesher->order.data;
    for (size_t i = 0; i < total; i++)
        if (table[i] != NSDF_NO_BRICK)
            *order++ = table[i];
    return NSDF_OK;
}

/* Where each brick's vertices and triangles go. */
static nsdf_status number_vertices(nsdf_mesher *mesher) {
    const uint32_t *order = mesher->order.data;
    uint64_t vertices = 0, triangles = 0;
    for (uint32_t i = 0; i < mesher->brick_count; i++) {
        nsdf_brick *brick = nsdf_grid_brick(mesher, order[i]);
        brick->first_vertex = (uint32_t)vertices;
        brick->first_triangle = (uint32_t)triangles;
        vertices += brick->vertex_count;
        triangles += brick->triangle_count;
        if (vertices > UINT32_MAX || triangles > UINT32_MAX)
            return NSDF_LIMIT;
    }
    mesher->storage->vertex_count = (uint32_t)vertices;
    mesher->storage->triangle_count = (uint32_t)triangles;
    return NSDF_OK;
}

static nsdf_status reserve_storage(nsdf_mesher *mesher) {
    nsdf_mesh_storage *storage = mesher->storage;
    nsdf_memory *memory = mesher->storage_memory;
    void *positions = storage->positions, *normals = storage->normals, *indices = storage->indices;
    nsdf_status status =
        nsdf_memory_grow(memory, &positions, &storage->position_capacity, storage->vertex_count, 0, 3 * sizeof(float));
    storage->positions = positions;
    if (status == NSDF_OK && mesher->job->normals) {
        status =
            nsdf_memory_grow(memory, &normals, &storage->normal_capacity, storage->vertex_count, 0, 3 * sizeof(float));
        storage->normals = normals;
    }
    if (status == NSDF_OK) {
        status = nsdf_memory_grow(memory, &indices, &storage->index_capacity, storage->triangle_count, 0,
                                  3 * sizeof(uint32_t));
        storage->indices = indices;
    }
    if (status != NSDF_OK)
        return status;
    return nsdf_mesher_reserve(mesher, &mesher->loose, storage->vertex_count, 0, sizeof(uint8_t));
}

/* ---- Filling ----------------------------------------------------------------------------------------------- */

static float corner_value(const nsdf_mesher *mesher, const uint32_t neighbours[8], const uint32_t corner[3]) {
    const uint32_t owner = neighbours[corner[0] >> 3 | corner[1] >> 3 << 1 | corner[2] >> 3 << 2];
    const uint32_t local = 64 * (corner[2] & 7) + 8 * (corner[1] & 7) + (corner[0] & 7);
    return ((const float *)mesher->values.data)[(size_t)owner * NSDF_BRICK_CORNERS + local];
}

/* The vertex of the edge from `corner` (in the brick) along `axis`. */
static void place_vertex(const nsdf_mesher *mesher, const nsdf_brick *brick, const uint32_t neighbours[8],
                         const uint32_t corner[3], int axis, uint32_t vertex) {
    uint32_t end[3] = {corner[0], corner[1], corner[2]};
    end[axis]++;
    const double a = (double)corner_value(mesher, neighbours, corner);
    const double b = (double)corner_value(mesher, neighbours, end);
    /* A border value says that the surface ends there, not where it would be. */
    const int capped_low = a > (double)NSDF_FIELD_LIMIT, capped_high = b > (double)NSDF_FIELD_LIMIT;
    double t = capped_low ? 0 : capped_high ? 1 : a / (a - b);
    t = t < least_fraction ? least_fraction : t > 1 - least_fraction ? 1 - least_fraction : t;
    float *position = mesher->storage->positions + 3 * (size_t)vertex;
    for (int i = 0; i < 3; i++) {
        const float *at = mesher->grid.corners[i] + 8u * brick->at[i] + corner[i];
        position[i] = i == axis ? (float)((double)at[0] + t * ((double)at[1] - (double)at[0])) : at[0];
    }
    ((uint8_t *)mesher->loose.data)[vertex] = capped_low || capped_high ? NSDF_VERTEX_ON_BORDER : 0;
}

static void place_vertices(const nsdf_mesher *mesher, const nsdf_brick *brick, const uint32_t neighbours[8]) {
    uint32_t vertex = brick->first_vertex;
    for (int axis = 0; axis < 3; axis++) {
        for (uint32_t z = 0; z < 8; z++) {
            for (uint64_t bits = brick->edges[axis][z]; bits; bits &= bits - 1) {
                const uint32_t bit = nsdf_mesher_lowest(bits), corner[3] = {bit & 7, bit >> 3, z};
                place_vertex(mesher, brick, neighbours, corner, axis, vertex++);
            }
        }
    }
}

/* The vertex on an edge of the cell at x, y, z of a brick. */
static uint32_t vertex_on_edge(const nsdf_brick *const owners[8], uint32_t x, uint32_t y, uint32_t z, uint32_t edge) {
    static const uint8_t step[12][3] = {{0, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 1, 1}, {0, 0, 0}, {1, 0, 0},
                                        {0, 0, 1}, {1, 0, 1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
    const uint32_t axis = edge >> 2;
    x += step[edge][0];
    y += step[edge][1];
    z += step[edge][2];
    const nsdf_brick *owner = owners[x >> 3 | y >> 3 << 1 | z >> 3 << 2];
    const uint64_t before = ((uint64_t)1 << (8 * (y & 7) + (x & 7))) - 1;
    return owner->first_vertex + owner->rank[axis][z & 7] + nsdf_mesher_popcount(owner->edges[axis][z & 7] & before);
}

static uint32_t *add_cell(const nsdf_brick *const owners[8], const nsdf_corner_rows *rows, uint32_t x, uint32_t y,
                          uint32_t z, uint32_t *indices) {
    const uint32_t cell = case_of_cell(rows, x, y, z);
    for (uint32_t i = nsdf_mc_first[cell]; i < nsdf_mc_first[cell + 1]; i++)
        for (int k = 0; k < 3; k++)
            *indices++ = vertex_on_edge(owners, x, y, z, nsdf_mc_triangles[i][k]);
    return indices;
}

static void fill_brick(const nsdf_mesher *mesher, uint32_t index) {
    const nsdf_brick *brick = nsdf_grid_brick(mesher, index), *owners[8];
    uint32_t neighbours[8];
    nsdf_corner_rows rows;
    uint64_t mixed[8];
    nsdf_grid_neighbours(mesher, index, neighbours);
    for (int i = 0; i < 8; i++)
        owners[i] = neighbours[i] == NSDF_NO_BRICK ? NULL : nsdf_grid_brick(mesher, neighbours[i]);
    place_vertices(mesher, brick, neighbours);
    nsdf_gather_corners(mesher, neighbours, &rows);
    nsdf_mixed_cells(&rows, mixed);
    uint32_t *indices = mesher->storage->indices + 3 * (size_t)brick->first_triangle;
    for (uint32_t z = 0; z < 8; z++) {
        for (uint64_t bits = mixed[z]; bits; bits &= bits - 1) {
            const uint32_t bit = nsdf_mesher_lowest(bits);
            indices = add_cell(owners, &rows, bit & 7, bit >> 3, z, indices);
        }
    }
}

static void fill_bricks(void *data, uint32_t task, uint32_t worker) {
    const nsdf_mesher *mesher = data;
    const uint32_t first = task * NSDF_BRICKS_PER_TASK;
    const uint32_t count = nsdf_min_u32(mesher->brick_count - first, NSDF_BRICKS_PER_TASK);
    (void)worker;
    for (uint32_t i = first; i < first + count; i++) {
        const nsdf_brick *brick = nsdf_grid_brick(mesher, i);
        if (brick->vertex_count || brick->triangle_count)
            fill_brick(mesher, i);
    }
}

nsdf_status nsdf_mesher_make_triangles(nsdf_mesher *mesher) {
    nsdf_status status = order_bricks(mesher);
    if (status == NSDF_OK)
        status = nsdf_mesher_for_bricks(mesher, count_bricks);
    if (status == NSDF_OK)
        status = number_vertices(mesher);
    if (status == NSDF_OK)
        status = reserve_storage(mesher);
    if (status == NSDF_OK)
        status = nsdf_mesher_for_bricks(mesher, fill_bricks);
    return status;
}
