#include "compared_mesh.h"

#include <math.h>
#include <stdlib.h>

#include "hidden.h"
#include "weld.h"

/* Squares of squares of what is smaller would not be numbers any more. */
static const double least_diagonal = 1e-30;

/* Only vertices that a triangle uses belong to the surface. */
static void extend_box(const nsdf_input_mesh *mesh, double low[3], double high[3]) {
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++) {
        for (size_t k = 0; k < 3; k++) {
            double x = mesh->positions[3 * (size_t)mesh->indices[i] + k];
            low[k] = x < low[k] ? x : low[k];
            high[k] = x > high[k] ? x : high[k];
        }
    }
}

nsdf_pair_frame nsdf_pair_frame_of(const nsdf_input_mesh *first, const nsdf_input_mesh *second) {
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    nsdf_pair_frame frame = {{0.0, 0.0, 0.0}, 0.0};
    extend_box(first, low, high);
    extend_box(second, low, high);
    for (int k = 0; k < 3; k++) {
        frame.centre[k] = 0.5 * (low[k] + high[k]);
        frame.diagonal = hypot(frame.diagonal, high[k] - low[k]);
    }
    frame.diagonal = frame.diagonal < least_diagonal ? 0.0 : frame.diagonal;
    return frame;
}

static int copy_surface(nsdf_surface *surface, const nsdf_input_mesh *mesh, const nsdf_pair_frame *frame) {
    size_t positions = 3 * (size_t)mesh->vertex_count, indices = 3 * (size_t)mesh->triangle_count;
    *surface = (nsdf_surface){malloc(positions * sizeof(float)), malloc(indices * sizeof(uint32_t)), mesh->vertex_count,
                              mesh->triangle_count};
    if (surface->positions == NULL || surface->indices == NULL) {
        return -1;
    }
    for (size_t i = 0; i < positions; i++) {
        surface->positions[i] = (float)((mesh->positions[i] - frame->centre[i % 3]) / frame->diagonal);
    }
    for (size_t i = 0; i < indices; i++) {
        surface->indices[i] = mesh->indices[i];
    }
    return nsdf_weld_surface(surface);
}

/* Only what an observer outside of the bodies meets stays. */
static int leave_out_hidden(nsdf_compared_mesh *compared) {
    nsdf_surface bodies = {0}, outer = {0};
    int result = nsdf_find_bodies(&compared->whole, &bodies);
    if (result == 0) {
        result = nsdf_find_outer(&compared->whole, &bodies, 1, &outer);
    }
    if (outer.triangle_count > 0) {
        compared->surface = outer;
        compared->hidden_share = 1.0 - nsdf_surface_area(&outer) / nsdf_surface_area(&compared->whole);
    }
    free(bodies.indices);
    return result;
}

static int make_room(nsdf_compared_mesh *compared) {
    const nsdf_surface *surface = &compared->surface;
    compared->used = calloc(surface->vertex_count, sizeof *compared->used);
    compared->points = malloc(3 * sizeof(float) * (size_t)compared->samples);
    compared->triangles = malloc(sizeof(uint32_t) * (size_t)compared->samples);
    if (compared->used == NULL || compared->points == NULL || compared->triangles == NULL) {
        return -1;
    }
    for (size_t i = 0; i < 3 * (size_t)surface->triangle_count; i++) {
        compared->used[surface->indices[i]] = true;
    }
    return 0;
}

int nsdf_compared_mesh_prepare(nsdf_compared_mesh *compared, const nsdf_input_mesh *mesh, const nsdf_pair_frame *frame,
                               uint32_t samples, bool outer) {
    *compared = (nsdf_compared_mesh){.mesh = mesh, .samples = samples};
    const int copied = copy_surface(&compared->whole, mesh, frame);
    compared->surface = compared->whole;
    if (copied != 0 || compared->whole.triangle_count == 0) {
        return copied;
    }
    if (outer && leave_out_hidden(compared) != 0) {
        return -1;
    }
    return make_room(compared) == 0 && nsdf_nearest_index_build(&compared->index, &compared->surface, true) == 0 &&
                   nsdf_area_table_create(&compared->areas, &compared->surface) == 0
               ? 0
               : -1;
}

void nsdf_compared_mesh_free(nsdf_compared_mesh *compared) {
    nsdf_nearest_index_free(&compared->index);
    nsdf_nearest_index_free(&compared->cloud_index);
    nsdf_area_table_free(&compared->areas);
    if (compared->surface.indices != compared->whole.indices) {
        free(compared->surface.indices);
    }
    nsdf_surface_free(&compared->whole);
    free(compared->cloud.indices); /* its positions are the points */
    free(compared->used);
    free(compared->points);
    free(compared->triangles);
    *compared = (nsdf_compared_mesh){0};
}

void nsdf_compared_mesh_draw(nsdf_compared_mesh *compared, uint32_t chunk, uint64_t seed) {
    nsdf_random random = nsdf_random_start(seed, chunk);
    uint32_t end = nsdf_chunk_end(chunk, compared->samples);
    for (uint32_t i = chunk * NSDF_COMPARE_CHUNK; i < end; i++) {
        compared->triangles[i] = nsdf_area_table_draw_share(&compared->areas, i, compared->samples, &random,
                                                            &compared->points[3 * (size_t)i]);
    }
}

int nsdf_compared_mesh_index_points(nsdf_compared_mesh *compared) {
    uint32_t count = compared->samples;
    compared->cloud = (nsdf_surface){compared->points, malloc(3 * sizeof(uint32_t) * (size_t)count), count, count};
    if (compared->cloud.indices == NULL) {
        return -1;
    }
    for (size_t i = 0; i < 3 * (size_t)count; i++) {
        compared->cloud.indices[i] = (uint32_t)(i / 3);
    }
    return nsdf_nearest_index_build(&compared->cloud_index, &compared->cloud, false);
}
