/* Small meshes, and slow exact answers about them, for the geometry tests. */
#ifndef GEOMETRY_SHAPES_H
#define GEOMETRY_SHAPES_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "random.h"
#include "surface.h"
#include "vec3.h"

#define SHAPE_CAPACITY 20000

static inline nsdf_surface shape_empty(void) {
    nsdf_surface s = {malloc(3 * sizeof(float) * SHAPE_CAPACITY), malloc(3 * sizeof(uint32_t) * SHAPE_CAPACITY), 0, 0};
    return s;
}

static inline uint32_t shape_vertex(nsdf_surface *s, double x, double y, double z) {
    float *p = &s->positions[3 * (size_t)s->vertex_count];
    p[0] = (float)x;
    p[1] = (float)y;
    p[2] = (float)z;
    return s->vertex_count++;
}

static inline void shape_triangle(nsdf_surface *s, uint32_t a, uint32_t b, uint32_t c) {
    uint32_t *i = &s->indices[3 * (size_t)s->triangle_count++];
    i[0] = a;
    i[1] = b;
    i[2] = c;
}

/* A cube of side 2 h around the origin, 12 triangles. */
static inline nsdf_surface shape_cube(double h) {
    static const uint32_t quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                         {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    nsdf_surface s = shape_empty();
    for (int i = 0; i < 8; i++) {
        (void)shape_vertex(&s, i & 1 ? h : -h, i & 2 ? h : -h, i & 4 ? h : -h);
    }
    for (int i = 0; i < 6; i++) {
        shape_triangle(&s, quads[i][0], quads[i][1], quads[i][2]);
        shape_triangle(&s, quads[i][0], quads[i][2], quads[i][3]);
    }
    return s;
}

/* Adds a sphere of rings and segments with single vertices at the poles; `flip` turns it inside out.  Rings below
 * `first_ring` are left out, which opens it at the top. */
static inline void shape_add_sphere(nsdf_surface *s, double r, uint32_t rings, uint32_t segments, int flip,
                                    uint32_t first_ring) {
    uint32_t base = s->vertex_count, top = shape_vertex(s, 0, 0, r), bottom = shape_vertex(s, 0, 0, -r);
    for (uint32_t i = 1; i < rings; i++) {
        for (uint32_t j = 0; j < segments; j++) {
            double theta = 3.141592653589793 * i / rings, phi = 6.283185307179586 * j / segments;
            (void)shape_vertex(s, r * sin(theta) * cos(phi), r * sin(theta) * sin(phi), r * cos(theta));
        }
    }
    for (uint32_t i = first_ring; i < rings; i++) {
        for (uint32_t j = 0; j < segments; j++) {
            uint32_t above = base + 2 + (i - 1) * segments, below = base + 2 + i * segments, j1 = (j + 1) % segments;
            uint32_t a = i > 0 ? above + j : top, b = i + 1 < rings ? below + j : bottom;
            uint32_t c = i + 1 < rings ? below + j1 : bottom, d = i > 0 ? above + j1 : top;
            if (b != c) {
                shape_triangle(s, a, flip ? c : b, flip ? b : c);
            }
            if (a != d) {
                shape_triangle(s, a, flip ? d : c, flip ? c : d);
            }
        }
    }
}

static inline nsdf_surface shape_sphere(double r, uint32_t rings, uint32_t segments) {
    nsdf_surface s = shape_empty();
    shape_add_sphere(&s, r, rings, segments, 0, 0);
    return s;
}

static inline nsdf_surface shape_torus(double big, double small, uint32_t around, uint32_t across) {
    nsdf_surface s = shape_empty();
    for (uint32_t i = 0; i < around; i++) {
        for (uint32_t j = 0; j < across; j++) {
            double u = 6.283185307179586 * i / around, v = 6.283185307179586 * j / across;
            double r = big + small * cos(v);
            (void)shape_vertex(&s, r * cos(u), r * sin(u), small * sin(v));
            uint32_t i1 = (i + 1) % around, j1 = (j + 1) % across;
            shape_triangle(&s, i * across + j, i1 * across + j, i1 * across + j1);
            shape_triangle(&s, i * across + j, i1 * across + j1, i * across + j1);
        }
    }
    return s;
}

/* A tetrahedron: all dihedral angles are sharp when it is thin. */
static inline nsdf_surface shape_tetrahedron(const double p[4][3]) {
    nsdf_surface s = shape_empty();
    for (int i = 0; i < 4; i++) {
        (void)shape_vertex(&s, p[i][0], p[i][1], p[i][2]);
    }
    shape_triangle(&s, 0, 2, 1);
    shape_triangle(&s, 0, 1, 3);
    shape_triangle(&s, 1, 2, 3);
    shape_triangle(&s, 2, 0, 3);
    return s;
}

/* Every triangle gets vertices of its own. */
static inline nsdf_surface shape_unwelded(const nsdf_surface *from) {
    nsdf_surface s = shape_empty();
    for (size_t i = 0; i < 3 * (size_t)from->triangle_count; i++) {
        const float *p = &from->positions[3 * (size_t)from->indices[i]];
        s.indices[i] = shape_vertex(&s, (double)p[0], (double)p[1], (double)p[2]);
    }
    s.triangle_count = from->triangle_count;
    return s;
}

static inline nsdf_vec3 shape_corner(const nsdf_surface *s, uint32_t triangle, int corner) {
    return nsdf_vec3_load(&s->positions[3 * (size_t)s->indices[3 * (size_t)triangle + (size_t)corner]]);
}

/* Squared distance to a segment. */
static inline double exact_segment2(nsdf_vec3 p, nsdf_vec3 a, nsdf_vec3 b) {
    nsdf_vec3 ab = nsdf_vec3_sub(b, a), ap = nsdf_vec3_sub(p, a);
    double length2 = nsdf_vec3_dot(ab, ab);
    double t = length2 > 0.0 ? fmin(fmax(nsdf_vec3_dot(ap, ab) / length2, 0.0), 1.0) : 0.0;
    nsdf_vec3 d = nsdf_vec3_sub(ap, nsdf_vec3_scale(t, ab));
    return nsdf_vec3_dot(d, d);
}

/* Squared distance to a triangle, by barycentric coordinates of the projection. */
static inline double exact_triangle2(nsdf_vec3 p, nsdf_vec3 a, nsdf_vec3 b, nsdf_vec3 c) {
    nsdf_vec3 u = nsdf_vec3_sub(b, a), v = nsdf_vec3_sub(c, a), w = nsdf_vec3_sub(p, a), n = nsdf_vec3_cross(u, v);
    double nn = nsdf_vec3_dot(n, n);
    double least = fmin(exact_segment2(p, a, b), fmin(exact_segment2(p, b, c), exact_segment2(p, c, a)));
    if (nn > 0.0) {
        double s = nsdf_vec3_dot(nsdf_vec3_cross(w, v), n) / nn, t = nsdf_vec3_dot(nsdf_vec3_cross(u, w), n) / nn;
        if (s >= 0.0 && t >= 0.0 && s + t <= 1.0) {
            double h = nsdf_vec3_dot(w, n);
            least = fmin(least, h * h / nn);
        }
    }
    return least;
}

static inline double exact_distance(const nsdf_surface *s, const float point[3]) {
    nsdf_vec3 p = nsdf_vec3_load(point);
    double least = INFINITY;
    for (uint32_t i = 0; i < s->triangle_count; i++) {
        least = fmin(least, exact_triangle2(p, shape_corner(s, i, 0), shape_corner(s, i, 1), shape_corner(s, i, 2)));
    }
    return sqrt(least);
}

/* Winding number by the solid angles of all triangles. */
static inline double exact_winding(const nsdf_surface *s, const float point[3]) {
    nsdf_vec3 p = nsdf_vec3_load(point);
    double sum = 0.0;
    for (uint32_t i = 0; i < s->triangle_count; i++) {
        nsdf_vec3 a = nsdf_vec3_sub(shape_corner(s, i, 0), p), b = nsdf_vec3_sub(shape_corner(s, i, 1), p);
        nsdf_vec3 c = nsdf_vec3_sub(shape_corner(s, i, 2), p);
        double la = nsdf_vec3_length(a), lb = nsdf_vec3_length(b), lc = nsdf_vec3_length(c);
        sum += atan2(nsdf_vec3_dot(a, nsdf_vec3_cross(b, c)),
                     la * lb * lc + nsdf_vec3_dot(a, b) * lc + nsdf_vec3_dot(b, c) * la + nsdf_vec3_dot(c, a) * lb);
    }
    return sum / 6.283185307179586;
}

/* Of a closed mesh. */
static inline double exact_signed(const nsdf_surface *s, const float point[3]) {
    double d = exact_distance(s, point);
    return exact_winding(s, point) > 0.5 ? -d : d;
}

static inline void random_point(nsdf_random *random, float half, float xyz[3]) {
    for (int k = 0; k < 3; k++) {
        xyz[k] = (2.0f * nsdf_random_unit(random) - 1.0f) * half;
    }
}

#endif
