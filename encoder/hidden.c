#include "hidden.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <math.h>

#include "edge_table.h"
#include "sdf.h"
#include "surface_error.h"
#include "triangle.h"
#include "weld.h"

static size_t indices_size(const nsdf_surface *s) {
    return 3 * sizeof(uint32_t) * ((size_t)s->triangle_count + 1);
}

/* Appends a triangle to the indices of a part. */
static void take(nsdf_surface *part, const nsdf_surface *from, uint32_t triangle) {
    memcpy(part->indices + 3 * (size_t)part->triangle_count++, from->indices + 3 * (size_t)triangle,
           3 * sizeof(uint32_t));
}

/* ---- Bodies --------------------------------------------------------------------------------------------- */

static void mark_open(const nsdf_surface *s, const nsdf_edge_table *edges, const uint32_t *weld, bool *open_vertex) {
    for (size_t i = 0; i < edges->slot_count; i++)
        if (edges->slots[i].up != edges->slots[i].down)
            open_vertex[edges->slots[i].low] = true;
    for (uint32_t v = 0; v < s->vertex_count; v++)
        open_vertex[v] = open_vertex[weld[v]];
}

/* A piece with an open edge has one of its vertices marked. */
static void take_closed(const nsdf_surface *s, const uint32_t *piece, const bool *open_vertex, bool *open_piece,
                        nsdf_surface *bodies) {
    for (size_t i = 0; i < 3 * (size_t)s->triangle_count; i++)
        open_piece[piece[i / 3]] |= open_vertex[s->indices[i]];
    for (uint32_t i = 0; i < s->triangle_count; i++)
        if (!open_piece[piece[i]])
            take(bodies, s, i);
}

static void turn(nsdf_surface *s) {
    for (size_t i = 0; i < s->triangle_count; i++) {
        uint32_t *t = s->indices + 3 * i, second = t[1];
        t[1] = t[2];
        t[2] = second;
    }
}

int nsdf_find_bodies(const nsdf_surface *surface, nsdf_surface *bodies) {
    const size_t vertices = (size_t)surface->vertex_count + 1, triangles = (size_t)surface->triangle_count + 1;
    nsdf_surface found = {surface->positions, malloc(indices_size(surface)), surface->vertex_count, 0};
    uint32_t *weld = malloc(vertices * sizeof *weld), *piece = malloc(triangles * sizeof *piece);
    bool *open_vertex = calloc(vertices, sizeof *open_vertex), *open_piece = calloc(triangles, sizeof *open_piece);
    nsdf_edge_table edges = {NULL, 0};
    const bool failed = !found.indices || !weld || !piece || !open_vertex || !open_piece ||
                        nsdf_weld_vertices(surface, weld) != 0 || nsdf_edge_table_build(&edges, surface, weld) != 0 ||
                        nsdf_surface_components(surface, piece) < 0;
    if (!failed) {
        mark_open(surface, &edges, weld, open_vertex);
        take_closed(surface, piece, open_vertex, open_piece, &found);
        if (nsdf_surface_volume(&found) < 0.0)
            turn(&found);
        *bodies = found;
    } else {
        free(found.indices);
    }
    nsdf_edge_table_free(&edges);
    free(open_piece);
    free(open_vertex);
    free(piece);
    free(weld);
    return failed ? -1 : 0;
}

/* ---- What they hide ------------------------------------------------------------------------------------- */

/* How far from a triangle its two sides are looked at (normalised). */
static const float step_out = 1e-4f;

static bool is_inside(const nsdf_sdf *bodies, const float middle[3], const float normal[3], float step) {
    float p[3];
    for (int k = 0; k < 3; k++)
        p[k] = middle[k] + step * normal[k];
    return nsdf_sdf_winding(bodies, p) > 0.5f;
}

static bool is_hidden(const nsdf_sdf *bodies, const nsdf_surface *s, uint32_t triangle) {
    const uint32_t *t = s->indices + 3 * (size_t)triangle;
    const float *a = s->positions + 3 * (size_t)t[0], *b = s->positions + 3 * (size_t)t[1],
                *c = s->positions + 3 * (size_t)t[2];
    float u[3], v[3], n[3], middle[3];
    for (int k = 0; k < 3; k++) {
        u[k] = b[k] - a[k];
        v[k] = c[k] - a[k];
        middle[k] = (a[k] + b[k] + c[k]) / 3.0f;
    }
    for (int k = 0; k < 3; k++)
        n[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
    const float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (!(length > 0.0f))
        return false;
    for (int k = 0; k < 3; k++)
        n[k] /= length;
    return is_inside(bodies, middle, n, step_out) && is_inside(bodies, middle, n, -step_out);
}

static bool hides_any(const nsdf_sdf *bodies, const nsdf_surface *s, uint32_t step) {
    for (uint64_t i = 0; i < s->triangle_count; i += step)
        if (is_hidden(bodies, s, (uint32_t)i))
            return true;
    return false;
}

static int take_outer(const nsdf_sdf *bodies, const nsdf_surface *s, nsdf_surface *outer) {
    nsdf_surface found = {s->positions, malloc(indices_size(s)), s->vertex_count, 0};
    if (!found.indices)
        return -1;
    for (uint32_t i = 0; i < s->triangle_count; i++)
        if (!is_hidden(bodies, s, i))
            take(&found, s, i);
    if (found.triangle_count == 0 || found.triangle_count == s->triangle_count) {
        free(found.indices);
        found.indices = NULL;
        found.triangle_count = 0;
    }
    *outer = found;
    return 0;
}

int nsdf_find_outer(const nsdf_surface *surface, const nsdf_surface *bodies, uint32_t first_look, nsdf_surface *outer) {
    nsdf_sdf *sdf = bodies->triangle_count ? nsdf_sdf_create_winding(bodies) : NULL;
    if (bodies->triangle_count && !sdf)
        return -1;
    *outer = (nsdf_surface){surface->positions, NULL, surface->vertex_count, 0};
    const bool some = sdf && (first_look == 1 || hides_any(sdf, surface, first_look));
    const int result = some ? take_outer(sdf, surface, outer) : 0;
    nsdf_sdf_free(sdf);
    return result;
}
