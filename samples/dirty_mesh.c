#include "dirty_mesh.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void dirty_mesh_free(dirty_mesh *mesh) {
    free(mesh->positions);
    free(mesh->triangles);
    memset(mesh, 0, sizeof *mesh);
}

int dirty_mesh_add_vertex(dirty_mesh *m, double x, double y, double z) {
    if (m->vertex_count == m->vertex_capacity) {
        const size_t capacity = 2 * m->vertex_capacity + 1024;
        double *positions = realloc(m->positions, 3 * capacity * sizeof *positions);
        if (!positions)
            return -1;
        m->positions = positions;
        m->vertex_capacity = capacity;
    }
    double *p = m->positions + 3 * m->vertex_count++;
    p[0] = x;
    p[1] = y;
    p[2] = z;
    return 0;
}

int dirty_mesh_add_triangle(dirty_mesh *m, size_t a, size_t b, size_t c) {
    if (m->triangle_count == m->triangle_capacity) {
        const size_t capacity = 2 * m->triangle_capacity + 1024;
        uint32_t *triangles = realloc(m->triangles, 3 * capacity * sizeof *triangles);
        if (!triangles)
            return -1;
        m->triangles = triangles;
        m->triangle_capacity = capacity;
    }
    uint32_t *t = m->triangles + 3 * m->triangle_count++;
    t[0] = (uint32_t)a;
    t[1] = (uint32_t)b;
    t[2] = (uint32_t)c;
    return 0;
}

/* ---- Shapes ------------------------------------------------------------------------------------------------ */

const char dirty_shapes_help[] = "  sphere     of radius 1, closed\n"
                                 "  bowl       a sphere without its top: open, but more hollow than flat\n"
                                 "  sheet      a waving cloth of 2 x 2\n"
                                 "  cloak      a sheet above a sphere: something open beside something closed\n"
                                 "  twosided   a sheet whose every face is there twice, once for each side\n"
                                 "  fin        a sphere with a fin: edges of three faces\n"
                                 "  walled     a sphere with a wall inside, along edges of four faces\n"
                                 "  nested     a sphere in a sphere, both outward\n"
                                 "  crossing   two spheres that pass through each other\n"
                                 "  seams      a box of six sides that share no vertices, and do not meet at them\n"
                                 "  moebius    a band with one side\n";

enum { RINGS = 24, SEGMENTS = 48, CLOTH = 32, BAND = 64 };

/* Exactly 0 at the equator, where other pieces are joined on. */
static double height(int ring) {
    return 2 * ring == RINGS ? 0.0 : cos(3.14159265358979 * ring / RINGS);
}

/* A sphere from ring `first` on; ring 0 is the top. */
static int add_sphere(dirty_mesh *m, const double at[3], double radius, int first) {
    const size_t base = m->vertex_count;
    int failed =
        dirty_mesh_add_vertex(m, at[0], at[1], at[2] + radius) | dirty_mesh_add_vertex(m, at[0], at[1], at[2] - radius);
    for (int i = 1; i < RINGS; i++)
        for (int j = 0; j < SEGMENTS; j++) {
            const double theta = 3.14159265358979 * i / RINGS, phi = 6.28318530717959 * j / SEGMENTS;
            failed |= dirty_mesh_add_vertex(m, at[0] + radius * sin(theta) * cos(phi),
                                            at[1] + radius * sin(theta) * sin(phi), at[2] + radius * height(i));
        }
    for (int i = first; i < RINGS; i++)
        for (int j = 0; j < SEGMENTS; j++) {
            const size_t above = base + 2 + (size_t)(i - 1) * SEGMENTS, below = above + SEGMENTS;
            const size_t k = (size_t)j, next = (k + 1) % SEGMENTS;
            if (i == 0)
                failed |= dirty_mesh_add_triangle(m, base, base + 2 + k, base + 2 + next);
            else if (i + 1 == RINGS)
                failed |= dirty_mesh_add_triangle(m, above + k, base + 1, above + next);
            else
                failed |= dirty_mesh_add_triangle(m, above + k, below + k, below + next) |
                          dirty_mesh_add_triangle(m, above + k, below + next, above + next);
        }
    return failed ? -1 : 0;
}

