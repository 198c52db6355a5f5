/* FMPD against formulas for small shapes, against a slow computation with matrices, and what it must not depend on. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "compare_shapes.h"
#include "geometry_shapes.h"

#define PI 3.141592653589793

/* A surface whose vertices are of two kinds: roughness, and total share of the area. */
typedef struct two_kinds {
    double roughness[2], share[2];
} two_kinds;

static double modulated(double roughness) {
    return pow(roughness, 0.15) - pow(5e-4, 0.15);
}

static double mean_of(const two_kinds *t) {
    return (t->roughness[0] * t->share[0] + t->roughness[1] * t->share[1]) / (t->share[0] + t->share[1]);
}

static double global_of(const two_kinds *t, double smaller_mean) {
    double top = fmax(0.2, 5.0 * smaller_mean), turn = modulated(smaller_mean), sum = 0.0;
    for (int k = 0; k < 2; k++) {
        double value = modulated(fmin(fmax(t->roughness[k], 5e-4), top));
        sum += t->share[k] * (value <= turn ? value : turn + 0.5 * (value - turn));
    }
    return sum / (t->share[0] + t->share[1]);
}

static void assert_fmpd(const world_mesh mesh[2], const two_kinds kinds[2]) {
    nsdf_difference d = compare_meshes(&mesh[0], &mesh[1], 10, NSDF_COMPARE_FMPD);
    double smaller = fmin(mean_of(&kinds[0]), mean_of(&kinds[1]));
    double global[2] = {global_of(&kinds[0], smaller), global_of(&kinds[1], smaller)};
    assert_near(d.reference.roughness, global[0], 1e-9);
    assert_near(d.decoded.roughness, global[1], 1e-9);
    assert_true(d.fmpd > 0.0);
    assert_near(d.fmpd, fmin(1.0, 8.0 * fabs(global[0] - global[1])), 1e-8);
}

/* `sides` vertices in a circle of radius 1, and an apex above its centre. */
static world_mesh pyramid(uint32_t sides, double height, int closed) {
    world_mesh mesh = {malloc(3 * sizeof(double) * (sides + 1)), malloc(3 * sizeof(uint32_t) * (sides + 1)), sides + 1,
                       sides + (closed ? 1 : 0)};
    const double apex[3] = {0.0, 0.0, height};
    memcpy(&mesh.positions[3 * sides], apex, sizeof apex);
    for (uint32_t i = 0; i < sides; i++) {
        const double corner[3] = {cos(2.0 * PI * i / sides), sin(2.0 * PI * i / sides), 0.0};
        const uint32_t side[3] = {i, (i + 1) % sides, sides}, base[3] = {0, 2, 1};
        memcpy(&mesh.positions[3 * i], corner, sizeof corner);
        memcpy(&mesh.indices[3 * i], side, sizeof side);
        memcpy(&mesh.indices[3 * sides], base, sizeof base);
    }
    return mesh;
}

/* Kind 0 is the apex, 1 the other vertices; closed by a triangle when there are three sides. */
static two_kinds pyramid_kinds(int sides, double height, int closed) {
    double edge = 2.0 * sin(PI / sides), slope = sqrt(1.0 + height * height);
    double apex = 2.0 * asin(0.5 * edge / slope), foot = 0.5 * (PI - apex);
    double side_area = 0.5 * slope * slope * sin(apex), base_area = closed ? 0.25 * sqrt(3.0) * edge * edge : 0.0;
    double at_apex = fabs(2.0 * PI - sides * apex);
    double at_foot = fabs(closed ? 2.0 * PI - 2.0 * foot - PI / 3.0 : PI - 2.0 * foot);
    double up = 1.0 / tan(foot), along = 0.5 / tan(apex) + (closed ? 0.5 / tan(PI / 3.0) : 0.0);
    double difference = fabs(at_apex - at_foot);
    return (two_kinds){{difference, difference * up / (up + 2.0 * along)},
                       {sides * side_area / 3.0, 2.0 * sides * side_area / 3.0 + base_area}};
}

static void tetrahedra_have_the_roughness_of_the_formula(void **state) {
    (void)state;
    const double heights[2] = {1.9, 2.4}; /* 1.414 would be regular */
    world_mesh mesh[2] = {pyramid(3, heights[0], 1), pyramid(3, heights[1], 1)};
    two_kinds kinds[2] = {pyramid_kinds(3, heights[0], 1), pyramid_kinds(3, heights[1], 1)};
    assert_fmpd(mesh, kinds);
    world_free(&mesh[0]);
    world_free(&mesh[1]);
}

