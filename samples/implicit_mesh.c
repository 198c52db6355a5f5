/* Marching tetrahedra on a body-centred cubic lattice.
 *
 * Freudenthal's triangulation cuts every cube of a grid into six tetrahedra around its main diagonal.  Squeezing space
 * to a half along that diagonal turns the grid into a body-centred cubic lattice and the tetrahedra into its congruent,
 * nearly regular ones, so triangles come out well shaped while cells keep integer coordinates.  A tetrahedron's cut is
 * never ambiguous: the result is a closed 2-manifold whatever the signs.  The lattice is turned and shifted at random,
 * so that no two frames of a sequence share connectivity. */
#include "implicit_mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEAF = 4, LEAF_NODES = LEAF + 1, MAX_NODES = (1 << 20) - 2 * LEAF };

typedef struct lattice {
    double origin[3],
        axis[3][3];     /* node (i, j, k) = origin + i axis[0] + j axis[1] + k axis[2]; positive determinant */
    int64_t count[3];   /* cells along each axis */
    double unit_radius; /* half the longest diagonal of one cell */
} lattice;

/* Vertices by the lattice edge they lie on: open addressing, a key of 0 marks a free slot. */
typedef struct edge_table {
    uint64_t *keys;
    uint32_t *vertices;
    size_t capacity, used;
} edge_table;

typedef struct extraction {
    const nsdf_implicit_field *field;
    lattice grid;
    edge_table edges;
    nsdf_implicit_mesh *mesh;
    int failed;
} extraction;

typedef struct node {
    int64_t at[3];
    double value;
} node;

