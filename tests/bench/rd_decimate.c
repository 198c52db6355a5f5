#include "rd_decimate.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "vec3.h"
#include "weld.h"

#define NONE UINT32_MAX

/* Pull towards the middle of the edge, as a fraction of the quadric's trace: decides where the planes do not, as on
 * flat and cylindrical parts. */
static const double pull = 1e-6;
/* What a collapse costs beside its error, for the squared length of the edge: on flat parts short edges go first. */
static const double length_cost = 1e-9;
/* Cosine of the largest angle by which a collapse may turn a triangle. */
static const double turn_limit = 0.2;

/* Sum of weighed squared distances from planes: p A p - 2 b p + c. */
typedef struct quadric {
    double xx, xy, xz, yy, yz, zz;
    nsdf_vec3 b;
    double c;
} quadric;

/* Into a, which moves to the position. */
typedef struct collapse {
    double cost;
    nsdf_vec3 position;
    uint32_t a, b, age_a, age_b; /* out of date when a vertex is older by now */
} collapse;

typedef struct decimator {
    rd_placement placement;
    nsdf_vec3 *positions;
    quadric *quadrics;
    uint32_t *indices;      /* [triangle][3]; NONE first when it is gone */
    uint32_t *first, *next; /* corners (3 triangle + k) of a vertex: first[vertex], next[corner], NONE */
    uint32_t *age, *mark;   /* [vertex] */
    uint32_t tick;          /* largest mark so far */
    size_t live;            /* triangles */
    collapse *heap;
    size_t heap_count, heap_capacity;
    bool out_of_memory;
} decimator;

/* ---- Quadrics ---- */

static void add_plane(quadric *q, nsdf_vec3 normal, double offset, double weight) {
    q->xx += weight * normal.x * normal.x;
    q->xy += weight * normal.x * normal.y;
    q->xz += weight * normal.x * normal.z;
    q->yy += weight * normal.y * normal.y;
    q->yz += weight * normal.y * normal.z;
    q->zz += weight * normal.z * normal.z;
    q->b = nsdf_vec3_mad(q->b, weight * offset, normal);
    q->c += weight * offset * offset;
}

static quadric add_quadrics(const quadric *a, const quadric *b) {
    return (quadric){a->xx + b->xx,
                     a->xy + b->xy,
                     a->xz + b->xz,
                     a->yy + b->yy,
                     a->yz + b->yz,
                     a->zz + b->zz,
                     nsdf_vec3_add(a->b, b->b),
                     a->c + b->c};
}

static double quadric_error(const quadric *q, nsdf_vec3 p) {
    const nsdf_vec3 ap = {q->xx * p.x + q->xy * p.y + q->xz * p.z, q->xy * p.x + q->yy * p.y + q->yz * p.z,
                          q->xz * p.x + q->yz * p.y + q->zz * p.z};
    return nsdf_vec3_dot(ap, p) - 2 * nsdf_vec3_dot(q->b, p) + q->c;
}

/* Least error, pulled to `middle`; Cramer's rule. */
static nsdf_vec3 best_position(const quadric *q, nsdf_vec3 middle) {
    const double t = pull * (q->xx + q->yy + q->zz), xx = q->xx + t, yy = q->yy + t, zz = q->zz + t;
    const nsdf_vec3 r = nsdf_vec3_mad(q->b, t, middle);
    const nsdf_vec3 row0 = {yy * zz - q->yz * q->yz, q->xz * q->yz - q->xy * zz, q->xy * q->yz - q->xz * yy};
    const nsdf_vec3 row1 = {row0.y, xx * zz - q->xz * q->xz, q->xy * q->xz - xx * q->yz};
    const nsdf_vec3 row2 = {row0.z, row1.z, xx * yy - q->xy * q->xy};
    const double determinant = xx * row0.x + q->xy * row0.y + q->xz * row0.z;
    if (!(determinant > 0))
        return middle;
    return (nsdf_vec3){nsdf_vec3_dot(row0, r) / determinant, nsdf_vec3_dot(row1, r) / determinant,
                       nsdf_vec3_dot(row2, r) / determinant};
}

/* ---- Heap: the cheapest collapse first ---- */

static bool comes_before(const collapse *x, const collapse *y) {
    if (x->cost != y->cost)
        return x->cost < y->cost;
    return x->a != y->a ? x->a < y->a : x->b < y->b;
}