static void open_cones_are_measured_from_pi_at_the_edge(void **state) {
    (void)state;
    const double heights[2] = {0.2, 0.25};
    world_mesh mesh[2] = {pyramid(6, heights[0], 0), pyramid(6, heights[1], 0)};
    two_kinds kinds[2] = {pyramid_kinds(6, heights[0], 0), pyramid_kinds(6, heights[1], 0)};
    assert_fmpd(mesh, kinds);
    world_free(&mesh[0]);
    world_free(&mesh[1]);
}

static void shapes_with_equal_corners_are_not_rough(void **state) {
    (void)state;
    static const double octahedron[6][3] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    static const uint32_t faces[8][3] = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                         {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    nsdf_surface cube = shape_cube(1.0), octa = shape_empty();
    for (int i = 0; i < 6; i++) {
        (void)shape_vertex(&octa, octahedron[i][0], octahedron[i][1], octahedron[i][2]);
    }
    for (int i = 0; i < 8; i++) {
        shape_triangle(&octa, faces[i][0], faces[i][1], faces[i][2]);
    }
    world_mesh a = world_copy(&cube, 1.0, 0.0, 0.0, 0.0), b = world_copy(&octa, 1.0, 0.0, 0.0, 0.0);
    nsdf_difference d = compare_meshes(&a, &b, 10, NSDF_COMPARE_FMPD);
    assert_near(d.reference.roughness, 0.0, 1e-9);
    assert_near(d.decoded.roughness, 0.0, 1e-9);
    assert_near(d.fmpd, 0.0, 1e-8);
    world_free(&a);
    world_free(&b);
    nsdf_surface_free(&cube);
    nsdf_surface_free(&octa);
}

/* A sphere whose vertices are moved at random by up to `noise` in every coordinate. */
static world_mesh noisy_sphere(uint32_t rings, double noise, uint64_t seed) {
    nsdf_surface sphere = shape_sphere(1.0, rings, 2 * rings);
    world_mesh mesh = world_copy(&sphere, 1.0, 0.0, 0.0, 0.0);
    nsdf_random random = nsdf_random_start(seed, 1);
    for (uint32_t i = 0; i < 3 * mesh.vertex_count; i++) {
        mesh.positions[i] += noise * (2.0 * (double)nsdf_random_unit(&random) - 1.0);
    }
    nsdf_surface_free(&sphere);
    return mesh;
}

static double corner_angle(const world_mesh *mesh, const uint32_t *t, int corner, double *area) {
    const double *p = &mesh->positions[3 * t[corner]], *q = &mesh->positions[3 * t[(corner + 1) % 3]],
                 *r = &mesh->positions[3 * t[(corner + 2) % 3]];
    double uu = 0.0, vv = 0.0, uv = 0.0;
    for (int k = 0; k < 3; k++) {
        uu += (q[k] - p[k]) * (q[k] - p[k]);
        vv += (r[k] - p[k]) * (r[k] - p[k]);
        uv += (q[k] - p[k]) * (r[k] - p[k]);
    }
    *area = 0.5 * sqrt(uu * vv - uv * uv);
    return acos(uv / sqrt(uu * vv));
}

/* Local roughness and shares of a closed mesh by a full matrix. */
static void slow_roughness(const world_mesh *mesh, double *local, double *share) {
    uint32_t n = mesh->vertex_count;
    double *matrix = calloc((size_t)n * n, sizeof *matrix), *curvature = malloc(n * sizeof *curvature);
    for (uint32_t i = 0; i < n; i++) {
        curvature[i] = 2.0 * PI;
        share[i] = 0.0;
    }
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *t = &mesh->indices[3 * i];
        for (int k = 0; k < 3; k++) {
            uint32_t a = t[(k + 1) % 3], b = t[(k + 2) % 3];
            double area, angle = corner_angle(mesh, t, k, &area);
            double weight = fmin(fmax(0.5 / tan(angle), 0.001), 1000.0);
            curvature[t[k]] -= angle;
            share[t[k]] += area / 3.0;
            matrix[(size_t)a * n + b] += weight;
            matrix[(size_t)b * n + a] += weight;
        }
    }
    for (uint32_t i = 0; i < n; i++) {
        double sum = 0.0, weight = 0.0;
        for (uint32_t j = 0; j < n; j++) {
            sum += matrix[(size_t)i * n + j] * fabs(curvature[j]);
            weight += matrix[(size_t)i * n + j];
        }
        local[i] = fabs(fabs(curvature[i]) - sum / weight);
    }
    free(matrix);
    free(curvature);
}

