/* Fast mesh perceptual distance (Wang, Torkhani & Montanvert 2012; thesis 6.2).
 *
 * Local roughness is the Laplacian of the Gaussian curvature's absolute value.  The curvature of a vertex is its angle
 * deficit, not divided by an area, as in the authors' own program: the thresholds are angles, and the result does not
 * depend on the units or on the density of the mesh.  Also from that program: the deficit of a vertex on an open edge
 * is taken from pi instead of 2 pi, and half the cotangents are clamped to [0.001, 1000], so that no weight is
 * negative. */
#ifndef NSDF_ROUGHNESS_H
#define NSDF_ROUGHNESS_H

#include "edge_table.h"

typedef struct nsdf_roughness {
    double *local; /* [vertex]: LR of (6.7), radians */
    double *share; /* [vertex]: a third of the area of its triangles; 0 when it has none */
    uint32_t vertex_count;
    double area; /* sum of the shares */
    double mean; /* of the local roughness, by area (6.9) */
} nsdf_roughness;

/* Of a welded surface without triangles that have no area; `edges` are its edges, `positions` [vertex][3] what it was
 * rounded from, in any unit.  Returns 0, or -1 when memory ran out; can be freed in either case. */
int nsdf_roughness_measure(nsdf_roughness *roughness, const nsdf_surface *surface, const double *positions,
                           const nsdf_edge_table *edges);
void nsdf_roughness_free(nsdf_roughness *roughness);

/* Global roughness (6.11) of each of two surfaces; their FMPD (6.12) is 8 times the difference, at most 1. */
void nsdf_roughness_global(const nsdf_roughness pair[2], double global[2]);
double nsdf_fmpd(const double global[2]);

#endif
