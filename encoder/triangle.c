/* Nearest point on a triangle, by the plane when the query is above the inside and by the three edges when not:
 * both are well conditioned for needles and slivers too, which barycentric coordinates are not. */
#include "triangle.h"

nsdf_vec3 nsdf_triangle_cross(const nsdf_triangle *triangle) {
    nsdf_vec3 ab = nsdf_vec3_sub(triangle->corner[1], triangle->corner[0]);
    nsdf_vec3 ac = nsdf_vec3_sub(triangle->corner[2], triangle->corner[0]);
    nsdf_vec3 cross = nsdf_vec3_cross(ab, ac);
    double length = fmax(nsdf_vec3_dot(ab, ab), nsdf_vec3_dot(ac, ac));
    double limit = 1e-13 * length;
    if (nsdf_vec3_dot(cross, cross) <= limit * limit) {
        return (nsdf_vec3){0.0, 0.0, 0.0};
    }
    return cross;
}

double nsdf_triangle_angle(const nsdf_triangle *triangle, int corner) {
    nsdf_vec3 here = triangle->corner[corner];
    nsdf_vec3 u = nsdf_vec3_sub(triangle->corner[(corner + 1) % 3], here);
    nsdf_vec3 v = nsdf_vec3_sub(triangle->corner[(corner + 2) % 3], here);
    nsdf_vec3 cross = nsdf_vec3_cross(u, v);
    return atan2(nsdf_vec3_length(cross), nsdf_vec3_dot(u, v));
}

static bool is_above_inside(const nsdf_triangle *triangle, nsdf_vec3 cross, nsdf_vec3 query) {
    for (int i = 0; i < 3; i++) {
        nsdf_vec3 edge = nsdf_vec3_sub(triangle->corner[(i + 1) % 3], triangle->corner[i]);
        nsdf_vec3 to_query = nsdf_vec3_sub(query, triangle->corner[i]);
        if (!(nsdf_vec3_dot(cross, nsdf_vec3_cross(edge, to_query)) > 0.0)) {
            return false;
        }
    }
    return true;
}

static void hit_edge(const nsdf_triangle *triangle, int edge, nsdf_vec3 query, nsdf_triangle_hit *hit) {
    int next = (edge + 1) % 3;
    nsdf_vec3 from = triangle->corner[edge], to = triangle->corner[next];
    nsdf_vec3 along = nsdf_vec3_sub(to, from);
    double length2 = nsdf_vec3_dot(along, along), t = nsdf_vec3_dot(nsdf_vec3_sub(query, from), along);
    nsdf_vec3 point;
    if (t <= 0.0) {
        point = from;
    } else if (t >= length2) {
        point = to;
    } else {
        point = nsdf_vec3_mad(from, t / length2, along);
    }
    nsdf_vec3 offset = nsdf_vec3_sub(query, point);
    double distance2 = nsdf_vec3_dot(offset, offset);
    if (distance2 < hit->distance2) {
        hit->point = point;
        hit->offset = offset;
        hit->distance2 = distance2;
        hit->feature = t <= 0.0 || t >= length2 ? NSDF_HIT_CORNER : NSDF_HIT_EDGE;
        hit->corner = t <= 0.0 ? edge : next;
    }
}

nsdf_triangle_hit nsdf_triangle_nearest(const nsdf_triangle *triangle, nsdf_vec3 query) {
    nsdf_triangle_hit hit = {.cross = nsdf_triangle_cross(triangle), .distance2 = INFINITY, .feature = NSDF_HIT_FACE};
    if (is_above_inside(triangle, hit.cross, query)) {
        double height = nsdf_vec3_dot(hit.cross, nsdf_vec3_sub(query, triangle->corner[0]));
        double square = nsdf_vec3_dot(hit.cross, hit.cross);
        hit.offset = nsdf_vec3_scale(height / square, hit.cross);
        hit.point = nsdf_vec3_sub(query, hit.offset);
        hit.distance2 = height * height / square;
        return hit;
    }
    for (int edge = 0; edge < 3; edge++) {
        hit_edge(triangle, edge, query, &hit);
    }
    return hit;
}
