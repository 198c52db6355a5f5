#include "obj_polygon.h"

#include <stdbool.h>
#include <stddef.h>

#include "vec3.h"

static nsdf_vec3 position(const double *positions, uint32_t vertex) {
    const double *p = &positions[3 * (size_t)vertex];
    return (nsdf_vec3){p[0], p[1], p[2]};
}

static nsdf_vec3 cross_of(nsdf_vec3 a, nsdf_vec3 b, nsdf_vec3 c) {
    return nsdf_vec3_cross(nsdf_vec3_sub(b, a), nsdf_vec3_sub(c, a));
}

static double distance2(nsdf_vec3 a, nsdf_vec3 b) {
    nsdf_vec3 d = nsdf_vec3_sub(a, b);
    return nsdf_vec3_dot(d, d);
}

static void improve_quadrilateral(const double *positions, uint32_t *fan) {
    const uint32_t corner[4] = {fan[0], fan[1], fan[2], fan[5]};
    nsdf_vec3 p[4];
    for (int i = 0; i < 4; i++) {
        p[i] = position(positions, corner[i]);
    }
    bool first = nsdf_vec3_dot(cross_of(p[0], p[1], p[2]), cross_of(p[0], p[2], p[3])) > 0.0;
    bool second = nsdf_vec3_dot(cross_of(p[1], p[2], p[3]), cross_of(p[1], p[3], p[0])) > 0.0;
    if (second && (!first || distance2(p[1], p[3]) < distance2(p[0], p[2]))) {
        const uint32_t cut[6] = {corner[1], corner[2], corner[3], corner[1], corner[3], corner[0]};
        for (int i = 0; i < 6; i++) {
            fan[i] = cut[i];
        }
    }
}

typedef struct polygon {
    uint32_t count;
    uint32_t vertex[NSDF_MAX_CLIPPED_CORNERS];
    double x[NSDF_MAX_CLIPPED_CORNERS], y[NSDF_MAX_CLIPPED_CORNERS]; /* in its plane, counter-clockwise */
} polygon;

/* Drops the axis on which the normal is largest, so that the outline is counter-clockwise. */
static void flatten(polygon *poly, const double *positions) {
    nsdf_vec3 origin = position(positions, poly->vertex[0]), normal = {0.0, 0.0, 0.0};
    for (uint32_t i = 2; i < poly->count; i++) {
        nsdf_vec3 a = position(positions, poly->vertex[i - 1]), b = position(positions, poly->vertex[i]);
        normal = nsdf_vec3_add(normal, cross_of(origin, a, b));
    }
    double ax = fabs(normal.x), ay = fabs(normal.y), az = fabs(normal.z);
    for (uint32_t i = 0; i < poly->count; i++) {
        nsdf_vec3 p = nsdf_vec3_sub(position(positions, poly->vertex[i]), origin);
        double u = ax >= ay && ax >= az ? p.y : ay >= az ? p.z : p.x;
        double v = ax >= ay && ax >= az ? p.z : ay >= az ? p.x : p.y;
        bool flipped = (ax >= ay && ax >= az ? normal.x : ay >= az ? normal.y : normal.z) < 0.0;
        poly->x[i] = flipped ? v : u;
        poly->y[i] = flipped ? u : v;
    }
}

static double turn(const polygon *p, uint32_t a, uint32_t b, uint32_t c) {
    return (p->x[b] - p->x[a]) * (p->y[c] - p->y[a]) - (p->y[b] - p->y[a]) * (p->x[c] - p->x[a]);
}

/* Whether corner i is convex and no other corner lies in the triangle that it makes with its neighbours. */
static bool is_ear(const polygon *p, uint32_t i) {
    uint32_t before = (i + p->count - 1) % p->count, after = (i + 1) % p->count;
    if (!(turn(p, before, i, after) > 0.0)) {
        return false;
    }
    for (uint32_t k = 0; k < p->count; k++) {
        bool corner =
            p->vertex[k] == p->vertex[before] || p->vertex[k] == p->vertex[i] || p->vertex[k] == p->vertex[after];
        if (!corner && turn(p, before, i, k) >= 0.0 && turn(p, i, after, k) >= 0.0 &&
            turn(p, after, before, k) >= 0.0) {
            return false;
        }
    }
    return true;
}

static void remove_corner(polygon *p, uint32_t i) {
    p->count--;
    for (; i < p->count; i++) {
        p->vertex[i] = p->vertex[i + 1];
        p->x[i] = p->x[i + 1];
        p->y[i] = p->y[i + 1];
    }
}

/* Outlines that cross themselves may have no ear: the next corner is cut then. */
static void clip_ears(polygon *p, uint32_t *triangles) {
    uint32_t at = 0;
    while (p->count >= 3) {
        uint32_t ear = at % p->count;
        for (uint32_t tried = 0; tried < p->count && p->count > 3; tried++) {
            uint32_t i = (at + tried) % p->count;
            if (is_ear(p, i)) {
                ear = i;
                break;
            }
        }
        *triangles++ = p->vertex[(ear + p->count - 1) % p->count];
        *triangles++ = p->vertex[ear];
        *triangles++ = p->vertex[(ear + 1) % p->count];
        remove_corner(p, ear);
        at = ear + 1;
    }
}

void nsdf_improve_fan(const double *positions, uint32_t *fan, uint32_t corners) {
    if (corners == 4) {
        improve_quadrilateral(positions, fan);
    } else if (corners > 4 && corners <= NSDF_MAX_CLIPPED_CORNERS) {
        polygon p;
        p.count = corners;
        p.vertex[0] = fan[0];
        for (uint32_t i = 1; i < corners; i++) {
            p.vertex[i] = i + 1 < corners ? fan[3 * (size_t)(i - 1) + 1] : fan[3 * (size_t)(corners - 3) + 2];
        }
        flatten(&p, positions);
        clip_ears(&p, fan);
    }
}
