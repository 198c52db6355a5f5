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

#endif