static void push(decimator *d, const collapse *item) {
    if (d->heap_count == d->heap_capacity) {
        const size_t capacity = d->heap_capacity ? 2 * d->heap_capacity : 4096;
        collapse *heap = realloc(d->heap, capacity * sizeof *heap);
        if (!heap) {
            d->out_of_memory = true;
            return;
        }
        d->heap = heap;
        d->heap_capacity = capacity;
    }
    size_t at = d->heap_count++;
    for (; at > 0 && comes_before(item, &d->heap[(at - 1) / 2]); at = (at - 1) / 2)
        d->heap[at] = d->heap[(at - 1) / 2];
    d->heap[at] = *item;
}

static collapse pop(decimator *d) {
    const collapse top = d->heap[0], last = d->heap[--d->heap_count];
    size_t at = 0;
    for (size_t child; (child = 2 * at + 1) < d->heap_count; at = child) {
        if (child + 1 < d->heap_count && comes_before(&d->heap[child + 1], &d->heap[child]))
            child++;
        if (!comes_before(&d->heap[child], &last))
            break;
        d->heap[at] = d->heap[child];
    }
    d->heap[at] = last;
    return top;
}

/* ---- Triangles around a vertex ---- */

/* The corner itself, or the next one of the vertex whose triangle is still there. */
static uint32_t skip_gone(const decimator *d, uint32_t corner) {
    while (corner != NONE && d->indices[corner - corner % 3] == NONE)
        corner = d->next[corner];
    return corner;
}

#define FOR_EACH_CORNER(d, vertex, corner)                                                                             \
    for (uint32_t corner = skip_gone(d, (d)->first[vertex]); corner != NONE; corner = skip_gone(d, (d)->next[corner]))

static uint32_t *triangle_at(const decimator *d, uint32_t corner) {
    return &d->indices[corner - corner % 3];
}

static bool has_vertex(const uint32_t *triangle, uint32_t vertex) {
    return triangle[0] == vertex || triangle[1] == vertex || triangle[2] == vertex;
}

static nsdf_vec3 cross_of(nsdf_vec3 a, nsdf_vec3 b, nsdf_vec3 c) {
    return nsdf_vec3_cross(nsdf_vec3_sub(b, a), nsdf_vec3_sub(c, a));
}

/* Puts the edge into the heap with its cost. */
static void offer(decimator *d, uint32_t a, uint32_t b) {
    if (a > b) {
        const uint32_t other = a;
        a = b;
        b = other;
    }
    const nsdf_vec3 pa = d->positions[a], pb = d->positions[b], along = nsdf_vec3_sub(pb, pa);
    const quadric q = add_quadrics(&d->quadrics[a], &d->quadrics[b]);
    collapse item = {.a = a, .b = b, .age_a = d->age[a], .age_b = d->age[b]};
    if (d->placement == RD_PLACE_OPTIMAL)
        item.position = best_position(&q, nsdf_vec3_mad(pa, 0.5, along));
    else
        item.position = quadric_error(&q, pa) < quadric_error(&q, pb) ? pa : pb;
    /* Rounding may make the error of exact collapses negative. */
    item.cost =
        fmax(quadric_error(&q, item.position), 0) + length_cost * nsdf_vec3_dot(along, along) * (q.xx + q.yy + q.zz);
    push(d, &item);
}

/* Link condition (Dey et al. 1999): the edge's triangles account for all vertices next to both of its ends. */
static bool keeps_topology(decimator *d, uint32_t a, uint32_t b) {
    const uint32_t near_a = ++d->tick, near_both = ++d->tick;
    uint32_t triangles = 0, shared = 0;
    FOR_EACH_CORNER(d, a, corner) {
        const uint32_t *triangle = triangle_at(d, corner);
        for (int k = 0; k < 3; k++)
            d->mark[triangle[k]] = near_a;
        triangles += has_vertex(triangle, b);
    }
    FOR_EACH_CORNER(d, b, corner) {
        const uint32_t *triangle = triangle_at(d, corner);
        for (int k = 0; k < 3; k++) {
            const uint32_t vertex = triangle[k];
            if (vertex != a && vertex != b && d->mark[vertex] == near_a) {
                d->mark[vertex] = near_both;
                shared++;
            }
        }
    }
    return triangles > 0 && shared == triangles;
}

