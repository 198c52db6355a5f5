#include "surface.h"

#include <stdlib.h>

#include "edge_table.h"
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

double nsdf_surface_volume(const nsdf_surface *surface) {
    double volume = 0.0;
    for (size_t i = 0; i < surface->triangle_count; i++) {
        const uint32_t *t = surface->indices + 3 * i;
        double p[3][3];
        for (int c = 0; c < 3; c++) {
            for (int k = 0; k < 3; k++) {
                p[c][k] = (double)surface->positions[3 * (size_t)t[c] + (size_t)k];
            }
        }
        volume += p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) -
                  p[0][1] * (p[1][0] * p[2][2] - p[1][2] * p[2][0]) + p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
    }
    return volume / 6.0;
}

int nsdf_surface_count_edges(const nsdf_surface *surface, nsdf_edge_count *edges) {
    uint32_t *weld = malloc(((size_t)surface->vertex_count + 1) * sizeof *weld);
    nsdf_edge_table table = {NULL, 0};
    int result = -1;
    if (weld != NULL && nsdf_weld_vertices(surface, weld) == 0 && nsdf_edge_table_build(&table, surface, weld) == 0) {
        *edges = nsdf_edge_table_count(&table);
        result = 0;
    }
    nsdf_edge_table_free(&table);
    free(weld);
    return result;
}