static double slow_fmpd(const world_mesh mesh[2]) {
    double *local[2], *share[2], mean[2] = {0.0, 0.0}, area[2] = {0.0, 0.0}, global[2] = {0.0, 0.0};
    for (int k = 0; k < 2; k++) {
        local[k] = malloc(mesh[k].vertex_count * sizeof(double));
        share[k] = malloc(mesh[k].vertex_count * sizeof(double));
        slow_roughness(&mesh[k], local[k], share[k]);
        for (uint32_t i = 0; i < mesh[k].vertex_count; i++) {
            mean[k] += local[k][i] * share[k][i];
            area[k] += share[k][i];
        }
        mean[k] /= area[k];
    }
    double smaller = fmax(fmin(mean[0], mean[1]), 5e-4), turn = modulated(smaller);
    for (int k = 0; k < 2; k++) {
        for (uint32_t i = 0; i < mesh[k].vertex_count; i++) {
            double value = modulated(fmin(fmax(local[k][i], 5e-4), fmax(0.2, 5.0 * smaller)));
            global[k] += share[k][i] / area[k] * (value > turn ? turn + 0.5 * (value - turn) : value);
        }
        free(local[k]);
        free(share[k]);
    }
    return fmin(1.0, 8.0 * fabs(global[0] - global[1]));
}

static void noisy_spheres_are_as_far_apart_as_matrices_say(void **state) {
    (void)state;
    for (uint64_t seed = 1; seed < 5; seed++) {
        world_mesh mesh[2] = {noisy_sphere(10, seed < 3 ? 0.002 : 0.02, seed),
                              noisy_sphere(9, 0.01 * (double)seed, seed)};
        for (uint32_t k = 0; k < 3; k++) {
            mesh[1].positions[99 + k] *= 1.0 + 0.2 * (double)seed; /* a spike, rougher than the threshold */
        }
        nsdf_difference d = compare_meshes(&mesh[0], &mesh[1], 10, NSDF_COMPARE_FMPD);
        assert_true(d.fmpd > 0.01 && d.fmpd < 1.0);
        assert_near(d.fmpd, slow_fmpd(mesh), 1e-6);
        world_free(&mesh[0]);
        world_free(&mesh[1]);
    }
}

/* The mesh in any order, turned, moved and scaled. */
static world_mesh scrambled(const world_mesh *from) {
    nsdf_random random = nsdf_random_start(5, 5);
    world_mesh mesh = {malloc(3 * sizeof(double) * from->vertex_count),
                       malloc(3 * sizeof(uint32_t) * from->triangle_count), from->vertex_count, from->triangle_count};
    uint32_t *place = malloc(sizeof *place * from->vertex_count);
    for (uint32_t i = 0; i < from->vertex_count; i++) {
        uint32_t j = nsdf_random_below(&random, i + 1);
        place[i] = place[j];
        place[j] = i;
    }
    for (uint32_t i = 0; i < from->vertex_count; i++) {
        const double *p = &from->positions[3 * place[i]], angle = 0.7;
        double *q = &mesh.positions[3 * i], x = cos(angle) * p[0] - sin(angle) * p[2];
        q[0] = 3.0 + 20.0 * x;
        q[1] = 5.0 + 20.0 * (cos(angle) * p[1] - sin(angle) * (sin(angle) * p[0] + cos(angle) * p[2]));
        q[2] = 7.0 + 20.0 * (sin(angle) * p[1] + cos(angle) * (sin(angle) * p[0] + cos(angle) * p[2]));
    }
    uint32_t *back = malloc(sizeof *back * from->vertex_count);
    for (uint32_t i = 0; i < from->vertex_count; i++) {
        back[place[i]] = i;
    }
    for (uint32_t i = 0; i < from->triangle_count; i++) {
        const uint32_t *t = &from->indices[3 * (from->triangle_count - 1 - i)];
        for (uint32_t k = 0; k < 3; k++) {
            mesh.indices[3 * i + k] = back[t[(k + i) % 3]];
        }
    }
    free(place);
    free(back);
    return mesh;
}