/* A grid of (CLOTH + 1)^2 vertices over two coordinates in [0, 1]. */
static int add_grid(dirty_mesh *m, size_t rows, size_t columns,
                    void (*place)(double u, double v, double time, double xyz[3]), double time) {
    const size_t base = m->vertex_count;
    int failed = 0;
    for (size_t i = 0; i <= rows; i++)
        for (size_t j = 0; j <= columns; j++) {
            double p[3];
            place((double)i / (double)rows, (double)j / (double)columns, time, p);
            failed |= dirty_mesh_add_vertex(m, p[0], p[1], p[2]);
        }
    for (size_t i = 0; i < rows; i++)
        for (size_t j = 0; j < columns; j++) {
            const size_t a = base + i * (columns + 1) + j, b = a + columns + 1;
            failed |= dirty_mesh_add_triangle(m, a, b, b + 1) | dirty_mesh_add_triangle(m, a, b + 1, a + 1);
        }
    return failed ? -1 : 0;
}

static void place_cloth(double u, double v, double time, double p[3]) {
    p[0] = 2.0 * u - 1.0;
    p[1] = 2.0 * v - 1.0;
    p[2] = 0.2 * sin(3.0 * p[0] + 1.5 * time) + 0.1 * cos(2.0 * p[1] - time);
}

static void place_cloak(double u, double v, double time, double p[3]) {
    place_cloth(u, v, time, p);
    p[2] += 1.6;
}

static void place_fin(double u, double v, double time, double p[3]) {
    (void)time;
    const double phi = 6.28318530717959 * (3.0 + 9.0 * u) / SEGMENTS; /* along vertices of the equator */
    p[0] = (1.0 + 0.5 * v) * cos(phi);
    p[1] = (1.0 + 0.5 * v) * sin(phi);
    p[2] = 0.0;
}

/* Half of it is turned over once round: no side is another. */
static void place_band(double u, double v, double time, double p[3]) {
    const double angle = 6.28318530717959 * u, across = 0.6 * (v - 0.5), turn = 0.5 * angle;
    p[0] = (1.0 + across * cos(turn)) * cos(angle);
    p[1] = (1.0 + across * cos(turn)) * sin(angle);
    p[2] = across * sin(turn) * (1.0 + 0.1 * time);
    for (int k = 0; k < 3; k++)
        p[k] = 1e-12 * round(1e12 * p[k]); /* so that the ends meet */
}

static int add_disc(dirty_mesh *m) {
    const size_t base = m->vertex_count;
    int failed = dirty_mesh_add_vertex(m, 0.0, 0.0, 0.0);
    const double half = sin(3.14159265358979 * (RINGS / 2) / RINGS);
    for (int j = 0; j < SEGMENTS; j++) {
        const double phi = 6.28318530717959 * j / SEGMENTS;
        failed |= dirty_mesh_add_vertex(m, half * cos(phi), half * sin(phi), height(RINGS / 2));
    }
    for (size_t j = 0; j < SEGMENTS; j++)
        failed |= dirty_mesh_add_triangle(m, base, base + 1 + j, base + 1 + (j + 1) % SEGMENTS);
    return failed ? -1 : 0;
}

/* Of a side of the box with n x n squares: other sides have other numbers of them, and an edge for an edge only the
 * corners. */
static int add_side(dirty_mesh *m, int axis, double at, size_t n) {
    const size_t base = m->vertex_count;
    int failed = 0;
    for (size_t i = 0; i <= n; i++)
        for (size_t j = 0; j <= n; j++) {
            double p[3];
            p[axis] = at;
            p[(axis + 1) % 3] = 2.0 * (double)i / (double)n - 1.0;
            p[(axis + 2) % 3] = 2.0 * (double)j / (double)n - 1.0;
            failed |= dirty_mesh_add_vertex(m, p[0], p[1], p[2]);
        }
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++) {
            const size_t a = base + i * (n + 1) + j, b = a + n + 1;
            const int out = at > 0.0;
            failed |= dirty_mesh_add_triangle(m, a, out ? b : b + 1, out ? b + 1 : b) |
                      dirty_mesh_add_triangle(m, a, out ? b + 1 : a + 1, out ? a + 1 : b + 1);
        }
    return failed ? -1 : 0;
}

static int add_seams(dirty_mesh *m) {
    int failed = 0;
    for (int axis = 0; axis < 3; axis++)
        failed |= add_side(m, axis, 1.0, 8 + 3 * (size_t)axis) | add_side(m, axis, -1.0, 9 + 2 * (size_t)axis);
    return failed;
}

static int add_two_sided(dirty_mesh *m, double time) {
    int failed = add_grid(m, CLOTH, CLOTH, place_cloth, time);
    for (size_t i = 0, n = m->triangle_count; i < n && !failed; i++)
        failed = dirty_mesh_add_triangle(m, m->triangles[3 * i], m->triangles[3 * i + 2], m->triangles[3 * i + 1]);
    return failed;
}

