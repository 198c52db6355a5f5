/* Vertices on the grid edges where the sign changes, and the triangles of the cells.  Bricks in the order of the grid,
 * within a brick edges by parts, then axis, z, y, x, and cells by z, y, x: the mesh depends on the field alone, and
 * vertices that follow each other lie near each other. */
#include "mesher_internal.h"
#include "mesher_tables.h"

/* Vertices keep this distance, in cells, from the corners: triangles keep an area, and no two vertices coincide. */
static const double least_fraction = 1e-3;

/* ---- Counting ---------------------------------------------------------------------------------------------- */

static int is_crossed(const nsdf_brick *brick) {
    uint64_t any = 0;
    for (int z = 0; z < 8; z++)
        any |= brick->crossed[z];
    return any != 0;
}

static void rank_edges(nsdf_brick *brick) {
    uint32_t count = 0;
    for (uint32_t part = 0; part < 8; part++)
        for (uint32_t axis = 0; axis < 3; axis++)
            for (uint32_t z = 0; z < 4; z++) {
                brick->rank[part][axis][z] = (uint16_t)count;
                count += nsdf_mesher_popcount(brick->edges[axis][z + (part & 4)] & nsdf_part_columns(part));
            }
    brick->vertex_count = count;
}

/* Which of the 9^3 corners around the cells of a brick are negative, as rows of bits along x: [z][y]. */
typedef struct corner_rows {
    uint16_t negative[9][9];
} corner_rows;

static void gather_corners(const nsdf_mesher *mesher, const uint32_t neighbours[8], corner_rows *rows) {
    static const uint64_t no_bits[8];
    const uint64_t *negative[8];
    for (int i = 0; i < 8; i++)
        negative[i] = neighbours[i] == NSDF_NO_BRICK ? no_bits : nsdf_grid_brick(mesher, neighbours[i])->negative;
    for (int z = 0; z < 9; z++) {
        const uint64_t *const *layer = negative + (z >> 3 << 2);
        const uint64_t low = layer[0][z & 7], high = layer[1][z & 7];
        for (int y = 0; y < 8; y++)
            rows->negative[z][y] = (uint16_t)((low >> 8 * y & 0xff) | (high >> 8 * y & 1) << 8);
        rows->negative[z][8] = (uint16_t)((layer[2][z & 7] & 0xff) | (layer[3][z & 7] & 1) << 8);
    }
}

/* Bit c of the case is corner c; mesher_tables.h. */
static uint32_t case_of_cell(const corner_rows *rows, uint32_t x, uint32_t y, uint32_t z) {
    return (rows->negative[z][y] >> x & 3u) | (rows->negative[z][y + 1] >> x & 3u) << 2 |
           (rows->negative[z + 1][y] >> x & 3u) << 4 | (rows->negative[z + 1][y + 1] >> x & 3u) << 6;
}

