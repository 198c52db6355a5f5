/* Inner parts of the mesher.
 *
 * The grid's cells are grouped in bricks of 8^3.  A brick owns the 8^3 corners at the lower ends of its cells, and the
 * grid edges that start at them; the corners and edges at its upper faces belong to its neighbours.  Bricks exist
 * where cells are active or where such corners are needed.  Sets of corners, cells or edges of a brick are bit masks:
 * one word for each z, bit 8 * y + x.
 *
 * A corner's sign may be known without its value, from a value nearby that is too large for a change of sign between
 * them.  Values are needed at the corners of cells that the surface crosses only.
 *
 * The corners on the border of the grid count as outside, which closes surfaces that leave the domain. */
#ifndef NSDF_MESHER_INTERNAL_H
#define NSDF_MESHER_INTERNAL_H

#include "mesher.h"

enum {
    NSDF_BRICK_SIDE = 8,
    NSDF_BRICK_CORNERS = 512,
    NSDF_MESHER_BATCH = 10 * 48, /* points in one call of field.evaluate */
    NSDF_BRICKS_PER_TASK = 16,
    NSDF_MESHER_MAX_RESOLUTION = 4096
};
#define NSDF_NO_BRICK UINT32_MAX
#define NSDF_NO_VERTEX UINT32_MAX

typedef struct nsdf_brick {
    uint64_t cells[8];      /* active: looked at for triangles */
    uint64_t crossed[8];    /* cells that have known corners of both signs */
    uint64_t evaluated[8];  /* corners whose value is there, or asked for */
    uint64_t known[8];      /* corners whose sign is there, or asked for */
    uint64_t negative[8];   /* known corners inside the surface */
    uint64_t wanted[8];     /* corners that are asked for next */
    uint64_t far[2][3][4];  /* [inside][n][z / 2] centres of cubes of two cells, at odd coordinates: those whose sign
                               holds for the corners that differ from them by one in up to n + 1 coordinates */
    uint64_t edges[3][8];   /* [axis][z] edges with a vertex */
    uint16_t rank[8][3][4]; /* [part][axis][z % 4] vertices of the brick before those of edges[axis][z] there */
    uint32_t first_vertex, vertex_count;
    uint32_t first_triangle, triangle_count;
    uint32_t first_point, point_count; /* of its corners in the list of points */
    uint16_t at[3];                    /* position in the grid of bricks */
    uint8_t fresh;                     /* corners became known since the bricks were looked at */
    uint8_t upper, lower;              /* bit dx + 2 dy + 4 dz: neighbours that its cells, or mixed sides, need */
} nsdf_brick;

/* A corner whose value is wanted. */
typedef struct nsdf_grid_point {
    uint16_t at[3];
} nsdf_grid_point;

typedef struct nsdf_cube {
    uint16_t at[3]; /* its lowest cell */
} nsdf_cube;

typedef struct nsdf_array {
    void *data;
    uint64_t capacity; /* elements */
} nsdf_array;

typedef struct nsdf_grid {
    uint32_t cells[3], bricks[3];
    double step;       /* length of a cell's side */
    float *corners[3]; /* [axis][cells + 1] coordinates */
} nsdf_grid;

/* Scratch memory of a worker, for one batch. */
typedef struct nsdf_mesher_scratch {
    float point[3][NSDF_MESHER_BATCH], value[NSDF_MESHER_BATCH], slope[3][NSDF_MESHER_BATCH]; /* of one evaluation */
    float position[3][NSDF_MESHER_BATCH], start[3][NSDF_MESHER_BATCH];
    float distance[NSDF_MESHER_BATCH], gradient[3][NSDF_MESHER_BATCH];
    float travel[NSDF_MESHER_BATCH]; /* since the gradient was evaluated */
    float damping[NSDF_MESHER_BATCH];
    float low[NSDF_MESHER_BATCH], high[NSDF_MESHER_BATCH];      /* of the part of a grid edge where the sign changes */
    uint8_t axis[NSDF_MESHER_BATCH], inside[NSDF_MESHER_BATCH]; /* of that edge, and whether its low end is */
    uint32_t list[NSDF_MESHER_BATCH];
    int32_t chosen[NSDF_MESHER_BATCH]; /* 1 for the vertices that are to be listed, else 0 */
    uint64_t evaluated;                /* points of vertices */
} nsdf_mesher_scratch;

