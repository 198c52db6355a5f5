#include "mesh_shape.h"

#include <stdbool.h>
#include <stdlib.h>

#include "surface_error.h"

/* V - E + F, where `used` is false throughout. */
static int64_t euler_number(const nsdf_surface *surface, const nsdf_edge_table *edges, bool *used) {
    int64_t euler = surface->triangle_count;
    for (size_t i = 0; i < 3 * (size_t)surface->triangle_count; i++) {
        euler += !used[surface->indices[i]];
        used[surface->indices[i]] = true;
    }
    for (size_t i = 0; i < edges->slot_count; i++) {
        euler -= nsdf_edge_uses(&edges->slots[i]) > 0;
    }
    return euler;
}

int nsdf_measure_shape(const nsdf_surface *surface, const nsdf_edge_table *edges, double diagonal, nsdf_shape *shape) {
    uint32_t *component = malloc(sizeof *component * (size_t)surface->triangle_count);
    bool *used = calloc(surface->vertex_count, sizeof *used);
    int64_t components = component != NULL && used != NULL ? nsdf_surface_components(surface, component) : -1;
    if (components >= 0) {
        nsdf_edge_count count = nsdf_edge_table_count(edges);
        shape->components = (uint32_t)components;
        shape->euler = euler_number(surface, edges, used);
        shape->open_edges = count.boundary + count.non_manifold + count.inconsistent;
        shape->area = nsdf_surface_area(surface) * diagonal * diagonal;
        shape->volume = nsdf_surface_volume(surface) * diagonal * diagonal * diagonal;
    }
    free(used);
    free(component);
    return components < 0 ? -1 : 0;
}
