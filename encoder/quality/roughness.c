#include "roughness.h"

#include <math.h>
#include <stdlib.h>

#include "triangle.h"

#define PI 3.141592653589793

/* The constants of the authors' program. */
static const double least_cotangent = 0.001, largest_cotangent = 1000.0; /* of half the cotangents */
static const double low_threshold = 5e-4, high_threshold = 0.2;          /* Th_l, and the least Th_h, of (6.8) */
static const double high_threshold_means = 5.0;                          /* Th_h in means of the smoother surface */
static const double power = 0.15;                                        /* a of (6.8) */
static const double reduction = 0.5;                                     /* b of (6.10) */
static const double scale = 8.0;                                         /* c of (6.12) */

static double clamp(double x, double low, double high) {
    return fmin(fmax(x, low), high);
}

static nsdf_triangle load_triangle(const double *positions, const uint32_t index[3]) {
    nsdf_triangle t;
    for (int i = 0; i < 3; i++) {
        const double *p = &positions[3 * (size_t)index[i]];
        t.corner[i] = (nsdf_vec3){p[0], p[1], p[2]};
    }
    return t;
}

/* Adds up the angles at the corners and the shares of area. */
static void add_angles(nsdf_roughness *r, const nsdf_surface *surface, const double *positions, double *angle_sum) {
    for (uint32_t i = 0; i < surface->triangle_count; i++) {
        const uint32_t *index = &surface->indices[3 * (size_t)i];
        nsdf_triangle t = load_triangle(positions, index);
        nsdf_vec3 cross =
            nsdf_vec3_cross(nsdf_vec3_sub(t.corner[1], t.corner[0]), nsdf_vec3_sub(t.corner[2], t.corner[0]));
        double third = nsdf_vec3_length(cross) / 6.0;
        for (int k = 0; k < 3; k++) {
            angle_sum[index[k]] += nsdf_triangle_angle(&t, k);
            r->share[index[k]] += third;
        }
    }
}

/* Turns sums of angles into absolute curvature; 0 where there is no triangle. */
static void curvature_of_angles(const nsdf_roughness *r, const nsdf_edge_table *edges, double *angle_sum) {
    for (uint32_t i = 0; i < r->vertex_count; i++) {
        r->local[i] = 2.0 * PI;
    }
    for (size_t i = 0; i < edges->slot_count; i++) {
        const nsdf_edge *edge = &edges->slots[i];
        if (nsdf_edge_uses(edge) > 0 && (edge->up == 0 || edge->down == 0)) {
            r->local[edge->low] = r->local[edge->high] = PI;
        }
    }
    for (uint32_t i = 0; i < r->vertex_count; i++) {
        angle_sum[i] = angle_sum[i] > 0.0 ? fabs(r->local[i] - angle_sum[i]) : 0.0;
    }
}

/* For every vertex, the weights of its edges (6.6), and the curvatures at their other ends times these. */
static void add_edges(const nsdf_surface *surface, const double *positions, const double *curvature, double *weight,
                      double *neighbours) {
    for (uint32_t i = 0; i < surface->triangle_count; i++) {
        const uint32_t *index = &surface->indices[3 * (size_t)i];
        nsdf_triangle t = load_triangle(positions, index);
        for (int k = 0; k < 3; k++) {
            int a = (k + 1) % 3, b = (k + 2) % 3;
            nsdf_vec3 u = nsdf_vec3_sub(t.corner[a], t.corner[k]), v = nsdf_vec3_sub(t.corner[b], t.corner[k]);
            double sine = nsdf_vec3_length(nsdf_vec3_cross(u, v)), cosine = nsdf_vec3_dot(u, v);
            double half = sine > 0.0 ? 0.5 * cosine / sine : cosine > 0.0 ? largest_cotangent : least_cotangent;
            half = clamp(half, least_cotangent, largest_cotangent);
            weight[index[a]] += half;
            weight[index[b]] += half;
            neighbours[index[a]] += half * curvature[index[b]];
            neighbours[index[b]] += half * curvature[index[a]];
        }
    }
}

static void finish(nsdf_roughness *r, const double *curvature, const double *weight, const double *neighbours) {
    double sum = 0.0;
    for (uint32_t i = 0; i < r->vertex_count; i++) {
        r->local[i] = weight[i] > 0.0 ? fabs(curvature[i] - neighbours[i] / weight[i]) : 0.0;
        r->area += r->share[i];
        sum += r->share[i] * r->local[i];
    }
    r->mean = r->area > 0.0 ? sum / r->area : 0.0;
}

int nsdf_roughness_measure(nsdf_roughness *roughness, const nsdf_surface *surface, const double *positions,
                           const nsdf_edge_table *edges) {
    size_t count = surface->vertex_count;
    double *work = calloc(3 * count, sizeof *work);
    *roughness =
        (nsdf_roughness){calloc(count, sizeof(double)), calloc(count, sizeof(double)), surface->vertex_count, 0, 0};
    int result = -1;
    if (work != NULL && roughness->local != NULL && roughness->share != NULL) {
        double *curvature = work, *weight = work + count, *neighbours = work + 2 * count;
        add_angles(roughness, surface, positions, curvature);
        curvature_of_angles(roughness, edges, curvature);
        add_edges(surface, positions, curvature, weight, neighbours);
        finish(roughness, curvature, weight, neighbours);
        result = 0;
    }
    free(work);
    return result;
}

void nsdf_roughness_free(nsdf_roughness *roughness) {
    free(roughness->local);
    free(roughness->share);
    *roughness = (nsdf_roughness){0};
}

static double modulate(double roughness) {
    return pow(roughness, power) - pow(low_threshold, power);
}

void nsdf_roughness_global(const nsdf_roughness pair[2], double global[2]) {
    double smoother = fmin(pair[0].mean, pair[1].mean);
    double top = fmax(high_threshold, high_threshold_means * smoother);
    double turn = modulate(fmax(smoother, low_threshold));
    for (int k = 0; k < 2; k++) {
        double sum = 0.0;
        for (uint32_t i = 0; i < pair[k].vertex_count; i++) {
            double value = modulate(clamp(pair[k].local[i], low_threshold, top));
            sum += pair[k].share[i] * (value > turn ? turn + reduction * (value - turn) : value);
        }
        global[k] = pair[k].area > 0.0 ? sum / pair[k].area : 0.0;
    }
}

double nsdf_fmpd(const double global[2]) {
    return fmin(1.0, scale * fabs(global[0] - global[1]));
}