/* Whether no triangle at `vertex` turns over when it moves; those that `other` shares will be gone. */
static bool keeps_sides(const decimator *d, uint32_t vertex, uint32_t other, nsdf_vec3 to) {
    FOR_EACH_CORNER(d, vertex, corner) {
        const uint32_t *triangle = triangle_at(d, corner);
        nsdf_vec3 before[3], after[3];
        if (has_vertex(triangle, other))
            continue;
        for (int k = 0; k < 3; k++) {
            before[k] = d->positions[triangle[k]];
            after[k] = triangle[k] == vertex ? to : before[k];
        }
        const nsdf_vec3 m = cross_of(before[0], before[1], before[2]), n = cross_of(after[0], after[1], after[2]);
        if (nsdf_vec3_dot(m, n) <= turn_limit * nsdf_vec3_length(m) * nsdf_vec3_length(n))
            return false;
    }
    return true;
}

/* Where a list of corners ends, those that are gone taken out of it. */
static uint32_t *end_of_corners(decimator *d, uint32_t *link) {
    while ((*link = skip_gone(d, *link)) != NONE)
        link = &d->next[*link];
    return link;
}

static void apply(decimator *d, const collapse *item) {
    const uint32_t a = item->a, b = item->b;
    d->positions[a] = item->position;
    d->quadrics[a] = add_quadrics(&d->quadrics[a], &d->quadrics[b]);
    FOR_EACH_CORNER(d, b, corner) {
        uint32_t *triangle = triangle_at(d, corner);
        if (has_vertex(triangle, a)) {
            triangle[0] = NONE;
            d->live--;
        } else {
            d->indices[corner] = a;
        }
    }
    uint32_t *end = end_of_corners(d, &d->first[a]);
    *end = d->first[b];
    end_of_corners(d, end);
    d->first[b] = NONE;
    d->age[a]++;
    d->age[b]++;
}

static void offer_around(decimator *d, uint32_t vertex) {
    const uint32_t seen = ++d->tick;
    d->mark[vertex] = seen;
    FOR_EACH_CORNER(d, vertex, corner) {
        const uint32_t *triangle = triangle_at(d, corner);
        for (int k = 0; k < 3; k++) {
            if (d->mark[triangle[k]] != seen) {
                d->mark[triangle[k]] = seen;
                offer(d, vertex, triangle[k]);
            }
        }
    }
}

/* ---- The whole ---- */

static void add_triangle(decimator *d, const uint32_t *triangle) {
    const nsdf_vec3 p = d->positions[triangle[0]];
    const nsdf_vec3 cross = cross_of(p, d->positions[triangle[1]], d->positions[triangle[2]]);
    const double area = nsdf_vec3_length(cross);
    if (area > 0) {
        const nsdf_vec3 normal = nsdf_vec3_scale(1 / area, cross);
        for (int k = 0; k < 3; k++)
            add_plane(&d->quadrics[triangle[k]], normal, nsdf_vec3_dot(normal, p), area);
    }
}

/* Whether a triangle runs along the edge the other way. */
static bool has_opposite(const decimator *d, uint32_t from, uint32_t to) {
    FOR_EACH_CORNER(d, to, corner) {
        if (triangle_at(d, corner)[(corner + 1) % 3] == from)
            return true;
    }
    return false;
}

/* The plane through an open edge that stands on its triangle. */
static void add_border(decimator *d, const uint32_t *triangle, uint32_t from, uint32_t to) {
    const nsdf_vec3 p = d->positions[from], along = nsdf_vec3_sub(d->positions[to], p);
    const nsdf_vec3 across = nsdf_vec3_cross(
        along, cross_of(d->positions[triangle[0]], d->positions[triangle[1]], d->positions[triangle[2]]));
    const double length = nsdf_vec3_length(across);
    if (length > 0) {
        const nsdf_vec3 normal = nsdf_vec3_scale(1 / length, across);
        add_plane(&d->quadrics[from], normal, nsdf_vec3_dot(normal, p), nsdf_vec3_dot(along, along));
        add_plane(&d->quadrics[to], normal, nsdf_vec3_dot(normal, p), nsdf_vec3_dot(along, along));
    }
}

/* All planes first: they decide what an edge costs. */
static void add_edges(decimator *d, size_t corners) {
    for (int pass = 0; pass < 2; pass++) {
        for (size_t i = 0; i < corners; i++) {
            const uint32_t *triangle = &d->indices[i - i % 3], from = d->indices[i], to = triangle[(i + 1) % 3];
            const bool open = !has_opposite(d, from, to);
            if (pass == 0 && open)
                add_border(d, triangle, from, to);
            else if (pass == 1 && (open || from < to))
                offer(d, from, to);
        }
    }
}

