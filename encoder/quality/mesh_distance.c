#include "mesh_distance.h"

#include <math.h>

#include "triangle.h"

/* What the rounding of single-precision coordinates of up to 1/2 may make of 0. */
static const double least_distance = 0x1p-22;
/* Further away, in diagonals, the distance to a surface is that to its centre, to the precision of the coordinates. */
static const float far_away = 1e7f;

/* Searches along a sequence of points: the nearest is not further than the last point's nearest. */
typedef struct trail {
    const nsdf_nearest_index *index;
    float point[3], distance;
    float limit; /* of the last search */
} trail;

static trail begin_trail(const nsdf_nearest_index *index) {
    return (trail){index, {0.0f, 0.0f, 0.0f}, INFINITY, INFINITY};
}

static nsdf_nearest find_along(trail *t, const float point[3]) {
    float x = point[0] - t->point[0], y = point[1] - t->point[1], z = point[2] - t->point[2];
    t->limit = (t->distance + sqrtf(x * x + y * y + z * z)) * 1.00001f + 1e-6f;
    nsdf_nearest found = nsdf_find_nearest(t->index, point, t->limit);
    for (int k = 0; k < 3; k++) {
        t->point[k] = point[k];
    }
    t->distance = (float)sqrt(found.distance2);
    return found;
}

static double distance_of(const nsdf_nearest *found) {
    double distance = sqrt(found->distance2);
    return distance < least_distance ? 0.0 : distance;
}

/* Radians; 0 where a normal is 0. */
static double angle_between(nsdf_vec3 a, nsdf_vec3 b) {
    return atan2(nsdf_vec3_length(nsdf_vec3_cross(a, b)), nsdf_vec3_dot(a, b));
}

/* Where the surfaces touch, both may have an edge there: then the pseudo-normals of both count. */
static nsdf_vec3 normal_at(const nsdf_compared_mesh *from, uint32_t sample, double distance, float limit) {
    if (distance == 0.0) {
        return nsdf_find_nearest(&from->index, &from->points[3 * (size_t)sample], limit).normal;
    }
    nsdf_triangle triangle = nsdf_triangle_load(&from->surface, from->triangles[sample]);
    return nsdf_triangle_cross(&triangle);
}

void nsdf_measure_points(const nsdf_distance_task *task, uint32_t chunk, nsdf_distance_sums *sums) {
    const nsdf_compared_mesh *from = task->from;
    trail surface = begin_trail(&task->to->index), cloud = begin_trail(&task->to->cloud_index);
    nsdf_distance_sums s = {0};
    uint32_t end = nsdf_chunk_end(chunk, from->samples);
    for (uint32_t i = chunk * NSDF_COMPARE_CHUNK; i < end; i++) {
        const float *point = &from->points[3 * (size_t)i];
        nsdf_nearest found = find_along(&surface, point);
        double distance = distance_of(&found);
        s.sum += distance;
        s.sum_squares += distance * distance;
        s.max = fmax(s.max, distance);
        if (task->normals) {
            double angle = angle_between(normal_at(from, i, distance, surface.limit), found.normal);
            s.angle_sum += angle;
            s.angle_squares += angle * angle;
        }
        if (task->points) {
            nsdf_nearest nearest = find_along(&cloud, point);
            s.point_squares += distance_of(&nearest) * distance_of(&nearest);
        }
    }
    *sums = s;
}

static bool is_far(const float point[3]) {
    return !(fabsf(point[0]) < far_away && fabsf(point[1]) < far_away && fabsf(point[2]) < far_away);
}

void nsdf_measure_vertices(const nsdf_distance_task *task, uint32_t chunk, double unit, double *distance, double *max) {
    const nsdf_compared_mesh *from = task->from;
    trail surface = begin_trail(&task->to->index);
    uint32_t end = nsdf_chunk_end(chunk, from->surface.vertex_count);
    *max = 0.0;
    for (uint32_t i = chunk * NSDF_COMPARE_CHUNK; i < end; i++) {
        const float *point = &from->surface.positions[3 * (size_t)i];
        if (from->used[i] || (distance != NULL && !is_far(point))) {
            nsdf_nearest found = find_along(&surface, point);
            double d = distance_of(&found);
            *max = from->used[i] ? fmax(*max, d) : *max;
            if (distance != NULL) {
                distance[i] = unit * d;
            }
        } else if (distance != NULL) {
            distance[i] = unit * hypot(hypot((double)point[0], (double)point[1]), (double)point[2]);
        }
    }
}
