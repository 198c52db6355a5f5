#include "surface_error.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "sampler.h"
#include "weld.h"

static double distance_to(const nsdf_sdf *to, const float point[3]) {
    return (double)nsdf_sdf_unsigned(to, point, INFINITY, NULL);
}

/* Most vertices are nearer than the farthest so far. */
static void add_vertices(const nsdf_surface *from, const nsdf_sdf *to, bool *seen, nsdf_distance_stats *stats) {
    for (size_t i = 0; i < 3 * (size_t)from->triangle_count; i++) {
        uint32_t vertex = from->indices[i];
        if (!seen[vertex]) {
            const float *point = &from->positions[3 * (size_t)vertex];
            seen[vertex] = true;
            if (!nsdf_sdf_is_within(to, point, (float)stats->max)) {
                stats->max = fmax(stats->max, distance_to(to, point));
            }
        }
    }
}

static void add_samples(const float *xyz, size_t count, const nsdf_sdf *to, nsdf_distance_stats *stats) {
    for (size_t i = 0; i < count; i++) {
        double distance = distance_to(to, &xyz[3 * i]);
        stats->sum += distance;
        stats->sum_squares += distance * distance;
        stats->max = fmax(stats->max, distance);
    }
    stats->count += count;
}

int nsdf_add_surface_distances(const nsdf_surface *from, const nsdf_sdf *to, size_t samples, nsdf_random *random,
                               nsdf_distance_stats *stats) {
    bool *seen = calloc((size_t)from->vertex_count + 1, sizeof *seen);
    float *xyz = malloc(3 * samples * sizeof *xyz + 1);
    int result = -1;
    if (seen != NULL && xyz != NULL && (samples == 0 || nsdf_sample_surface(from, samples, random, xyz) == 0)) {
        add_vertices(from, to, seen, stats);
        add_samples(xyz, samples, to, stats);
        result = 0;
    }
    free(seen);
    free(xyz);
    return result;
}

/* Finds the root of a vertex's tree and halves the path to it. */
static uint32_t root_of(uint32_t *parent, uint32_t vertex) {
    while (parent[vertex] != vertex) {
        parent[vertex] = parent[parent[vertex]];
        vertex = parent[vertex];
    }
    return vertex;
}

static void unite(uint32_t *parent, uint32_t a, uint32_t b) {
    a = root_of(parent, a);
    b = root_of(parent, b);
    /* The lower number stays a root: vertices after it in the weld table point downwards already. */
    parent[a > b ? a : b] = a > b ? b : a;
}

static int64_t number_components(const nsdf_surface *surface, uint32_t *parent, uint32_t *number, uint32_t *component) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < surface->vertex_count; i++) {
        number[i] = UINT32_MAX;
    }
    for (uint32_t i = 0; i < surface->triangle_count; i++) {
        uint32_t root = root_of(parent, surface->indices[3 * (size_t)i]);
        if (number[root] == UINT32_MAX) {
            number[root] = count++;
        }
        component[i] = number[root];
    }
    return count;
}

int64_t nsdf_surface_components(const nsdf_surface *surface, uint32_t *component) {
    uint32_t *parent = malloc(((size_t)surface->vertex_count + 1) * sizeof *parent);
    uint32_t *number = malloc(((size_t)surface->vertex_count + 1) * sizeof *number);
    int64_t count = -1;
    if (parent != NULL && number != NULL && nsdf_weld_vertices(surface, parent) == 0) {
        for (uint32_t i = 0; i < surface->triangle_count; i++) {
            const uint32_t *index = &surface->indices[3 * (size_t)i];
            unite(parent, index[0], index[1]);
            unite(parent, index[0], index[2]);
        }
        count = number_components(surface, parent, number, component);
    }
    free(parent);
    free(number);
    return count;
}

uint32_t nsdf_largest_piece(const nsdf_surface *surface, const uint32_t *piece, uint32_t count, uint32_t *triangles) {
    uint32_t largest = 0;
    memset(triangles, 0, count * sizeof *triangles);
    for (uint32_t i = 0; i < surface->triangle_count; i++)
        triangles[piece[i]]++;
    for (uint32_t p = 1; p < count; p++)
        largest = triangles[p] > triangles[largest] ? p : largest;
    return largest;
}

static void extend(float box[6], const float position[3]) {
    for (int a = 0; a < 3; a++) {
        box[a] = fminf(box[a], position[a]);
        box[a + 3] = fmaxf(box[a + 3], position[a]);
    }
}

int nsdf_piece_sizes(const nsdf_surface *surface, const uint32_t *piece, uint32_t count, float *sizes) {
    float(*boxes)[6] = malloc(((size_t)count + 1) * sizeof *boxes);
    if (!boxes)
        return -1;
    for (uint32_t i = 0; i < count; i++)
        for (int a = 0; a < 3; a++) {
            boxes[i][a] = INFINITY;
            boxes[i][a + 3] = -INFINITY;
        }
    for (size_t i = 0; i < 3 * (size_t)surface->triangle_count; i++)
        extend(boxes[piece[i / 3]], surface->positions + 3 * (size_t)surface->indices[i]);
    for (uint32_t i = 0; i < count; i++) {
        float square = 0.0f;
        for (int a = 0; a < 3; a++)
            square += (boxes[i][a + 3] - boxes[i][a]) * (boxes[i][a + 3] - boxes[i][a]);
        sizes[i] = sqrtf(square);
    }
    free(boxes);
    return 0;
}