struct nsdf_mesher {
    nsdf_memory *memory;
    nsdf_tasks *tasks;
    nsdf_grid grid;
    uint32_t brick_count;
    uint32_t looked_at; /* bricks there were when they were looked at last */
    uint64_t point_count, cube_count;
    uint32_t measuring; /* 0, or the points are centres of cubes of so many cells, of which those at the border of the
                           grid need values, the others their size only */
    nsdf_array coordinates;     /* float: the grid's corners[] point into it */
    nsdf_array table;           /* uint32_t [bricks z][y][x]: number of the brick there, or NSDF_NO_BRICK */
    nsdf_array bricks;          /* nsdf_brick, in the order of creation */
    nsdf_array order;           /* uint32_t: the bricks in the order of the table, which is that of the mesh */
    nsdf_array values;          /* float [brick][512]: field at the corners that are evaluated */
    nsdf_array points;          /* nsdf_grid_point: to be evaluated */
    nsdf_array point_values;    /* float */
    nsdf_array exact;           /* uint8_t: of measured points, whether they have their value; of cubes more */
    nsdf_array cubes, split;    /* nsdf_cube: those of one size, and of the next */
    nsdf_array loose;           /* uint8_t [vertex]: 0 = on the zero set, see NSDF_VERTEX_... */
    nsdf_array links, pieces;   /* uint32_t [vertex] and boxes, while pieces are found */
    nsdf_array scratch;         /* nsdf_mesher_scratch [worker] */
    const nsdf_mesher_job *job; /* of the run under way */
    nsdf_mesh_storage *storage;
    nsdf_memory *storage_memory;
    uint32_t batch;     /* of the points in the list, so many a task */
    uint64_t evaluated; /* points of the grid */
    uint32_t slice;     /* tasks between two questions whether to cancel */
    nsdf_mesher_stats stats;
};

enum {
    NSDF_VERTEX_ON_BORDER = 1,  /* of a cap at the border of the domain: stays where it is, normal from the faces */
    NSDF_VERTEX_NO_GRADIENT = 2 /* normal from the faces */
};

/* The value that stands for "outside" at border corners where the field is negative; other values are clamped to
 * +-NSDF_FIELD_LIMIT. */
#define NSDF_FIELD_LIMIT 1e30f
#define NSDF_BORDER_VALUE 2e30f

static inline uint32_t nsdf_mesher_popcount(uint64_t bits) {
    bits -= bits >> 1 & 0x5555555555555555u;
    bits = (bits & 0x3333333333333333u) + (bits >> 2 & 0x3333333333333333u);
    bits = (bits + (bits >> 4)) & 0x0f0f0f0f0f0f0f0fu;
    return (uint32_t)(bits * 0x0101010101010101u >> 56);
}

/* Number of the lowest bit that is set; bits != 0. */
static inline uint32_t nsdf_mesher_lowest(uint64_t bits) {
#ifdef __GNUC__
    return (uint32_t)__builtin_ctzll(bits);
#else
    return nsdf_mesher_popcount((bits & (0 - bits)) - 1);
#endif
}

static inline uint32_t nsdf_min_u32(uint32_t a, uint32_t b) {
    return a < b ? a : b;
}

/* mesher.c */

/* Room for `count` elements, the first `used` kept. */
nsdf_status nsdf_mesher_reserve(nsdf_mesher *mesher, nsdf_array *array, uint64_t count, uint64_t used,
                                size_t element_size);
/* fn(mesher, i, worker) for every i < count, asking for cancellation every few milliseconds. */
nsdf_status nsdf_mesher_parallel(nsdf_mesher *mesher, uint64_t count, nsdf_task_fn fn);
/* The same for tasks that are NSDF_BRICKS_PER_TASK bricks each, from number task * NSDF_BRICKS_PER_TASK on. */
nsdf_status nsdf_mesher_for_bricks(nsdf_mesher *mesher, nsdf_task_fn fn);
/* For loops that are not parallel, with the number of the step: every so many steps asks whether to cancel. */
nsdf_status nsdf_mesher_ask(const nsdf_mesher *mesher, uint64_t step, uint32_t every);

/* mesher_grid.c */