static uint64_t next_random(uint64_t *state) {
    uint64_t z = *state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

static double next_unit(uint64_t *state) {
    return (double)(next_random(state) >> 11) * 0x1p-53;
}

/* Uniformly distributed rotation from a random unit quaternion (Shoemake 1992). */
static void random_rotation(uint64_t *state, double r[3][3]) {
    const double tau = 6.283185307179586;
    double u = next_unit(state), a = tau * next_unit(state), b = tau * next_unit(state);
    double x = sqrt(1 - u) * sin(a), y = sqrt(1 - u) * cos(a), z = sqrt(u) * sin(b), w = sqrt(u) * cos(b);
    const double m[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                            {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                            {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    memcpy(r, m, sizeof m);
}

static void cross(const double a[3], const double b[3], double out[3]) {
    for (int i = 0; i < 3; i++)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Half the longest of the four diagonals of a cell. */
static double cell_radius(const lattice *grid) {
    double longest = 0;
    for (int signs = 0; signs < 4; signs++) {
        double d[3];
        for (int i = 0; i < 3; i++)
            d[i] = grid->axis[0][i] + (signs & 1 ? -1 : 1) * grid->axis[1][i] + (signs & 2 ? -1 : 1) * grid->axis[2][i];
        longest = fmax(longest, sqrt(dot(d, d)));
    }
    return longest / 2;
}

static void lattice_axes(lattice *grid, double spacing, uint64_t *random) {
    double turn[3][3];
    random_rotation(random, turn);
    for (int a = 0; a < 3; a++) {
        double squeezed[3]; /* unit vector a, halved along (1, 1, 1) / sqrt(3) */
        for (int i = 0; i < 3; i++)
            squeezed[i] = spacing * ((i == a ? 1.0 : 0.0) - 1.0 / 6.0);
        for (int i = 0; i < 3; i++)
            grid->axis[a][i] = dot(turn[i], squeezed);
    }
    grid->unit_radius = cell_radius(grid);
}

/* Chooses the origin and the counts so that the box is covered, with at least a cell around it. */
static int cover_box(lattice *grid, const nsdf_implicit_field *field, uint64_t *random) {
    double normal[3][3], base[3], centre[3];
    for (int a = 0; a < 3; a++)
        cross(grid->axis[(a + 1) % 3], grid->axis[(a + 2) % 3], normal[a]);
    for (int i = 0; i < 3; i++)
        centre[i] = (field->box_min[i] + field->box_max[i]) / 2;
    for (int a = 0; a < 3; a++) {
        double reach = 0, height = dot(normal[a], grid->axis[a]);
        for (int i = 0; i < 3; i++)
            reach += fabs(normal[a][i]) * (field->box_max[i] - field->box_min[i]) / 2;
        double cells = ceil(2 * reach / height) + 3;
        if (!(cells < MAX_NODES))
            return -1;
        grid->count[a] = (int64_t)cells;
        base[a] = -reach / height - 1 - next_unit(random);
    }
    for (int i = 0; i < 3; i++)
        grid->origin[i] =
            centre[i] + base[0] * grid->axis[0][i] + base[1] * grid->axis[1][i] + base[2] * grid->axis[2][i];
    return 0;
}

static void lattice_point(const lattice *grid, double i, double j, double k, double p[3]) {
    for (int c = 0; c < 3; c++)
        p[c] = grid->origin[c] + i * grid->axis[0][c] + j * grid->axis[1][c] + k * grid->axis[2][c];
}

static size_t edge_slot(const edge_table *table, uint64_t key) {
    uint64_t state = key;
    size_t slot = (size_t)next_random(&state) & (table->capacity - 1);
    while (table->keys[slot] && table->keys[slot] != key)
        slot = (slot + 1) & (table->capacity - 1);
    return slot;
}

static int grow_edges(edge_table *table) {
    edge_table bigger = {.capacity = table->capacity ? 2 * table->capacity : 1 << 12, .used = table->used};
    bigger.keys = calloc(bigger.capacity, sizeof *bigger.keys);
    bigger.vertices = calloc(bigger.capacity, sizeof *bigger.vertices);
    if (!bigger.keys || !bigger.vertices) {
        free(bigger.keys);
        free(bigger.vertices);
        return -1;
    }
    for (size_t i = 0; i < table->capacity; i++) {
        if (!table->keys[i])
            continue;
        size_t slot = edge_slot(&bigger, table->keys[i]);
        bigger.keys[slot] = table->keys[i];
        bigger.vertices[slot] = table->vertices[i];
    }
    free(table->keys);
    free(table->vertices);
    *table = bigger;
    return 0;
}

/* Position of the zero on the edge from p to q, as a fraction: regula falsi with the Illinois rule. */
static double edge_zero(const nsdf_implicit_field *field, const double p[3], const double q[3], double fp, double fq) {
    double lo = 0, hi = 1, t = 0.5;
    const double close = 1e-3 * (fabs(fp) + fabs(fq));
    int kept = 0; /* the end that the last step kept: -1 lo, 1 hi */
    for (int step = 0; step < 30; step++) {
        t = (lo * fq - hi * fp) / (fq - fp);
        double x[3];
        for (int c = 0; c < 3; c++)
            x[c] = p[c] + t * (q[c] - p[c]);
        double f = field->value(field->user, x);
        if (fabs(f) <= close)
            break;
        if ((f < 0) == (fq < 0)) {
            hi = t;
            fq = f;
            fp /= kept == -1 ? 2 : 1;
            kept = -1;
        } else {
            lo = t;
            fp = f;
            fq /= kept == 1 ? 2 : 1;
            kept = 1;
        }
    }
    const double margin = 0.004; /* keeps triangles from collapsing when the surface runs through a node */
    return fmin(fmax(t, margin), 1 - margin);
}

static int append_vertex(extraction *x, const node *a, const node *b, uint32_t *vertex) {
    nsdf_implicit_mesh *mesh = x->mesh;
    if (mesh->vertex_count == mesh->vertex_capacity) {
        size_t capacity = mesh->vertex_capacity ? 2 * mesh->vertex_capacity : 1 << 12;
        double *positions = realloc(mesh->positions, capacity * 3 * sizeof *positions);
        if (!positions)
            return -1;
        mesh->positions = positions;
        mesh->vertex_capacity = capacity;
    }
    double p[3], q[3];
    lattice_point(&x->grid, (double)a->at[0], (double)a->at[1], (double)a->at[2], p);
    lattice_point(&x->grid, (double)b->at[0], (double)b->at[1], (double)b->at[2], q);
    double t = edge_zero(x->field, p, q, a->value, b->value);
    *vertex = (uint32_t)mesh->vertex_count++;
    for (int c = 0; c < 3; c++)
        mesh->positions[3 * *vertex + (size_t)c] = p[c] + t * (q[c] - p[c]);
    return 0;
}

/* The vertex on the edge between two nodes of a tetrahedron.  Edges run in seven directions, each a set of axes. */
static uint32_t edge_vertex(extraction *x, const node *a, const node *b) {
    uint64_t direction = 0, key = 0;
    if (a->at[0] + a->at[1] + a->at[2] > b->at[0] + b->at[1] + b->at[2]) {
        const node *swap = a;
        a = b;
        b = swap;
    }
    for (int c = 0; c < 3; c++) {
        direction |= (uint64_t)(b->at[c] - a->at[c]) << c;
        key = key << 20 | (uint64_t)a->at[c];
    }
    key = key << 3 | direction; /* direction is never 0, so neither is the key */
    edge_table *table = &x->edges;
    if (2 * table->used >= table->capacity && grow_edges(table)) {
        x->failed = 1;
        return 0;
    }
    size_t slot = edge_slot(table, key);
    if (!table->keys[slot]) {
        if (append_vertex(x, a, b, &table->vertices[slot])) {
            x->failed = 1;
            return 0;
        }
        table->keys[slot] = key;
        table->used++;
    }
    return table->vertices[slot];
}

static void append_triangle(extraction *x, uint32_t a, uint32_t b, uint32_t c) {
    nsdf_implicit_mesh *mesh = x->mesh;
    if (mesh->triangle_count == mesh->triangle_capacity) {
        size_t capacity = mesh->triangle_capacity ? 2 * mesh->triangle_capacity : 1 << 13;
        uint32_t *triangles = realloc(mesh->triangles, capacity * 3 * sizeof *triangles);
        if (!triangles) {
            x->failed = 1;
            return;
        }
        mesh->triangles = triangles;
        mesh->triangle_capacity = capacity;
    }
    uint32_t *t = mesh->triangles + 3 * mesh->triangle_count++;
    t[0] = a, t[1] = b, t[2] = c;
}

/* Cuts a positively oriented tetrahedron.  order[mask of the nodes inside] is an even permutation that puts the odd one
 * out first, or the two inside before the two outside; that fixes the orientation of the cut. */
static void cut_tetrahedron(extraction *x, const node *const corner[4]) {
    static const uint8_t order[16][4] = {
        {0},          {0, 1, 2, 3}, {1, 0, 3, 2}, {0, 1, 2, 3}, {2, 0, 1, 3}, {0, 2, 3, 1}, {1, 2, 0, 3}, {3, 0, 2, 1},
        {3, 0, 2, 1}, {0, 3, 1, 2}, {1, 3, 2, 0}, {2, 0, 1, 3}, {2, 3, 0, 1}, {1, 0, 3, 2}, {0, 1, 2, 3}, {0}};
    unsigned mask = 0, inside = 0;
    for (unsigned i = 0; i < 4; i++) {
        unsigned in = corner[i]->value < 0;
        mask |= in << i;
        inside += in;
    }
    if (inside == 0 || inside == 4)
        return;
    const node *a = corner[order[mask][0]], *b = corner[order[mask][1]];
    const node *c = corner[order[mask][2]], *d = corner[order[mask][3]];
    if (inside == 2) {
        uint32_t ac = edge_vertex(x, a, c), ad = edge_vertex(x, a, d), bd = edge_vertex(x, b, d),
                 bc = edge_vertex(x, b, c);
        append_triangle(x, ac, ad, bd);
        append_triangle(x, ac, bd, bc);
        return;
    }
    uint32_t ab = edge_vertex(x, a, b), ac = edge_vertex(x, a, c), ad = edge_vertex(x, a, d);
    if (inside == 1)
        append_triangle(x, ab, ac, ad);
    else
        append_triangle(x, ab, ad, ac);
}

/* The six tetrahedra of Freudenthal's triangulation; corner b of a cell is offset by bit c of b along axis c. */
static void cut_cell(extraction *x, const node corner[8]) {
    static const uint8_t tetrahedra[6][4] = {{0, 1, 3, 7}, {0, 5, 1, 7}, {0, 3, 2, 7},
                                             {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 6, 4, 7}};
    for (int t = 0; t < 6; t++) {
        const node *corners[4];
        for (int i = 0; i < 4; i++)
            corners[i] = &corner[tetrahedra[t][i]];
        cut_tetrahedron(x, corners);
    }
}

static void evaluate_leaf(const extraction *x, const int64_t at[3], double value[LEAF_NODES][LEAF_NODES][LEAF_NODES]) {
    for (int i = 0; i < LEAF_NODES; i++)
        for (int j = 0; j < LEAF_NODES; j++)
            for (int k = 0; k < LEAF_NODES; k++) {
                double p[3];
                lattice_point(&x->grid, (double)(at[0] + i), (double)(at[1] + j), (double)(at[2] + k), p);
                value[i][j][k] = x->field->value(x->field->user, p);
            }
}

static void visit_leaf(extraction *x, const int64_t at[3]) {
    double value[LEAF_NODES][LEAF_NODES][LEAF_NODES];
    evaluate_leaf(x, at, value);
    for (int cell = 0; cell < LEAF * LEAF * LEAF && !x->failed; cell++) {
        const int local[3] = {cell / (LEAF * LEAF), cell / LEAF % LEAF, cell % LEAF};
        node corner[8];
        int inside = 0;
        for (int b = 0; b < 8; b++) {
            const int n[3] = {local[0] + (b & 1), local[1] + (b >> 1 & 1), local[2] + (b >> 2 & 1)};
            corner[b] = (node){{at[0] + n[0], at[1] + n[1], at[2] + n[2]}, value[n[0]][n[1]][n[2]]};
            inside += corner[b].value < 0;
        }
        if (inside > 0 && inside < 8)
            cut_cell(x, corner);
    }
}

/* Visits the leaves that the surface may pass through: by the Lipschitz bound it misses a block whose centre's value is
 * larger than the bound times the block's radius. */
static void visit_block(extraction *x, const int64_t at[3], int64_t size) {
    const lattice *grid = &x->grid;
    if (x->failed || at[0] >= grid->count[0] || at[1] >= grid->count[1] || at[2] >= grid->count[2])
        return;
    double centre[3], half = (double)size / 2;
    lattice_point(grid, (double)at[0] + half, (double)at[1] + half, (double)at[2] + half, centre);
    double value = x->field->value(x->field->user, centre);
    if (fabs(value) > x->field->lipschitz * grid->unit_radius * (double)size)
        return;
    if (size == LEAF) {
        visit_leaf(x, at);
        return;
    }
    for (int b = 0; b < 8; b++) {
        const int64_t child[3] = {at[0] + (b & 1) * size / 2, at[1] + (b >> 1 & 1) * size / 2,
                                  at[2] + (b >> 2 & 1) * size / 2};
        visit_block(x, child, size / 2);
    }
}

int nsdf_implicit_extract(const nsdf_implicit_field *field, double spacing, uint64_t seed, nsdf_implicit_mesh *mesh) {
    extraction x = {.field = field, .mesh = mesh};
    mesh->vertex_count = mesh->triangle_count = 0;
    uint64_t random = seed;
    lattice_axes(&x.grid, spacing, &random);
    if (cover_box(&x.grid, field, &random))
        return -1;
    int64_t size = LEAF;
    while (size < x.grid.count[0] || size < x.grid.count[1] || size < x.grid.count[2])
        size *= 2;
    visit_block(&x, (const int64_t[3]){0, 0, 0}, size);
    free(x.edges.keys);
    free(x.edges.vertices);
    if (x.failed)
        mesh->vertex_count = mesh->triangle_count = 0;
    return x.failed ? -1 : 0;
}

void nsdf_implicit_mesh_free(nsdf_implicit_mesh *mesh) {
    free(mesh->positions);
    free(mesh->triangles);
    *mesh = (nsdf_implicit_mesh){0};
}
