/* The moving shapes that nsdf-sample makes: analytic implicit functions of position and time. */
#ifndef NSDF_SHAPES_H
#define NSDF_SHAPES_H

#include "implicit_mesh.h"

enum { NSDF_SHAPE_MAX_PARTS = 32, NSDF_SHAPE_BEADS = 20, NSDF_SHAPE_BEAD = 8, NSDF_SHAPE_CURVE = 160 };

/* A capsule from a to b with a radius that changes linearly; `blend` is the width over which it melts into the parts
 * before it. */
typedef struct nsdf_shape_part {
    double a[3], b[3], radius_a, radius_b, blend;
} nsdf_shape_part;

/* A shape at one time. */
typedef struct nsdf_shape_pose {
    nsdf_shape_part parts[NSDF_SHAPE_MAX_PARTS];
    int part_count;
    double curve[NSDF_SHAPE_CURVE + 1][4]; /* closed polyline of a tube: x, y, z, radius; the last point is the first */
    double beads[NSDF_SHAPE_BEADS][4];     /* balls, each around NSDF_SHAPE_BEAD links of the tube: x, y, z, radius */
    double phase;                          /* of the wave */
} nsdf_shape_pose;

typedef struct nsdf_shape {
    const char *name, *summary;
    void (*pose)(double seconds, nsdf_shape_pose *pose);
    double (*value)(const void *pose, const double p[3]);
    double lipschitz;
    double box_min[3], box_max[3]; /* holds the shape at every time */
} nsdf_shape;

/* All shapes; *count is filled in. */
const nsdf_shape *nsdf_shapes(size_t *count);
/* NULL when there is none of that name. */
const nsdf_shape *nsdf_shape_find(const char *name);

/* The shape's field for a pose that the caller filled with shape->pose and keeps. */
nsdf_implicit_field nsdf_shape_field(const nsdf_shape *shape, const nsdf_shape_pose *pose);

/* Length of the longest side of the box: the resolution counts lattice edges along it. */
double nsdf_shape_extent(const nsdf_shape *shape);

/* A walking figure, 1.75 m tall, on the spot: y up, facing +z, one stride a second. */
void nsdf_walker_pose(double seconds, nsdf_shape_pose *pose);

#endif
