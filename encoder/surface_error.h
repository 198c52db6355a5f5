/* Distances from one surface to another. */
#ifndef NSDF_SURFACE_ERROR_H
#define NSDF_SURFACE_ERROR_H

#include "random.h"
#include "sdf.h"

typedef struct nsdf_distance_stats {
    double sum, sum_squares, max; /* of distances */
    uint64_t count;
} nsdf_distance_stats;

/* Adds the distances of every vertex that a triangle uses, for `max` only, and of `samples` points uniform by area,
 * for all three, from `from` to `to`.  Returns 0, or -1 when memory ran out. */
int nsdf_add_surface_distances(const nsdf_surface *from, const nsdf_sdf *to, size_t samples, nsdf_random *random,
                               nsdf_distance_stats *stats);

/* Connected components of the triangles: component[triangle] gets numbers from 0; returns how many, or -1 when memory
 * ran out. */
int64_t nsdf_surface_components(const nsdf_surface *surface, uint32_t *component);

/* triangles[i] gets how many piece i < count has; returns the first of the pieces with the most. */
uint32_t nsdf_largest_piece(const nsdf_surface *surface, const uint32_t *piece, uint32_t count, uint32_t *triangles);

/* sizes[i] gets the diagonal of the box of piece i < count; piece[triangle] as nsdf_surface_components numbers them.
 * Returns 0, or -1 when memory ran out. */
int nsdf_piece_sizes(const nsdf_surface *surface, const uint32_t *piece, uint32_t count, float *sizes);

#endif
