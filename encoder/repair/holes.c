#include "repair/holes.h"

#include "vec3.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_CORNERS = 96 };
/* Of the patch's area: a larger lid may well be the mouth of something hollow, or close a piece that other pieces
 * continue. */
static const double largest_lid = 0.05;

#define NONE UINT32_MAX

typedef struct {
    const nsdf_surface *surface;
    const nsdf_patches *patches;
    nsdf_fill *fill;
    uint32_t *first; /* [vertex]: an edge out of it, along holes */
    uint32_t *place; /* [vertex]: in the path */
    uint32_t *next;  /* [edge]: another edge out of the same vertex */
    uint32_t *to;    /* [edge]: where it ends */
    uint32_t *patch; /* [edge] */
    uint32_t edges;
    uint32_t *path;
    double cost[MOST_CORNERS][MOST_CORNERS];
    uint8_t split[MOST_CORNERS][MOST_CORNERS];
} tracer;

/* ---- One loop ------------------------------------------------------------------------------------------- */

static nsdf_vec3 position(const tracer *t, uint32_t vertex) {
    return nsdf_vec3_load(t->surface->positions + 3 * (size_t)vertex);
}

static double area_of(nsdf_vec3 a, nsdf_vec3 b, nsdf_vec3 c) {
    return 0.5 * nsdf_vec3_length(nsdf_vec3_cross(nsdf_vec3_sub(b, a), nsdf_vec3_sub(c, a)));
}

static double lid_area(const tracer *t, const uint32_t *loop, uint32_t count) {
    nsdf_vec3 middle = {0.0, 0.0, 0.0};
    double area = 0.0;
    for (uint32_t i = 0; i < count; i++)
        middle = nsdf_vec3_mad(middle, 1.0 / count, position(t, loop[i]));
    for (uint32_t i = 0; i < count; i++)
        area += area_of(middle, position(t, loop[i]), position(t, loop[(i + 1) % count]));
    return area;
}

static int add_triangle(nsdf_fill *f, uint32_t a, uint32_t b, uint32_t c) {
    if (f->triangle_count == f->capacity) {
        const uint32_t capacity = 2 * f->capacity + 64;
        uint32_t *indices = realloc(f->indices, 3 * sizeof *indices * (size_t)capacity);
        if (!indices)
            return -1;
        f->indices = indices;
        f->capacity = capacity;
    }
    uint32_t *to = f->indices + 3 * (size_t)f->triangle_count++;
    to[0] = a;
    to[1] = b;
    to[2] = c;
    return 0;
}

static void find_least_area(tracer *t, const uint32_t *loop, uint32_t count) {
    for (uint32_t span = 1; span < count; span++)
        for (uint32_t i = 0; i + span < count; i++) {
            const uint32_t j = i + span;
            t->cost[i][j] = span == 1 ? 0.0 : INFINITY;
            for (uint32_t k = i + 1; k < j; k++) {
                const double cost = t->cost[i][k] + t->cost[k][j] +
                                    area_of(position(t, loop[i]), position(t, loop[k]), position(t, loop[j]));
                if (cost < t->cost[i][j]) {
                    t->cost[i][j] = cost;
                    t->split[i][j] = (uint8_t)k;
                }
            }
        }
}

/* The triangles of the polygon from corner i to corner j. */
static int add_polygon(tracer *t, const uint32_t *loop, uint32_t i, uint32_t j) {
    uint32_t stack[MOST_CORNERS][2], waiting = 0;
    stack[waiting][0] = i;
    stack[waiting++][1] = j;
    while (waiting > 0) {
        const uint32_t a = stack[--waiting][0], b = stack[waiting][1];
        if (b - a < 2)
            continue;
        const uint32_t k = t->split[a][b];
        if (add_triangle(t->fill, loop[a], loop[k], loop[b]) != 0)
            return -1;
        stack[waiting][0] = a;
        stack[waiting++][1] = k;
        stack[waiting][0] = k;
        stack[waiting++][1] = b;
    }
    return 0;
}

