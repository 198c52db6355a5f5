#include "surface.h"

#include <stdlib.h>

#include "triangle.h"
#include "weld.h"

void nsdf_surface_free(nsdf_surface *surface) {
    if (surface != NULL) {
        free(surface->positions);
        free(surface->indices);
        *surface = (nsdf_surface){0};
    }
}

double nsdf_surface_area(const nsdf_surface *surface) {
    double area = 0.0;
    for (uint32_t i = 0; i < surface->triangle_count; i++) {
        nsdf_triangle triangle = nsdf_triangle_load(surface, i);
        area += 0.5 * nsdf_vec3_length(nsdf_triangle_cross(&triangle));
    }
    return area;
}

typedef struct edge {
    uint32_t low, high; /* welded vertices */
    uint32_t up, down;  /* triangles that run from low to high, and back; both 0 in an empty slot */
} edge;

static void count_edge(edge *table, size_t slots, uint32_t from, uint32_t to) {
    uint32_t low = from < to ? from : to, high = from < to ? to : from;
    size_t slot = nsdf_hash_mix((uint64_t)low << 32 | high) & (slots - 1);
    while (table[slot].up + table[slot].down > 0 && (table[slot].low != low || table[slot].high != high)) {
        slot = (slot + 1) & (slots - 1);
    }
    table[slot].low = low;
    table[slot].high = high;
    if (from < to) {
        table[slot].up++;
    } else {
        table[slot].down++;
    }
}

static void count_triangles(const nsdf_surface *surface, const uint32_t *weld, edge *table, size_t slots) {
    for (uint32_t i = 0; i < surface->triangle_count; i++) {
        const uint32_t *index = &surface->indices[3 * (size_t)i];
        nsdf_triangle triangle = nsdf_triangle_load(surface, i);
        if (nsdf_triangle_has_area(&triangle)) {
            for (int k = 0; k < 3; k++) {
                count_edge(table, slots, weld[index[k]], weld[index[(k + 1) % 3]]);
            }
        }
    }
}

static nsdf_edge_count sum_up(const edge *table, size_t slots) {
    nsdf_edge_count edges = {0, 0, 0};
    for (size_t slot = 0; slot < slots; slot++) {
        uint32_t uses = table[slot].up + table[slot].down;
        edges.boundary += uses == 1;
        edges.non_manifold += uses >= 3;
        edges.inconsistent += uses == 2 && table[slot].up != 1;
    }
    return edges;
}

int nsdf_surface_count_edges(const nsdf_surface *surface, nsdf_edge_count *edges) {
    size_t slots = nsdf_hash_slots(3 * (size_t)surface->triangle_count);
    uint32_t *weld = malloc(((size_t)surface->vertex_count + 1) * sizeof *weld);
    edge *table = calloc(slots, sizeof *table);
    int result = -1;
    if (weld != NULL && table != NULL && nsdf_weld_vertices(surface, weld) == 0) {
        count_triangles(surface, weld, table, slots);
        *edges = sum_up(table, slots);
        result = 0;
    }
    free(table);
    free(weld);
    return result;
}
