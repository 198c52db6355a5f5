#include "repair/thicken.h"

#include "triangle.h"

#include <stdlib.h>
#include <string.h>

/* At creases vertices are moved further, to keep the thickness between the faces, but by no more than 1 / this. */
static const double least_cosine = 0.6;

typedef struct {
    const nsdf_surface *surface;
    const uint32_t *weld;
    const nsdf_mates *mates;
    const nsdf_patches *patches;
    nsdf_thick *thick;
    uint32_t *root;    /* [corner]: one for all corners of a vertex that hang together; forest of a union-find */
    uint32_t *number;  /* [corner]: of a root's vertex among the new ones */
    nsdf_vec3 *normal; /* [corner]: of a root: sum of angle times normal */
    double *angle;     /* [corner]: of a root */
} thickener;

static int in_sheet(const thickener *t, uint32_t triangle) {
    const uint32_t patch = t->patches->of[triangle];
    return patch != NSDF_NO_PATCH && t->patches->patches[patch].is_sheet;
}

static uint32_t root_of(uint32_t *root, uint32_t corner) {
    while (root[corner] != corner)
        corner = root[corner] = root[root[corner]];
    return corner;
}

static uint32_t next_corner(uint32_t half) {
    return half % 3 == 2 ? half - 2 : half + 1;
}

/* Whether both triangles of an edge face the same way once they are turned. */
static int agree(const thickener *t, uint32_t half, uint32_t mate) {
    const int alike = nsdf_half_edge_from(t->surface, t->weld, half) != nsdf_half_edge_from(t->surface, t->weld, mate);
    return alike == (t->patches->turned[half / 3] == t->patches->turned[mate / 3]);
}

/* Whether the sheet ends at an edge. */
static int is_rim(const thickener *t, uint32_t half) {
    return t->mates->mate[half] >= NSDF_MATE_SKIP || !agree(t, half, t->mates->mate[half]);
}

/* Corners around a vertex hang together across edges that are no rims: where parts only touch, each has its own. */
static void join_corners(thickener *t) {
    const uint32_t halves = 3 * t->surface->triangle_count;
    for (uint32_t h = 0; h < halves; h++)
        t->root[h] = h;
    for (uint32_t h = 0; h < halves; h++) {
        const uint32_t mate = t->mates->mate[h];
        if (!in_sheet(t, h / 3) || mate >= h || is_rim(t, h))
            continue;
        const int same = nsdf_half_edge_from(t->surface, t->weld, h) == nsdf_half_edge_from(t->surface, t->weld, mate);
        const uint32_t ends[2] = {same ? mate : next_corner(mate), same ? next_corner(mate) : mate};
        t->root[root_of(t->root, h)] = root_of(t->root, ends[0]);
        t->root[root_of(t->root, next_corner(h))] = root_of(t->root, ends[1]);
    }
}

static void sum_normals(thickener *t) {
    for (uint32_t i = 0; i < t->surface->triangle_count; i++) {
        const nsdf_triangle triangle = nsdf_triangle_load(t->surface, i);
        if (!in_sheet(t, i) || !nsdf_triangle_has_area(&triangle))
            continue;
        const double sign = nsdf_is_turned(t->patches, i) ? -1.0 : 1.0;
        const nsdf_vec3 normal = nsdf_triangle_normal(&triangle);
        for (uint32_t k = 0; k < 3; k++) {
            const uint32_t root = root_of(t->root, 3 * i + k);
            const double angle = nsdf_triangle_angle(&triangle, (int)k);
            t->normal[root] = nsdf_vec3_mad(t->normal[root], sign * angle, normal);
            t->angle[root] += angle;
        }
    }
}