static void count_triangles(nsdf_brick *brick, const corner_rows *rows) {
    brick->triangle_count = 0;
    for (uint32_t z = 0; z < 8; z++) {
        for (uint64_t bits = brick->crossed[z]; bits; bits &= bits - 1) {
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
        corner_rows rows;
        if (!is_crossed(nsdf_grid_brick(mesher, i))) {
            nsdf_grid_brick(mesher, i)->vertex_count = nsdf_grid_brick(mesher, i)->triangle_count = 0;
            continue;
        }
        nsdf_grid_neighbours(mesher, i, neighbours);
        gather_corners(mesher, neighbours, &rows);
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

/* Vertices of the edges around a brick's cells, by axis and the corner where they start; others are not set. */
enum { EDGE_ROW = 9, EDGE_SLICE = EDGE_ROW * EDGE_ROW, EDGE_AXIS = EDGE_SLICE * EDGE_ROW };
typedef struct edge_vertices {
    uint32_t number[3 * EDGE_AXIS];
} edge_vertices;

static uint32_t edge_slot(uint32_t axis, uint32_t x, uint32_t y, uint32_t z) {
    return axis * EDGE_AXIS + z * EDGE_SLICE + y * EDGE_ROW + x;
}

/* Where a vertex lies on its edge, between the corners with values a and b. */
static double fraction_of(double a, double b) {
    /* A border value says that the surface ends there, not where it would be. */
    const double t = a > (double)NSDF_FIELD_LIMIT ? 0 : b > (double)NSDF_FIELD_LIMIT ? 1 : a / (a - b);
    return t < least_fraction ? least_fraction : t > 1 - least_fraction ? 1 - least_fraction : t;
}

/* The vertex of the edge from corner number `local` in the brick along `axis`; values are the brick's, and those of the
 * next one along the axis. */
static void place_vertex(const nsdf_mesher *mesher, const nsdf_brick *brick, const float *const values[2],
                         uint32_t local, uint32_t axis, uint32_t vertex) {
    static const uint32_t strides[3] = {1, 8, 64};
    const uint32_t corner[3] = {local & 7, local >> 3 & 7, local >> 6}, stride = strides[axis];
    const float a = values[0][local], b = corner[axis] < 7 ? values[0][local + stride] : values[1][local - 7 * stride];
    float *position = mesher->storage->positions + 3 * (size_t)vertex;
    for (uint32_t i = 0; i < 3; i++)
        position[i] = mesher->grid.corners[i][8u * brick->at[i] + corner[i]];
    const double low = (double)position[axis];
    const double high = (double)mesher->grid.corners[axis][8u * brick->at[axis] + corner[axis] + 1];
    position[axis] = (float)(low + fraction_of((double)a, (double)b) * (high - low));
    ((uint8_t *)mesher->loose.data)[vertex] = a > NSDF_FIELD_LIMIT || b > NSDF_FIELD_LIMIT ? NSDF_VERTEX_ON_BORDER : 0;
}

static const float *values_of(const nsdf_mesher *mesher, uint32_t brick) {
    return brick == NSDF_NO_BRICK ? NULL : (const float *)mesher->values.data + (size_t)brick * NSDF_BRICK_CORNERS;
}

/* The vertices of a part of a brick, from number `vertex` on; returns the next number. */
static uint32_t place_part(const nsdf_mesher *mesher, const uint32_t neighbours[8], uint32_t part, uint32_t vertex,
                           edge_vertices *vertices) {
    const nsdf_brick *brick = nsdf_grid_brick(mesher, neighbours[0]);
    for (uint32_t axis = 0; axis < 3; axis++) {
        const float *const values[2] = {values_of(mesher, neighbours[0]), values_of(mesher, neighbours[1u << axis])};
        for (uint32_t z = part & 4, end = z + 4; z < end; z++) {
            for (uint64_t bits = brick->edges[axis][z] & nsdf_part_columns(part); bits; bits &= bits - 1) {
                const uint32_t bit = nsdf_mesher_lowest(bits);
                vertices->number[edge_slot(axis, bit & 7, bit >> 3, z)] = vertex;
                place_vertex(mesher, brick, values, 64 * z + bit, axis, vertex++);
            }
        }
    }
    return vertex;
}

static void place_vertices(const nsdf_mesher *mesher, const uint32_t neighbours[8], edge_vertices *vertices) {
    uint32_t vertex = nsdf_grid_brick(mesher, neighbours[0])->first_vertex;
    for (uint32_t part = 0; part < 8; part++)
        vertex = place_part(mesher, neighbours, part, vertex, vertices);
}

/* Of neighbour dx + 2 dy + 4 dz, the vertices with one z on edges along the faces that it shares with the brick. */
static void add_slice(const nsdf_brick *owner, uint32_t neighbour, uint32_t axis, uint32_t z, edge_vertices *vertices) {
    const uint32_t dx = neighbour & 1, dy = neighbour >> 1 & 1, dz = neighbour >> 2;
    const uint64_t side = (dx ? 0x0101010101010101u : UINT64_MAX) & (dy ? 0xffu : UINT64_MAX);
    for (uint64_t bits = owner->edges[axis][z] & side; bits; bits &= bits - 1) {
        const uint32_t bit = nsdf_mesher_lowest(bits), part = (bit >> 2 & 1) | (bit >> 5) << 1 | (z & 4);
        const uint64_t before = owner->edges[axis][z] & nsdf_part_columns(part) & (((uint64_t)1 << bit) - 1);
        vertices->number[edge_slot(axis, (bit & 7) + 8 * dx, (bit >> 3) + 8 * dy, z + 8 * dz)] =
            owner->first_vertex + owner->rank[part][axis][z & 3] + nsdf_mesher_popcount(before);
    }
}

static void add_neighbour(const nsdf_brick *owner, uint32_t neighbour, edge_vertices *vertices) {
    for (uint32_t axis = 0; axis < 3; axis++)
        for (uint32_t z = 0; !(neighbour >> axis & 1) && z < (neighbour & 4 ? 1 : 8); z++)
            add_slice(owner, neighbour, axis, z, vertices);
}

/* The triangles of the cell at x, y, z of a brick. */
static uint32_t *add_cell(const edge_vertices *vertices, const corner_rows *rows, uint32_t x, uint32_t y, uint32_t z,
                          uint32_t *indices) {
    static const uint16_t slot[12] = {0,
                                      EDGE_ROW,
                                      EDGE_SLICE,
                                      EDGE_SLICE + EDGE_ROW,
                                      EDGE_AXIS,
                                      EDGE_AXIS + 1,
                                      EDGE_AXIS + EDGE_SLICE,
                                      EDGE_AXIS + EDGE_SLICE + 1,
                                      2 * EDGE_AXIS,
                                      2 * EDGE_AXIS + 1,
                                      2 * EDGE_AXIS + EDGE_ROW,
                                      2 * EDGE_AXIS + EDGE_ROW + 1};
    const uint32_t *number = vertices->number + edge_slot(0, x, y, z);
    const uint32_t cell = case_of_cell(rows, x, y, z);
    for (uint32_t i = nsdf_mc_first[cell]; i < nsdf_mc_first[cell + 1]; i++)
        for (int k = 0; k < 3; k++)
            *indices++ = number[slot[nsdf_mc_triangles[i][k]]];
    return indices;
}

static void fill_brick(const nsdf_mesher *mesher, uint32_t index) {
    const nsdf_brick *brick = nsdf_grid_brick(mesher, index);
    uint32_t neighbours[8];
    corner_rows rows;
    edge_vertices vertices;
    nsdf_grid_neighbours(mesher, index, neighbours);
    place_vertices(mesher, neighbours, &vertices);
    for (uint32_t i = 1; i < 7; i++)
        if (neighbours[i] != NSDF_NO_BRICK)
            add_neighbour(nsdf_grid_brick(mesher, neighbours[i]), i, &vertices);
    gather_corners(mesher, neighbours, &rows);
    uint32_t *indices = mesher->storage->indices + 3 * (size_t)brick->first_triangle;
    for (uint32_t z = 0; z < 8; z++) {
        for (uint64_t bits = brick->crossed[z]; bits; bits &= bits - 1) {
            const uint32_t bit = nsdf_mesher_lowest(bits);
            indices = add_cell(&vertices, &rows, bit & 7, bit >> 3, z, indices);
        }
    }
}

static void fill_bricks(void *data, uint32_t task, uint32_t worker) {
    const nsdf_mesher *mesher = data;
    const uint32_t first = task * NSDF_BRICKS_PER_TASK;
    const uint32_t count = nsdf_min_u32(mesher->brick_count - first, NSDF_BRICKS_PER_TASK);
    (void)worker;
    for (uint32_t i = first; i < first + count; i++) {
        if (is_crossed(nsdf_grid_brick(mesher, i)))
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
