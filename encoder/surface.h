/* One frame's triangles in normalised coordinates, and what is known of their connectivity. */
#ifndef NSDF_SURFACE_H
#define NSDF_SURFACE_H

#include <stddef.h>
#include <stdint.h>

typedef struct nsdf_surface {
    float *positions;  /* [vertex_count][3] */
    uint32_t *indices; /* [triangle_count][3] */
    uint32_t vertex_count, triangle_count;
} nsdf_surface;

void nsdf_surface_free(nsdf_surface *surface);

/* Edges of the surface after welding equal positions and leaving out triangles without area. */
typedef struct nsdf_edge_count {
    uint32_t boundary;     /* edges of one triangle */
    uint32_t non_manifold; /* edges of three or more */
    uint32_t inconsistent; /* edges of two triangles that run along them in the same direction */
} nsdf_edge_count;

/* Returns 0, or -1 when memory ran out. */
int nsdf_surface_count_edges(const nsdf_surface *surface, nsdf_edge_count *edges);

double nsdf_surface_area(const nsdf_surface *surface);

/* Volume enclosed by the triangles (divergence theorem); negative when they face inward. */
double nsdf_surface_volume(const nsdf_surface *surface);

#endif