int dirty_shape(const char *name, double time, dirty_mesh *m) {
    const double middle[3] = {0.1 * sin(3.0 * time), 0.0, 0.0}, aside[3] = {0.1 * sin(3.0 * time) + 1.2, 0.3, 0.1};
    const double still[3] = {0.0, 0.0, 0.0};
    if (strcmp(name, "sphere") == 0)
        return add_sphere(m, middle, 1.0, 0);
    if (strcmp(name, "bowl") == 0)
        return add_sphere(m, middle, 1.0, RINGS / 2 - 1);
    if (strcmp(name, "sheet") == 0)
        return add_grid(m, CLOTH, CLOTH, place_cloth, time);
    if (strcmp(name, "cloak") == 0)
        return add_sphere(m, middle, 1.0, 0) | add_grid(m, CLOTH, CLOTH, place_cloak, time);
    if (strcmp(name, "twosided") == 0)
        return add_two_sided(m, time);
    if (strcmp(name, "fin") == 0)
        return add_sphere(m, still, 1.0, 0) | add_grid(m, 9, 4, place_fin, time);
    if (strcmp(name, "walled") == 0)
        return add_sphere(m, still, 1.0, 0) | add_disc(m);
    if (strcmp(name, "nested") == 0)
        return add_sphere(m, middle, 1.0, 0) | add_sphere(m, middle, 0.5, 0);
    if (strcmp(name, "crossing") == 0)
        return add_sphere(m, middle, 1.0, 0) | add_sphere(m, aside, 0.8, 0);
    if (strcmp(name, "seams") == 0)
        return add_seams(m);
    if (strcmp(name, "moebius") == 0)
        return add_grid(m, BAND, 6, place_band, time);
    return 1;
}

/* ---- Faults ------------------------------------------------------------------------------------------------ */

const char dirty_faults_help[] = "  flip=S        turn a share of the faces round\n"
                                 "  remove=S      leave a share of the faces out\n"
                                 "  split         give each face vertices of its own\n"
                                 "  broken        flip=0.1 remove=0.01 split\n"
                                 "  inward        turn all faces round\n"
                                 "  duplicate=S   have a share of the faces twice, every other of them turned round\n"
                                 "  sliver=S      put a face without area on an edge of a share of the faces\n"
                                 "  unused=N      add N vertices that no face uses\n"
                                 "  nan=N         the same, and they are not numbers\n"
                                 "  badnan        make a vertex of the first face not a number\n"
                                 "  scale=F       other units: everything times F\n"
                                 "  order         the faces in another order\n";

/* Of a face or vertex: uniform in [0, 1), the same for the same seed. */
static double chance(uint64_t seed, uint64_t number, uint64_t fault) {
    uint64_t x = seed * UINT64_C(0x9e3779b97f4a7c15) + number * UINT64_C(0xbf58476d1ce4e5b9) + fault;
    for (int i = 0; i < 3; i++) {
        x ^= x >> 29;
        x *= UINT64_C(0x94d049bb133111eb);
        x ^= x >> 32;
    }
    return (double)(x >> 11) * 0x1p-53;
}

static void flip(dirty_mesh *m, size_t i) {
    const uint32_t t = m->triangles[3 * i + 1];
    m->triangles[3 * i + 1] = m->triangles[3 * i + 2];
    m->triangles[3 * i + 2] = t;
}

static int apply_flip(dirty_mesh *m, uint64_t seed, double share) {
    for (size_t i = 0; i < m->triangle_count; i++)
        if (chance(seed, i, 1) < share)
            flip(m, i);
    return 0;
}

static int apply_remove(dirty_mesh *m, uint64_t seed, double share) {
    size_t kept = 0;
    for (size_t i = 0; i < m->triangle_count; i++)
        if (!(chance(seed, i, 2) < share))
            memmove(m->triangles + 3 * kept++, m->triangles + 3 * i, 3 * sizeof *m->triangles);
    m->triangle_count = kept;
    return 0;
}

static int apply_split(dirty_mesh *m, uint64_t seed, double amount) {
    dirty_mesh split = {0};
    int failed = 0;
    (void)seed;
    (void)amount;
    for (size_t i = 0; i < m->triangle_count && !failed; i++) {
        const size_t first = split.vertex_count;
        for (size_t k = 0; k < 3 && !failed; k++) {
            const double *p = m->positions + 3 * (size_t)m->triangles[3 * i + k];
            failed = dirty_mesh_add_vertex(&split, p[0], p[1], p[2]);
        }
        failed = failed ? failed : dirty_mesh_add_triangle(&split, first, first + 1, first + 2);
    }
    dirty_mesh_free(failed ? &split : m);
    *m = failed ? *m : split;
    return failed;
}

