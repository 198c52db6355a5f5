#include "edge_table.h"

#include <stdlib.h>

#include "triangle.h"
#include "weld.h"

static void add_edge(const nsdf_edge_table *table, uint32_t from, uint32_t to) {
    uint32_t low = from < to ? from : to, high = from < to ? to : from;
    size_t place = nsdf_hash_mix((uint64_t)low << 32 | high) & (table->slot_count - 1);
    nsdf_edge *edge = &table->slots[place];
    while (nsdf_edge_uses(edge) > 0 && (edge->low != low || edge->high != high)) {
        place = (place + 1) & (table->slot_count - 1);
        edge = &table->slots[place];
    }
    edge->low = low;
    edge->high = high;
    if (from < to) {
        edge->up++;
    } else {
        edge->down++;
    }
}

int nsdf_edge_table_build(nsdf_edge_table *table, const nsdf_surface *surface, const uint32_t *weld) {
    table->slot_count = nsdf_hash_slots(3 * (size_t)surface->triangle_count);
    table->slots = calloc(table->slot_count, sizeof *table->slots);
    if (table->slots == NULL) {
        return -1;
    }
    for (uint32_t i = 0; i < surface->triangle_count; i++) {
        const uint32_t *index = &surface->indices[3 * (size_t)i];
        nsdf_triangle triangle = nsdf_triangle_load(surface, i);
        if (nsdf_triangle_has_area(&triangle)) {
            for (int k = 0; k < 3; k++) {
                uint32_t from = index[k], to = index[(k + 1) % 3];
                add_edge(table, weld != NULL ? weld[from] : from, weld != NULL ? weld[to] : to);
            }
        }
    }
    return 0;
}

void nsdf_edge_table_free(nsdf_edge_table *table) {
    free(table->slots);
    *table = (nsdf_edge_table){NULL, 0};
}

nsdf_edge_count nsdf_edge_table_count(const nsdf_edge_table *table) {
    nsdf_edge_count edges = {0, 0, 0};
    for (size_t i = 0; i < table->slot_count; i++) {
        uint32_t uses = nsdf_edge_uses(&table->slots[i]);
        edges.boundary += uses == 1;
        edges.non_manifold += uses >= 3;
        edges.inconsistent += uses == 2 && table->slots[i].up != 1;
    }
    return edges;
}