static int close_loop(tracer *t, const uint32_t *loop, uint32_t count, uint32_t patch) {
    if (count < 3 || count > MOST_CORNERS || lid_area(t, loop, count) > largest_lid * t->patches->patches[patch].area)
        return 0;
    t->fill->hole_count++;
    find_least_area(t, loop, count);
    return add_polygon(t, loop, 0, count - 1);
}

/* ---- All loops ------------------------------------------------------------------------------------------ */

/* Takes an edge out of a vertex; NONE when there is none left. */
static uint32_t take_edge(tracer *t, uint32_t vertex) {
    const uint32_t edge = t->first[vertex];
    if (edge != NONE)
        t->first[vertex] = t->next[edge];
    return edge;
}

/* Follows edges from a vertex; whenever the path comes back to itself, that is a loop. */
static int trace(tracer *t, uint32_t start) {
    uint32_t length = 0, edge;
    int failed = 0;
    t->path[length] = start;
    t->place[start] = length++;
    while (!failed && (edge = take_edge(t, t->path[length - 1])) != NONE) {
        const uint32_t to = t->to[edge], place = t->place[to];
        if (place == NONE) {
            t->path[length] = to;
            t->place[to] = length++;
            continue;
        }
        failed = close_loop(t, t->path + place, length - place, t->patch[edge]) != 0;
        while (length > place + 1)
            t->place[t->path[--length]] = NONE;
    }
    while (length > 0)
        t->place[t->path[--length]] = NONE;
    return failed;
}

/* Open edges run the other way round their hole. */
static void list_edges(tracer *t, const uint32_t *weld, const nsdf_mates *mates) {
    for (uint32_t h = 0; h < 3 * t->surface->triangle_count; h++) {
        const uint32_t number = mates->mate[h] == NSDF_MATE_NONE ? t->patches->of[h / 3] : NSDF_NO_PATCH;
        if (number == NSDF_NO_PATCH || t->patches->patches[number].is_sheet || t->patches->patches[number].is_inner)
            continue;
        uint32_t from = nsdf_half_edge_to(t->surface, weld, h), to = nsdf_half_edge_from(t->surface, weld, h);
        if (nsdf_is_turned(t->patches, h / 3)) {
            const uint32_t swapped = from;
            from = to;
            to = swapped;
        }
        t->to[t->edges] = to;
        t->patch[t->edges] = number;
        t->next[t->edges] = t->first[from];
        t->first[from] = t->edges++;
    }
}

int nsdf_fill_holes(nsdf_fill *fill, const nsdf_surface *surface, const uint32_t *weld, const nsdf_mates *mates,
                    const nsdf_patches *patches) {
    const size_t vertices = (size_t)surface->vertex_count + 1, edges = (size_t)mates->open + 1;
    memset(fill, 0, sizeof *fill);
    tracer *t = calloc(1, sizeof *t);
    if (!t)
        return -1;
    t->surface = surface;
    t->patches = patches;
    t->fill = fill;
    t->first = malloc(vertices * sizeof *t->first);
    t->place = malloc(vertices * sizeof *t->place);
    t->path = malloc(vertices * sizeof *t->path);
    t->next = malloc(edges * sizeof *t->next);
    t->to = malloc(edges * sizeof *t->to);
    t->patch = malloc(edges * sizeof *t->patch);
    int failed = !t->first || !t->place || !t->path || !t->next || !t->to || !t->patch;
    if (!failed) {
        memset(t->first, 0xff, vertices * sizeof *t->first);
        memset(t->place, 0xff, vertices * sizeof *t->place);
        list_edges(t, weld, mates);
        for (uint32_t v = 0; v < surface->vertex_count && !failed; v++)
            while (!failed && t->first[v] != NONE)
                failed = trace(t, v);
    }
    free(t->first);
    free(t->place);
    free(t->path);
    free(t->next);
    free(t->to);
    free(t->patch);
    free(t);
    return failed ? -1 : 0;
}

void nsdf_fill_free(nsdf_fill *fill) {
    free(fill->indices);
    memset(fill, 0, sizeof *fill);
}