static int apply_duplicate(dirty_mesh *m, uint64_t seed, double share) {
    int failed = 0;
    for (size_t i = 0, n = m->triangle_count; i < n && !failed; i++)
        if (chance(seed, i, 3) < share) {
            const uint32_t t[3] = {m->triangles[3 * i], m->triangles[3 * i + 1], m->triangles[3 * i + 2]};
            failed =
                i % 2 ? dirty_mesh_add_triangle(m, t[0], t[1], t[2]) : dirty_mesh_add_triangle(m, t[0], t[2], t[1]);
        }
    return failed;
}

static int apply_sliver(dirty_mesh *m, uint64_t seed, double share) {
    int failed = 0;
    for (size_t i = 0, n = m->triangle_count; i < n && !failed; i++)
        if (chance(seed, i, 4) < share)
            failed = dirty_mesh_add_triangle(m, m->triangles[3 * i], m->triangles[3 * i + 1], m->triangles[3 * i]);
    return failed;
}

static int apply_unused(dirty_mesh *m, uint64_t seed, double count) {
    int failed = 0;
    for (int i = 0; i < count && !failed; i++)
        failed = dirty_mesh_add_vertex(m, 1e3 * chance(seed, (uint64_t)i, 5), -7.0, 1e4);
    return failed;
}

static int apply_nan(dirty_mesh *m, uint64_t seed, double count) {
    int failed = 0;
    (void)seed;
    for (int i = 0; i < count && !failed; i++)
        failed = dirty_mesh_add_vertex(m, NAN, 0.0, INFINITY);
    return failed;
}

static int apply_bad_nan(dirty_mesh *m, uint64_t seed, double amount) {
    (void)seed;
    (void)amount;
    m->positions[3 * (size_t)m->triangles[0]] = NAN;
    return 0;
}

static int apply_scale(dirty_mesh *m, uint64_t seed, double factor) {
    (void)seed;
    for (size_t i = 0; i < 3 * m->vertex_count; i++)
        m->positions[i] *= factor;
    return 0;
}

static int apply_order(dirty_mesh *m, uint64_t seed, double amount) {
    (void)amount;
    for (size_t i = m->triangle_count; i > 1; i--) {
        const size_t j = (size_t)(chance(seed, i, 6) * (double)i);
        uint32_t t[3];
        memcpy(t, m->triangles + 3 * (i - 1), sizeof t);
        memcpy(m->triangles + 3 * (i - 1), m->triangles + 3 * j, sizeof t);
        memcpy(m->triangles + 3 * j, t, sizeof t);
    }
    return 0;
}

static int apply_broken(dirty_mesh *m, uint64_t seed, double amount) {
    (void)amount;
    return apply_flip(m, seed, 0.1) | apply_remove(m, seed, 0.01) | apply_split(m, seed, 0.0);
}

int dirty_apply(const char *fault, uint64_t seed, dirty_mesh *mesh) {
    static const struct {
        const char *name;
        int (*apply)(dirty_mesh *m, uint64_t seed, double amount);
        double low, high; /* of the amount; none where both are 0 */
    } faults[] = {{"flip", apply_flip, 0.0, 1.0},      {"remove", apply_remove, 0.0, 0.99},
                  {"split", apply_split, 0.0, 0.0},    {"broken", apply_broken, 0.0, 0.0},
                  {"inward", NULL, 0.0, 0.0},          {"duplicate", apply_duplicate, 0.0, 1.0},
                  {"sliver", apply_sliver, 0.0, 1.0},  {"unused", apply_unused, 0.0, 1e6},
                  {"nan", apply_nan, 0.0, 1e6},        {"badnan", apply_bad_nan, 0.0, 0.0},
                  {"scale", apply_scale, 1e-30, 1e30}, {"order", apply_order, 0.0, 0.0}};
    const size_t length = strcspn(fault, "=");
    char *end = NULL;
    const double amount = fault[length] ? strtod(fault + length + 1, &end) : 0.0;
    for (size_t i = 0; i < sizeof faults / sizeof *faults; i++) {
        if (strlen(faults[i].name) != length || strncmp(faults[i].name, fault, length) != 0)
            continue;
        const int has_amount = faults[i].high > 0.0;
        if (has_amount != (fault[length] != '\0') || (has_amount && (*end || end == fault + length + 1)) ||
            (has_amount && !(amount >= faults[i].low && amount <= faults[i].high)))
            return 1;
        return faults[i].apply ? faults[i].apply(mesh, seed, amount) : apply_flip(mesh, seed, 1.0);
    }
    return 1;
}
