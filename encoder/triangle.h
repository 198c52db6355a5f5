/* One triangle: corners, normal, nearest point. */
#ifndef NSDF_TRIANGLE_H
#define NSDF_TRIANGLE_H

#include <stdbool.h>

#include "surface.h"
#include "vec3.h"

typedef struct nsdf_triangle {
    nsdf_vec3 corner[3];
} nsdf_triangle;

static inline nsdf_triangle nsdf_triangle_load(const nsdf_surface *surface, uint32_t triangle) {
    const uint32_t *index = &surface->indices[3 * (size_t)triangle];
    nsdf_triangle t;
    for (int i = 0; i < 3; i++) {
        t.corner[i] = nsdf_vec3_load(&surface->positions[3 * (size_t)index[i]]);
    }
    return t;
}

/* Twice the area times the unit normal; exactly 0 for a triangle that has no area worth the name: the rounding of
 * single-precision corners leaves heights of about 1e-7 of the length, far above the limit here. */
nsdf_vec3 nsdf_triangle_cross(const nsdf_triangle *triangle);

/* The unit normal; 0 where the cross product is. */
static inline nsdf_vec3 nsdf_triangle_normal(const nsdf_triangle *triangle) {
    const nsdf_vec3 cross = nsdf_triangle_cross(triangle);
    const double length = nsdf_vec3_length(cross);
    return nsdf_vec3_scale(length > 0.0 ? 1.0 / length : 0.0, cross);
}

static inline bool nsdf_triangle_has_area(const nsdf_triangle *triangle) {
    nsdf_vec3 cross = nsdf_triangle_cross(triangle);
    return nsdf_vec3_dot(cross, cross) > 0.0;
}

/* The angle at a corner, radians. */
double nsdf_triangle_angle(const nsdf_triangle *triangle, int corner);

typedef struct nsdf_triangle_hit {
    nsdf_vec3 point;  /* nearest to the query */
    nsdf_vec3 offset; /* from it to the query */
    nsdf_vec3 cross;  /* nsdf_triangle_cross */
    double distance2;
    enum { NSDF_HIT_FACE, NSDF_HIT_EDGE, NSDF_HIT_CORNER } feature;
    int corner; /* 0..2, of NSDF_HIT_CORNER */
} nsdf_triangle_hit;

nsdf_triangle_hit nsdf_triangle_nearest(const nsdf_triangle *triangle, nsdf_vec3 query);

#endif
