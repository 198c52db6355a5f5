/* Meshes in world units, and comparing them in one line, for the tests of nsdf/compare.h. */
#ifndef COMPARE_SHAPES_H
#define COMPARE_SHAPES_H

#include <math.h>
#include <stdlib.h>

#include "nsdf/compare.h"
#include "surface.h"

#define assert_near(value, expected, tolerance) assert_true(fabs((value) - (expected)) <= (tolerance))

typedef struct world_mesh {
    double *positions;
    uint32_t *indices;
    uint32_t vertex_count, triangle_count;
} world_mesh;

/* The surface times `scale`, moved by (x, y, z). */
static inline world_mesh world_copy(const nsdf_surface *from, double scale, double x, double y, double z) {
    const double shift[3] = {x, y, z};
    size_t positions = 3 * (size_t)from->vertex_count, indices = 3 * (size_t)from->triangle_count;
    world_mesh mesh = {malloc(positions * sizeof(double)), malloc(indices * sizeof(uint32_t)), from->vertex_count,
                       from->triangle_count};
    for (size_t i = 0; i < positions; i++) {
        mesh.positions[i] = scale * (double)from->positions[i] + shift[i % 3];
    }
    for (size_t i = 0; i < indices; i++) {
        mesh.indices[i] = from->indices[i];
    }
    return mesh;
}

/* A square of n by n quads, x and y from `low` to `high`, facing up. */
static inline world_mesh world_square(double low, double high, uint32_t n) {
    uint32_t vertices = (n + 1) * (n + 1);
    world_mesh mesh = {malloc(3 * vertices * sizeof(double)), malloc(6 * n * n * sizeof(uint32_t)), vertices,
                       2 * n * n};
    uint32_t *index = mesh.indices;
    for (uint32_t i = 0; i < vertices; i++) {
        mesh.positions[3 * i] = low + (high - low) * (i % (n + 1)) / n;
        mesh.positions[3 * i + 1] = low + (high - low) * (i / (n + 1)) / n;
        mesh.positions[3 * i + 2] = 0.0;
    }
    for (uint32_t i = 0; i < n * n; i++) {
        uint32_t a = i / n * (n + 1) + i % n, b = a + 1, c = a + n + 2, d = a + n + 1;
        const uint32_t quad[6] = {a, b, c, a, c, d};
        for (int k = 0; k < 6; k++) {
            *index++ = quad[k];
        }
    }
    return mesh;
}

/* Turns (x, z) by an angle, and adds to z. */
static inline void world_tilt(world_mesh *mesh, double angle, double lift) {
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        double *p = &mesh->positions[3 * i], x = p[0];
        p[0] = cos(angle) * x - sin(angle) * p[2];
        p[2] = sin(angle) * x + cos(angle) * p[2] + lift;
    }
}

/* Turns all triangles round. */
static inline void world_flip(world_mesh *mesh) {
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        uint32_t *t = &mesh->indices[3 * i], second = t[1];
        t[1] = t[2];
        t[2] = second;
    }
}

static inline void world_free(world_mesh *mesh) {
    free(mesh->positions);
    free(mesh->indices);
}

static inline nsdf_input_mesh world_view(const world_mesh *mesh) {
    return (nsdf_input_mesh){mesh->positions, mesh->indices, mesh->vertex_count, mesh->triangle_count};
}

static inline nsdf_difference compare_with(const world_mesh *reference, const world_mesh *decoded,
                                           const nsdf_compare_options *options, double *vertex_distance) {
    nsdf_input_mesh a = world_view(reference), b = world_view(decoded);
    nsdf_encoder_error error = {NSDF_OK, ""};
    nsdf_compare *compare = NULL;
    nsdf_difference difference = {0};
    assert_int_equal(nsdf_compare_create(&compare, options, &error), NSDF_OK);
    assert_int_equal(nsdf_compare_frame(compare, &a, &b, vertex_distance, &difference, &error), NSDF_OK);
    nsdf_compare_close(&compare);
    assert_null(compare);
    return difference;
}

static inline nsdf_difference compare_meshes(const world_mesh *reference, const world_mesh *decoded, uint32_t samples,
                                             uint32_t measures) {
    nsdf_compare_options options;
    nsdf_compare_options_init(&options);
    options.samples = samples;
    options.measures = measures;
    options.threads = 2;
    return compare_with(reference, decoded, &options, NULL);
}

static inline void assert_same_distances(const nsdf_distances *a, const nsdf_distances *b) {
    assert_memory_equal(a, b, sizeof *a);
}

static inline void assert_same_shape(const nsdf_shape *a, const nsdf_shape *b) {
    assert_int_equal(a->components, b->components);
    assert_int_equal(a->euler, b->euler);
    assert_int_equal(a->open_edges, b->open_edges);
    assert_true(a->area == b->area);
    assert_true(a->volume == b->volume);
    assert_true(a->roughness == b->roughness);
}

#endif
