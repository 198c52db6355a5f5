/* Distances and angles between two compared meshes. */
#ifndef NSDF_MESH_DISTANCE_H
#define NSDF_MESH_DISTANCE_H

#include "compared_mesh.h"

/* Sums over points; distances in the pair's frame, angles in radians. */
typedef struct nsdf_distance_sums {
    double sum, sum_squares, max;
    double point_squares; /* squared distances to the nearest random point */
    double angle_sum, angle_squares;
} nsdf_distance_sums;

typedef struct nsdf_distance_task {
    const nsdf_compared_mesh *from, *to;
    bool points, normals; /* measure these too */
} nsdf_distance_task;

/* One chunk of the random points of `from`. */
void nsdf_measure_points(const nsdf_distance_task *task, uint32_t chunk, nsdf_distance_sums *sums);

/* One chunk of the vertices of `from`.  *max becomes the largest distance of those that a triangle uses;
 * distance[vertex] (may be NULL) gets the distance, times `unit`, of all. */
void nsdf_measure_vertices(const nsdf_distance_task *task, uint32_t chunk, double unit, double *distance, double *max);

#endif
