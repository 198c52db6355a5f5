/* Queries per second of the distance to a mesh, near the surface and in the whole box, for each way to find the sign.
 *
 *     bench_sdf [MESH.obj]
 *
 * Without an argument the mesh is a bumpy torus of 20 000 triangles. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "nsdf/sequence.h"
#include "sampler.h"

#define QUERIES 100000

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void torus_point(double u, double v, float xyz[3]) {
    double tau = 6.283185307179586, r = 0.08 * (1.0 + 0.3 * cos(9.0 * tau * u) * sin(4.0 * tau * v));
    xyz[0] = (float)((0.3 + r * cos(tau * v)) * cos(tau * u));
    xyz[1] = (float)((0.3 + r * cos(tau * v)) * sin(tau * u));
    xyz[2] = (float)(r * sin(tau * v));
}

static int make_torus(nsdf_surface *surface, uint32_t around, uint32_t across) {
    surface->vertex_count = around * across;
    surface->triangle_count = 2 * around * across;
    surface->positions = malloc(3 * sizeof(float) * surface->vertex_count);
    surface->indices = malloc(3 * sizeof(uint32_t) * surface->triangle_count);
    if (surface->positions == NULL || surface->indices == NULL) {
        return -1;
    }
    uint32_t *index = surface->indices;
    for (uint32_t i = 0; i < around; i++) {
        for (uint32_t j = 0; j < across; j++) {
            uint32_t i1 = (i + 1) % around, j1 = (j + 1) % across;
            const uint32_t quad[6] = {i * across + j,   i1 * across + j, i1 * across + j1,
                                      i1 * across + j1, i * across + j1, i * across + j};
            for (int k = 0; k < 6; k++) {
                *index++ = quad[k];
            }
            torus_point((double)i / around, (double)j / across, &surface->positions[3 * (size_t)(i * across + j)]);
        }
    }
    return 0;
}

static void extend_box(const nsdf_input_mesh *mesh, double low[3], double high[3]) {
    for (int k = 0; k < 3; k++) {
        low[k] = INFINITY;
        high[k] = -INFINITY;
        for (uint32_t i = 0; i < mesh->vertex_count; i++) {
            low[k] = fmin(low[k], mesh->positions[3 * (size_t)i + (size_t)k]);
            high[k] = fmax(high[k], mesh->positions[3 * (size_t)i + (size_t)k]);
        }
    }
}

/* Centred, divided by the diagonal. */
static int copy_normalised(const nsdf_input_mesh *mesh, nsdf_surface *surface) {
    double low[3], high[3];
    extend_box(mesh, low, high);
    double diagonal = sqrt(pow(high[0] - low[0], 2) + pow(high[1] - low[1], 2) + pow(high[2] - low[2], 2));
    surface->vertex_count = mesh->vertex_count;
    surface->triangle_count = mesh->triangle_count;
    surface->positions = malloc(3 * sizeof(float) * surface->vertex_count);
    surface->indices = malloc(3 * sizeof(uint32_t) * surface->triangle_count);
    if (surface->positions == NULL || surface->indices == NULL) {
        return -1;
    }
    for (size_t i = 0; i < 3 * (size_t)mesh->vertex_count; i++) {
        surface->positions[i] = (float)((mesh->positions[i] - 0.5 * (low[i % 3] + high[i % 3])) / diagonal);
    }
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++) {
        surface->indices[i] = mesh->indices[i];
    }
    return 0;
}

static int load(nsdf_surface *surface, const char *path) {
    nsdf_sequence *sequence = NULL;
    nsdf_input_mesh mesh;
    nsdf_encoder_error error;
    int result = -1;
    double start = seconds();
    if (nsdf_sequence_open(&sequence, &path, 1, &error) == NSDF_OK &&
        nsdf_sequence_load(sequence, 0, &mesh, &error) == NSDF_OK) {
        printf("%-34s %10.2f ms\n", "read the OBJ file", 1e3 * (seconds() - start));
        result = copy_normalised(&mesh, surface);
    } else {
        fprintf(stderr, "bench_sdf: %s\n", error.message);
    }
    nsdf_sequence_close(&sequence);
    return result;
}

static void near_points(const nsdf_surface *surface, float width, float *xyz) {
    nsdf_random random = nsdf_random_start(1, 1);
    if (nsdf_sample_surface(surface, QUERIES, &random, xyz) == 0) {
        for (size_t i = 0; i < 3 * (size_t)QUERIES; i++) {
            xyz[i] += width * nsdf_random_normal(&random);
        }
    }
}

static void box_points(float *xyz) {
    nsdf_random random = nsdf_random_start(1, 2);
    for (size_t i = 0; i < 3 * (size_t)QUERIES; i++) {
        xyz[i] = nsdf_random_unit(&random) - 0.5f;
    }
}

static void time_queries(const char *what, const nsdf_sdf *sdf, const float *xyz) {
    double start = seconds(), sum = 0.0;
    for (size_t i = 0; i < QUERIES; i++) {
        sum += (double)nsdf_sdf_distance(sdf, &xyz[3 * i]);
    }
    double taken = seconds() - start;
    printf("%-34s %10.0f queries/s   mean distance %9.6f\n", what, QUERIES / taken, sum / QUERIES);
}

static void run(const nsdf_surface *surface, float *xyz) {
    static const struct {
        const char *name;
        nsdf_sign_rule rule;
    } rules[] = {
        {"pseudo-normal", NSDF_SIGN_PSEUDO_NORMAL}, {"winding", NSDF_SIGN_WINDING}, {"shell", NSDF_SIGN_SHELL}};
    for (size_t i = 0; i < sizeof rules / sizeof rules[0]; i++) {
        char what[64];
        double start = seconds();
        nsdf_sdf *sdf = nsdf_sdf_create(surface, rules[i].rule, 0.01f);
        if (sdf == NULL) {
            return;
        }
        snprintf(what, sizeof what, "%s: build", rules[i].name);
        printf("%-34s %10.2f ms\n", what, 1e3 * (seconds() - start));
        near_points(surface, 0.002f, xyz);
        snprintf(what, sizeof what, "%s: within 0.002", rules[i].name);
        time_queries(what, sdf, xyz);
        near_points(surface, 0.02f, xyz);
        snprintf(what, sizeof what, "%s: within 0.02", rules[i].name);
        time_queries(what, sdf, xyz);
        box_points(xyz);
        snprintf(what, sizeof what, "%s: in the box", rules[i].name);
        time_queries(what, sdf, xyz);
        nsdf_sdf_free(sdf);
    }
}

int main(int argc, char **argv) {
    nsdf_surface surface = {0};
    float *xyz = malloc(3 * sizeof(float) * QUERIES);
    int failed = argc > 1 ? load(&surface, argv[1]) : make_torus(&surface, 200, 50);
    if (failed == 0 && xyz != NULL) {
        printf("%u vertices, %u triangles\n", surface.vertex_count, surface.triangle_count);
        run(&surface, xyz);
    }
    nsdf_surface_free(&surface);
    free(xyz);
    return failed == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
