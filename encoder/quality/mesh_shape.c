#include "mesh_shape.h"

#include <stdlib.h>

#include "surface_error.h"

/* V - E + F. */
static int64_t euler_number(const nsdf_compared_mesh *compared, const nsdf_edge_table *edges) {
    int64_t euler = compared->surface.triangle_count;
    for (uint32_t i = 0; i < compared->surface.vertex_count; i++) {
        euler += compared->used[i];
    }
    for (size_t i = 0; i < edges->slot_count; i++) {
        euler -= nsdf_edge_uses(&edges->slots[i]) > 0;
    }
    return euler;
}

int nsdf_measure_shape(const nsdf_compared_mesh *compared, const nsdf_edge_table *edges, double diagonal,
                       nsdf_shape *shape) {
    const nsdf_surface *surface = &compared->surface;
    uint32_t *component = malloc(sizeof *component * (size_t)surface->triangle_count);
    int64_t components = component != NULL ? nsdf_surface_components(surface, component) : -1;
    free(component);
    if (components < 0) {
        return -1;
    }
    nsdf_edge_count count = nsdf_edge_table_count(edges);
    shape->components = (uint32_t)components;
    shape->euler = euler_number(compared, edges);
    shape->open_edges = count.boundary + count.non_manifold + count.inconsistent;
    shape->area = nsdf_surface_area(surface) * diagonal * diagonal;
    shape->volume = nsdf_surface_volume(surface) * diagonal * diagonal * diagonal;
    return 0;
}