/* Sizes and coordinates of the grid; no bricks. */
nsdf_status nsdf_grid_begin(nsdf_mesher *mesher);
static inline nsdf_brick *nsdf_grid_brick(const nsdf_mesher *mesher, uint32_t index) {
    return (nsdf_brick *)mesher->bricks.data + index;
}

/* The brick at a position in the grid of bricks, or NSDF_NO_BRICK. */
uint32_t nsdf_grid_brick_at(const nsdf_mesher *mesher, uint32_t x, uint32_t y, uint32_t z);
/* The same, made without active cells where there was none. */
nsdf_status nsdf_grid_need_brick(nsdf_mesher *mesher, uint32_t x, uint32_t y, uint32_t z, uint32_t *brick);
/* The bricks that hold the corners of a brick's cells: itself and the neighbours at its upper faces, number dx +
 * 2 dy + 4 dz; NSDF_NO_BRICK where there is none. */
void nsdf_grid_neighbours(const nsdf_mesher *mesher, uint32_t brick, uint32_t neighbours[8]);
/* A brick itself and the neighbours at its lower faces, number dx + 2 dy + 4 dz; one without anything where there is
 * none. */
void nsdf_grid_lower(const nsdf_mesher *mesher, uint32_t brick, const nsdf_brick *lower[8]);
/* Makes the neighbours that bricks say they need, and clears what they say. */
nsdf_status nsdf_grid_need_neighbours(nsdf_mesher *mesher);
/* Which upper neighbours hold corners of a brick's active cells. */
uint8_t nsdf_brick_upper(const nsdf_brick *brick);
/* Values of all points in the list, to point_values. */
nsdf_status nsdf_grid_evaluate_points(nsdf_mesher *mesher);
/* A value that was evaluated, at a corner of a brick: kept as it counts, see NSDF_BORDER_VALUE, with its sign. */
void nsdf_grid_store(const nsdf_mesher *mesher, uint32_t brick, const uint16_t at[3], float value);

/* mesher_levels.c: makes the bricks, with the cells that may have the surface in them active. */
nsdf_status nsdf_mesher_find_cells(nsdf_mesher *mesher);

/* mesher_signs.c */

/* The value at the centre of a cube of two cells in a brick: kept, and used for the signs of corners around it. */
void nsdf_mesher_add_centre(const nsdf_mesher *mesher, uint32_t brick, const uint16_t at[3], float value);
/* The signs of a brick's corners that follow from centres in it and its lower neighbours. */
void nsdf_mesher_claim_signs(const nsdf_mesher *mesher, uint32_t brick);

/* mesher_corners.c: finds the signs of all corners of the active cells, and the values at the ends of all edges on
 * which they change; cells beside them that turn out to have the surface in them become active, so that it is closed
 * even where the bound does not hold. */
nsdf_status nsdf_mesher_evaluate_corners(nsdf_mesher *mesher);

/* A brick's parts are its eighths, number x / 4 + 2 (y / 4) + 4 (z / 4): the bits of one in any z of it. */
static inline uint64_t nsdf_part_columns(uint32_t part) {
    return (uint64_t)0x0f0f0f0f << (4 * (part & 1) + 32 * (part >> 1 & 1));
}

/* Sets of a brick's corners, by one z: `cells` and those one further along x, or y; what comes from the brick below
 * along that axis is in `lower`. */
#define NSDF_COLUMN_7 0x8080808080808080u
static inline uint64_t nsdf_step_x(uint64_t set, uint64_t lower) {
    return (set & ~NSDF_COLUMN_7) << 1 | (lower & NSDF_COLUMN_7) >> 7;
}
static inline uint64_t nsdf_step_y(uint64_t set, uint64_t lower) {
    return set << 8 | lower >> 56;
}

/* mesher_cells.c: vertices on the edges (normalised, in storage->positions) and the triangles. */
nsdf_status nsdf_mesher_make_triangles(nsdf_mesher *mesher);

/* mesher_pieces.c: leaves out the pieces below job->smallest_piece. */
nsdf_status nsdf_mesher_drop_pieces(nsdf_mesher *mesher);

/* mesher_vertices.c: moves the vertices onto the zero set, makes the normals, goes to world units. */
nsdf_status nsdf_mesher_finish_vertices(nsdf_mesher *mesher);

#endif