/* A vertex above and one below. */
static void place_vertex(thickener *t, uint32_t root, double half) {
    const nsdf_vec3 at = nsdf_vec3_load(t->surface->positions + 3 * (size_t)t->surface->indices[root]);
    const double length = nsdf_vec3_length(t->normal[root]);
    const double cosine = t->angle[root] > 0.0 ? fmax(length / t->angle[root], least_cosine) : 1.0;
    const nsdf_vec3 off = nsdf_vec3_scale(length > 0.0 ? half / (cosine * length) : 0.0, t->normal[root]);
    float *to = t->thick->positions + 3 * (size_t)t->thick->vertex_count;
    for (int side = 0; side < 2; side++) {
        const nsdf_vec3 x = nsdf_vec3_mad(at, side ? -1.0 : 1.0, off);
        to[3 * side] = (float)x.x;
        to[3 * side + 1] = (float)x.y;
        to[3 * side + 2] = (float)x.z;
    }
    t->number[root] = t->thick->vertex_count;
    t->thick->vertex_count += 2;
}

static void add_triangle(nsdf_thick *thick, uint32_t a, uint32_t b, uint32_t c) {
    uint32_t *to = thick->indices + 3 * (size_t)thick->triangle_count++;
    to[0] = a;
    to[1] = b;
    to[2] = c;
}

static void add_sides(thickener *t, uint32_t triangle) {
    uint32_t v[3];
    const uint32_t second = nsdf_is_turned(t->patches, triangle) ? 2 : 1;
    const uint32_t corners[3] = {3 * triangle, 3 * triangle + second, 3 * triangle + 3 - second};
    for (int k = 0; k < 3; k++)
        v[k] = t->number[root_of(t->root, corners[k])];
    add_triangle(t->thick, v[0], v[1], v[2]);
    add_triangle(t->thick, v[0] + 1, v[2] + 1, v[1] + 1);
}

static void add_rim(thickener *t, uint32_t half) {
    uint32_t a = t->number[root_of(t->root, half)], b = t->number[root_of(t->root, next_corner(half))];
    if (nsdf_is_turned(t->patches, half / 3)) {
        const uint32_t swapped = a;
        a = b;
        b = swapped;
    }
    add_triangle(t->thick, b, a, a + 1);
    add_triangle(t->thick, b, a + 1, b + 1);
}

static int create_thick(thickener *t) {
    const size_t halves = 3 * (size_t)t->surface->triangle_count;
    size_t corners = 0, rims = 0;
    for (uint32_t h = 0; h < halves; h++) {
        corners += (size_t)in_sheet(t, h / 3);
        rims += in_sheet(t, h / 3) && is_rim(t, h);
    }
    t->thick->positions = malloc((6 * corners + 1) * sizeof(float));
    t->thick->indices = malloc((6 * (corners / 3 + rims) + 1) * sizeof(uint32_t));
    t->root = malloc((halves + 1) * sizeof *t->root);
    t->number = malloc((halves + 1) * sizeof *t->number);
    t->normal = calloc(halves + 1, sizeof *t->normal);
    t->angle = calloc(halves + 1, sizeof *t->angle);
    return t->thick->positions && t->thick->indices && t->root && t->number && t->normal && t->angle ? 0 : -1;
}

static void build(thickener *t, double half) {
    const uint32_t halves = 3 * t->surface->triangle_count;
    join_corners(t);
    sum_normals(t);
    for (uint32_t h = 0; h < halves; h++)
        if (in_sheet(t, h / 3) && root_of(t->root, h) == h)
            place_vertex(t, h, half);
    for (uint32_t i = 0; i < t->surface->triangle_count; i++)
        if (in_sheet(t, i))
            add_sides(t, i);
    for (uint32_t h = 0; h < halves; h++)
        if (in_sheet(t, h / 3) && is_rim(t, h))
            add_rim(t, h);
}

int nsdf_thicken_sheets(nsdf_thick *thick, const nsdf_surface *surface, const uint32_t *weld, const nsdf_mates *mates,
                        const nsdf_patches *patches, double thickness) {
    thickener t = {surface, weld, mates, patches, thick, NULL, NULL, NULL, NULL};
    memset(thick, 0, sizeof *thick);
    const int failed = create_thick(&t) != 0;
    if (!failed)
        build(&t, 0.5 * thickness);
    free(t.root);
    free(t.number);
    free(t.normal);
    free(t.angle);
    return failed ? -1 : 0;
}

void nsdf_thick_free(nsdf_thick *thick) {
    free(thick->positions);
    free(thick->indices);
    memset(thick, 0, sizeof *thick);
}