static void motion_scale_and_order_do_not_matter(void **state) {
    (void)state;
    world_mesh smooth = noisy_sphere(20, 0.0, 1), rough = noisy_sphere(20, 0.01, 1);
    world_mesh smooth2 = scrambled(&smooth), rough2 = scrambled(&rough);
    nsdf_difference d = compare_meshes(&smooth, &rough, 10, NSDF_COMPARE_FMPD);
    nsdf_difference d2 = compare_meshes(&smooth2, &rough2, 10, NSDF_COMPARE_FMPD);
    assert_true(d.fmpd > 0.1 && d.fmpd < 1.0);
    assert_near(d2.fmpd, d.fmpd, 1e-6);
    d2 = compare_meshes(&rough, &rough2, 10, NSDF_COMPARE_FMPD);
    assert_near(d2.fmpd, 0.0, 1e-6);
    d2 = compare_meshes(&rough, &smooth, 10, NSDF_COMPARE_FMPD);
    assert_near(d2.fmpd, d.fmpd, 1e-12);
    world_free(&smooth);
    world_free(&rough);
    world_free(&smooth2);
    world_free(&rough2);
}

static void more_noise_is_more_distance(void **state) {
    (void)state;
    static const double noise[6] = {0.0, 0.0005, 0.001, 0.002, 0.004, 0.008};
    world_mesh smooth = noisy_sphere(30, 0.0, 1);
    double last = -1.0;
    for (int i = 0; i < 6; i++) {
        world_mesh rough = noisy_sphere(30, noise[i], 1);
        double fmpd = compare_meshes(&smooth, &rough, 10, NSDF_COMPARE_FMPD).fmpd;
        assert_true(fmpd > last && fmpd <= 1.0);
        last = fmpd;
        world_free(&rough);
    }
    world_free(&smooth);
}

static void poor_triangles_do_no_harm(void **state) {
    (void)state;
    nsdf_surface clean = shape_sphere(1.0, 10, 20), poor = shape_sphere(1.0, 10, 20), fin = shape_sphere(1.0, 10, 20);
    uint32_t a = shape_vertex(&poor, 0.0, 0.0, 0.0), b = shape_vertex(&poor, 0.0, 0.0, 0.5);
    shape_triangle(&poor, a, b, a);
    shape_triangle(&poor, a, b, 0); /* in a line to the pole */
    (void)shape_vertex(&poor, 0.3, 0.3, 0.3);
    nsdf_surface soup = shape_unwelded(&poor);
    uint32_t tip = shape_vertex(&fin, 0.0, 0.0, 3.0);
    shape_triangle(&fin, fin.indices[0], fin.indices[1], tip);
    shape_triangle(&fin, fin.indices[0], fin.indices[1], tip);
    shape_triangle(&fin, fin.indices[1], fin.indices[0], tip);
    world_mesh mesh[4] = {world_copy(&clean, 1.0, 0.0, 0.0, 0.0), world_copy(&poor, 1.0, 0.0, 0.0, 0.0),
                          world_copy(&soup, 1.0, 0.0, 0.0, 0.0), world_copy(&fin, 1.0, 0.0, 0.0, 0.0)};
    for (int i = 0; i < 4; i++) {
        nsdf_difference d = compare_meshes(&mesh[0], &mesh[i], 100, NSDF_COMPARE_ALL);
        assert_true(isfinite(d.fmpd) && isfinite(d.reference.roughness) && isfinite(d.decoded.roughness));
        assert_true(isfinite(d.to_decoded.normal_rms) && isfinite(d.to_reference.normal_rms));
        if (i < 3) {
            assert_near(d.fmpd, 0.0, 1e-9);
        }
    }
    for (int i = 0; i < 4; i++) {
        world_free(&mesh[i]);
    }
    nsdf_surface_free(&clean);
    nsdf_surface_free(&poor);
    nsdf_surface_free(&soup);
    nsdf_surface_free(&fin);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tetrahedra_have_the_roughness_of_the_formula),
        cmocka_unit_test(open_cones_are_measured_from_pi_at_the_edge),
        cmocka_unit_test(shapes_with_equal_corners_are_not_rough),
        cmocka_unit_test(noisy_spheres_are_as_far_apart_as_matrices_say),
        cmocka_unit_test(motion_scale_and_order_do_not_matter),
        cmocka_unit_test(more_noise_is_more_distance),
        cmocka_unit_test(poor_triangles_do_no_harm),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