static int allocate(decimator *d, const nsdf_surface *surface) {
    const size_t vertices = surface->vertex_count, corners = 3 * (size_t)surface->triangle_count;
    d->positions = malloc(vertices * sizeof *d->positions);
    d->quadrics = calloc(vertices, sizeof *d->quadrics);
    d->first = malloc(vertices * sizeof *d->first);
    d->next = malloc(corners * sizeof *d->next);
    d->age = calloc(vertices, sizeof *d->age);
    d->mark = calloc(vertices, sizeof *d->mark);
    return d->positions && d->quadrics && d->first && d->next && d->age && d->mark ? 0 : -1;
}

static void release(decimator *d) {
    free(d->positions);
    free(d->quadrics);
    free(d->first);
    free(d->next);
    free(d->age);
    free(d->mark);
    free(d->heap);
}

static void prepare(decimator *d, const nsdf_surface *surface, nsdf_vec3 origin) {
    const size_t corners = 3 * (size_t)surface->triangle_count;
    for (size_t i = 0; i < surface->vertex_count; i++) {
        d->positions[i] = nsdf_vec3_sub(nsdf_vec3_load(&surface->positions[3 * i]), origin);
        d->first[i] = NONE;
    }
    for (size_t i = 0; i < corners; i++) {
        d->next[i] = d->first[d->indices[i]];
        d->first[d->indices[i]] = (uint32_t)i;
    }
    for (size_t i = 0; i < corners; i += 3)
        add_triangle(d, &d->indices[i]);
    add_edges(d, corners);
}

static void run(decimator *d, size_t target) {
    while (d->live > target && d->heap_count > 0 && !d->out_of_memory) {
        const collapse item = pop(d);
        if (item.age_a == d->age[item.a] && item.age_b == d->age[item.b] && keeps_topology(d, item.a, item.b) &&
            keeps_sides(d, item.a, item.b, item.position) && keeps_sides(d, item.b, item.a, item.position)) {
            apply(d, &item);
            offer_around(d, item.a);
        }
    }
}

static int weld(nsdf_surface *surface) {
    uint32_t *same = malloc(((size_t)surface->vertex_count + 1) * sizeof *same), kept = 0;
    if (!same || nsdf_weld_vertices(surface, same)) {
        free(same);
        return -1;
    }
    for (size_t i = 0; i < surface->triangle_count; i++) {
        const uint32_t *triangle = &surface->indices[3 * i];
        const uint32_t a = same[triangle[0]], b = same[triangle[1]], c = same[triangle[2]];
        if (a != b && b != c && c != a) {
            uint32_t *to = &surface->indices[3 * (size_t)kept++];
            to[0] = a;
            to[1] = b;
            to[2] = c;
        }
    }
    surface->triangle_count = kept;
    free(same);
    return 0;
}

static void take_result(nsdf_surface *surface, const decimator *d, nsdf_vec3 origin) {
    uint32_t kept = 0;
    for (size_t i = 0; i < surface->triangle_count; i++) {
        const uint32_t *from = &surface->indices[3 * i];
        if (from[0] != NONE)
            memmove(&surface->indices[3 * (size_t)kept++], from, 3 * sizeof *from);
    }
    surface->triangle_count = kept;
    for (size_t i = 0; i < surface->vertex_count; i++) {
        const nsdf_vec3 p = nsdf_vec3_add(d->positions[i], origin);
        surface->positions[3 * i] = (float)p.x;
        surface->positions[3 * i + 1] = (float)p.y;
        surface->positions[3 * i + 2] = (float)p.z;
    }
}

int rd_decimate(nsdf_surface *surface, size_t target, rd_placement placement) {
    if (weld(surface))
        return -1;
    if (target >= surface->triangle_count)
        return 0;
    decimator d = {.placement = placement, .indices = surface->indices, .live = surface->triangle_count};
    int result = allocate(&d, surface);
    if (result == 0) {
        /* Relative to a vertex, so that quadrics far from the origin do not lose their digits. */
        const nsdf_vec3 origin = nsdf_vec3_load(surface->positions);
        prepare(&d, surface, origin);
        run(&d, target);
        take_result(surface, &d, origin);
        result = d.out_of_memory ? -1 : 0;
    }
    release(&d);
    return result;
}
