#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "compare_shapes.h"
#include "geometry_shapes.h"
#include "quality/compared_mesh.h"

static void a_mesh_is_no_distance_from_itself(void **state) {
    (void)state;
    nsdf_surface torus = shape_torus(0.7, 0.3, 40, 17), cube = shape_cube(1.0);
    const nsdf_surface *shapes[2] = {&torus, &cube};
    for (int i = 0; i < 2; i++) {
        world_mesh mesh = world_copy(shapes[i], 3.7, 100.0, -20.0, 7.0);
        nsdf_difference d = compare_meshes(&mesh, &mesh, 3000, NSDF_COMPARE_ALL);
        const nsdf_distances none = {0};
        assert_same_distances(&d.to_decoded, &none);
        assert_same_distances(&d.to_reference, &none);
        assert_true(d.hausdorff == 0.0);
        assert_true(d.fmpd == 0.0);
        assert_true((d.reference.roughness > 0.0) == (i == 0)); /* the corners of a cube are all alike */
        assert_same_shape(&d.reference, &d.decoded);
        world_free(&mesh);
    }
    nsdf_surface_free(&torus);
    nsdf_surface_free(&cube);
}

/* The facets of a sphere of this fineness are at most 4e-4 of the radius inside of it. */
static void concentric_spheres_are_the_difference_of_radii_apart(void **state) {
    (void)state;
    nsdf_surface sphere = shape_sphere(1.0, 90, 110);
    world_mesh small = world_copy(&sphere, 2.0, 5.0, 5.0, 5.0), large = world_copy(&sphere, 2.2, 5.0, 5.0, 5.0);
    nsdf_difference d = compare_meshes(&small, &large, 5000, 0);
    assert_near(d.to_decoded.mean, 0.2, 1e-3);
    assert_near(d.to_decoded.rms, 0.2, 1e-3);
    assert_near(d.to_decoded.max, 0.2, 1e-3);
    assert_near(d.to_reference.mean, 0.2, 1e-3);
    assert_near(d.to_reference.rms, 0.2, 1e-3);
    assert_near(d.to_reference.max, 0.2, 1e-3);
    assert_near(d.hausdorff, 0.2, 1e-3);
    world_free(&small);
    world_free(&large);
    nsdf_surface_free(&sphere);
}

/* Of a sphere of radius r and the same moved by s < r along z: the distance at polar cosine c is
 * |sqrt(r^2 + s^2 - 2 r s c) - r|; c is uniform over the sphere. */
static void a_moved_sphere_has_the_analytic_distances(void **state) {
    (void)state;
    const double r = 2.0, s = 0.5;
    nsdf_surface sphere = shape_sphere(1.0, 90, 110);
    world_mesh here = world_copy(&sphere, r, 0.0, 0.0, 0.0), there = world_copy(&sphere, r, 0.0, 0.0, s);
    double mean = 0.0, square = 0.0;
    for (int i = 0; i < 100000; i++) {
        double c = (i + 0.5) / 50000.0 - 1.0, distance = fabs(sqrt(r * r + s * s - 2.0 * r * s * c) - r);
        mean += distance / 100000.0;
        square += distance * distance / 100000.0;
    }
    nsdf_difference d = compare_meshes(&here, &there, 20000, 0);
    const nsdf_distances *ways[2] = {&d.to_decoded, &d.to_reference};
    for (int k = 0; k < 2; k++) {
        assert_near(ways[k]->mean, mean, 0.005 * mean);
        assert_near(ways[k]->rms, sqrt(square), 0.005 * sqrt(square));
        assert_near(ways[k]->max, s, 1e-3);
    }
    assert_near(d.hausdorff, s, 1e-3);
    world_free(&here);
    world_free(&there);
    nsdf_surface_free(&sphere);
}

static void parallel_squares_have_one_distance_and_no_angle(void **state) {
    (void)state;
    world_mesh low = world_square(0.0, 1.0, 7), high = world_square(0.0, 1.0, 3);
    world_tilt(&high, 0.0, 0.125);
    nsdf_difference d = compare_meshes(&low, &high, 2000, NSDF_COMPARE_NORMALS | NSDF_COMPARE_POINTS);
    const nsdf_distances *ways[2] = {&d.to_decoded, &d.to_reference};
    for (int k = 0; k < 2; k++) {
        assert_near(ways[k]->mean, 0.125, 1e-6);
        assert_near(ways[k]->rms, 0.125, 1e-6);
        assert_near(ways[k]->max, 0.125, 1e-6);
        assert_near(ways[k]->normal_mean, 0.0, 1e-4);
        assert_near(ways[k]->normal_rms, 0.0, 1e-4);
        assert_true(ways[k]->point_rms > 0.125 && ways[k]->point_rms < 0.13);
    }
    world_flip(&high);
    d = compare_meshes(&low, &high, 100, NSDF_COMPARE_NORMALS);
    assert_near(d.to_decoded.normal_mean, 180.0, 1e-4);
    assert_true(d.to_decoded.point_rms == 0.0);
    world_free(&low);
    world_free(&high);
}

/* From a unit square to a large one that is tilted around its edge: x sin(angle). */
static void a_tilted_square_is_off_by_its_angle(void **state) {
    (void)state;
    const double angle = 0.3;
    world_mesh flat = world_square(0.0, 1.0, 5), tilted = world_square(-3.0, 3.0, 6);
    world_tilt(&tilted, angle, 0.0);
    nsdf_difference d = compare_meshes(&flat, &tilted, 20000, NSDF_COMPARE_NORMALS);
    assert_near(d.to_decoded.mean, sin(angle) / 2.0, 1e-3);
    assert_near(d.to_decoded.rms, sin(angle) / sqrt(3.0), 1e-3);
    assert_near(d.to_decoded.max, sin(angle), 1e-6);
    assert_near(d.to_decoded.normal_mean, angle * 180.0 / 3.141592653589793, 1e-3);
    assert_near(d.to_decoded.normal_rms, angle * 180.0 / 3.141592653589793, 1e-3);
    assert_near(d.hausdorff, sqrt(pow(3.0 * cos(angle), 2) + pow(3.0 * sin(angle), 2) + 9.0), 1e-3);
    world_free(&flat);
    world_free(&tilted);
}

/* Mean square distance from the points of one mesh to the nearest of the other's, tried one by one. */
static double slow_point_square(const nsdf_compared_mesh *from, const nsdf_compared_mesh *to) {
    double sum = 0.0;
    for (uint32_t i = 0; i < from->samples; i++) {
        double least = INFINITY;
        for (uint32_t j = 0; j < to->samples; j++) {
            nsdf_vec3 offset = nsdf_vec3_sub(nsdf_vec3_load(&from->points[3 * i]), nsdf_vec3_load(&to->points[3 * j]));
            least = fmin(least, nsdf_vec3_dot(offset, offset));
        }
        sum += least;
    }
    return sum / from->samples;
}

static void d1_is_the_distance_to_the_nearest_point(void **state) {
    (void)state;
    enum { POINTS = 2500 }; /* more than two chunks */
    nsdf_surface torus = shape_torus(0.7, 0.3, 30, 20), sphere = shape_sphere(0.8, 12, 20);
    world_mesh a = world_copy(&torus, 10.0, 1.0, 2.0, 3.0), b = world_copy(&sphere, 10.0, 1.0, 2.0, 3.0);
    nsdf_input_mesh views[2] = {world_view(&a), world_view(&b)};
    nsdf_pair_frame frame = nsdf_pair_frame_of(&views[0], &views[1]);
    nsdf_compared_mesh compared[2];
    for (int k = 0; k < 2; k++) {
        assert_int_equal(nsdf_compared_mesh_prepare(&compared[k], &views[k], &frame, POINTS, false), 0);
        for (uint32_t chunk = 0; chunk < nsdf_chunk_count(POINTS); chunk++) {
            nsdf_compared_mesh_draw(&compared[k], chunk, 1);
        }
    }
    nsdf_difference d = compare_meshes(&a, &b, POINTS, NSDF_COMPARE_POINTS);
    double there = frame.diagonal * sqrt(slow_point_square(&compared[0], &compared[1]));
    double back = frame.diagonal * sqrt(slow_point_square(&compared[1], &compared[0]));
    assert_near(d.to_decoded.point_rms, there, 1e-6 * there);
    assert_near(d.to_reference.point_rms, back, 1e-6 * back);
    for (int k = 0; k < 2; k++) {
        nsdf_compared_mesh_free(&compared[k]);
    }
    world_free(&a);
    world_free(&b);
    nsdf_surface_free(&torus);
    nsdf_surface_free(&sphere);
}

static void points_are_spread_by_area(void **state) {
    (void)state;
    enum { POINTS = 10000 };
    nsdf_surface sphere = shape_sphere(1.0, 12, 20);
    nsdf_area_table table;
    nsdf_random random = nsdf_random_start(7, 7);
    uint32_t *count = calloc(sphere.triangle_count, sizeof *count), last = 0;
    double area = nsdf_surface_area(&sphere), centre[3] = {0.0, 0.0, 0.0};
    assert_int_equal(nsdf_area_table_create(&table, &sphere), 0);
    for (uint32_t i = 0; i < POINTS; i++) {
        float xyz[3];
        uint32_t triangle = nsdf_area_table_draw_share(&table, i, POINTS, &random, xyz);
        assert_true(triangle >= last);
        last = triangle;
        count[triangle]++;
        for (int k = 0; k < 3; k++) {
            centre[k] += (double)xyz[k] / POINTS;
        }
    }
    for (uint32_t i = 0; i < sphere.triangle_count; i++) {
        double own = table.sums[i] - (i > 0 ? table.sums[i - 1] : 0.0);
        assert_near(count[i], POINTS * own / area, 2.0);
    }
    for (int k = 0; k < 3; k++) {
        assert_near(centre[k], 0.0, 2e-3);
    }
    free(count);
    nsdf_area_table_free(&table);
    nsdf_surface_free(&sphere);
}

static void threads_change_nothing(void **state) {
    (void)state;
    nsdf_surface torus = shape_torus(0.7, 0.3, 60, 30), sphere = shape_sphere(0.8, 30, 50);
    world_mesh a = world_copy(&torus, 1.0, 0.0, 0.0, 0.0), b = world_copy(&sphere, 1.0, 0.0, 0.0, 0.1);
    nsdf_compare_options options;
    nsdf_compare_options_init(&options);
    options.samples = 7000;
    options.threads = 1;
    nsdf_difference one = compare_with(&a, &b, &options, NULL);
    for (options.threads = 2; options.threads < 6; options.threads++) {
        nsdf_difference more = compare_with(&a, &b, &options, NULL);
        assert_same_distances(&one.to_decoded, &more.to_decoded);
        assert_same_distances(&one.to_reference, &more.to_reference);
        assert_same_shape(&one.reference, &more.reference);
        assert_same_shape(&one.decoded, &more.decoded);
        assert_true(one.hausdorff == more.hausdorff && one.fmpd == more.fmpd);
    }
    options.seed = 2;
    nsdf_difference other = compare_with(&a, &b, &options, NULL);
    assert_true(other.to_decoded.mean != one.to_decoded.mean);
    assert_near(other.to_decoded.mean, one.to_decoded.mean, 0.01 * one.to_decoded.mean);
    world_free(&a);
    world_free(&b);
    nsdf_surface_free(&torus);
    nsdf_surface_free(&sphere);
}

/* Two squares of `size`, one a quarter of it above the other, whose upper has four more vertices that no triangle uses:
 * they get a distance, however far they are, and count for nothing else. */
static void check_vertex_distances(double size, const double extra[4][3], const double expected[4]) {
    world_mesh low = world_square(0.0, size, 40), high = world_square(0.0, size, 40);
    world_tilt(&high, 0.0, 0.25 * size);
    uint32_t used = high.vertex_count;
    high.positions = realloc(high.positions, 3 * sizeof(double) * (used + 4));
    memcpy(&high.positions[3 * used], extra, 12 * sizeof(double));
    high.vertex_count += 4;
    double *distance = malloc(sizeof *distance * high.vertex_count);
    nsdf_difference d = compare_with(&low, &high, NULL, distance);
    for (uint32_t i = 0; i < used; i++) {
        assert_near(distance[i], 0.25 * size, 1e-6 * size);
    }
    for (uint32_t i = 0; i < 4; i++) {
        assert_near(distance[used + i], expected[i], 1e-5 * expected[i]);
    }
    assert_near(d.hausdorff, 0.25 * size, 1e-6 * size);
    assert_int_equal(d.decoded.vertices, used + 4);
    free(distance);
    world_free(&low);
    world_free(&high);
}

static void every_decoded_vertex_gets_its_distance(void **state) {
    (void)state;
    static const double near_by[4][3] = {{0.5, 0.5, 3.0}, {0.0, 5.0, 0.0}, {0.0, 0.0, -9.0}, {1.0, 1.0, -2.0}};
    static const double far_off[4][3] = {{0.5, 0.5, 3.0}, {0.0, -1e20, 0.0}, {0.0, 0.0, 1e30}, {0.0, 3e29, 4e29}};
    check_vertex_distances(1.0, near_by, (const double[4]){3.0, 4.0, 9.0, 2.0});
    check_vertex_distances(1e-10, far_off, (const double[4]){sqrt(9.5), 1e20, 1e30, 5e29});
}

static void refuse(nsdf_compare *compare, const world_mesh *reference, const world_mesh *decoded, const char *message) {
    nsdf_input_mesh a = world_view(reference), b = world_view(decoded);
    nsdf_encoder_error error = {NSDF_OK, ""};
    nsdf_difference difference = {.fmpd = 42.0};
    double distance[16] = {42.0};
    assert_int_equal(nsdf_compare_frame(compare, &a, &b, distance, &difference, &error), NSDF_INVALID_ARGUMENT);
    assert_int_equal(error.status, NSDF_INVALID_ARGUMENT);
    assert_string_equal(error.message, message);
    assert_true(difference.fmpd == 42.0 && distance[0] == 42.0);
    assert_int_equal(nsdf_compare_frame(compare, &a, &b, NULL, &difference, NULL), NSDF_INVALID_ARGUMENT);
}

static void bad_meshes_are_refused(void **state) {
    (void)state;
    nsdf_compare *compare = NULL;
    world_mesh good = world_square(0.0, 1.0, 2), bad = world_square(0.0, 1.0, 2);
    assert_int_equal(nsdf_compare_create(&compare, NULL, NULL), NSDF_OK);
    bad.positions[4] = NAN;
    refuse(compare, &bad, &good, "reference: vertex 1 is not finite");
    bad.positions[4] = 2e30;
    refuse(compare, &good, &bad, "decoded: vertex 1 is further away than 1e+30");
    bad.positions[4] = 0.0;
    bad.indices[5] = 9;
    refuse(compare, &good, &bad, "decoded: triangle 1 uses vertex 9, but there are 9");
    bad.indices[5] = 0;
    bad.triangle_count = 0;
    refuse(compare, &bad, &good, "reference: no faces");
    bad.triangle_count = 2;
    for (int i = 0; i < 6; i++) {
        bad.indices[i] = (uint32_t)i % 3; /* in a line */
    }
    refuse(compare, &good, &bad, "decoded: no triangle has an area");
    refuse(compare, &bad, &good, "reference: no triangle has an area");
    for (int i = 0; i < 6; i++) {
        bad.indices[i] = 4;
    }
    refuse(compare, &bad, &bad, "reference: no triangle has an area");
    nsdf_compare_close(&compare);
    nsdf_compare_close(&compare);
    nsdf_compare_close(NULL);
    world_free(&good);
    world_free(&bad);
}

static void bad_options_are_refused(void **state) {
    (void)state;
    nsdf_compare_options options[5];
    const char *messages[5] = {NULL, "samples is 0, expected 1 to 16777216",
                               "samples is 16777217, expected 1 to 16777216", "threads is 257, expected 0 to 256",
                               "measures is 16, expected 0 to 15"};
    for (int i = 0; i < 5; i++) {
        nsdf_compare_options_init(&options[i]);
    }
    options[0].struct_size--;
    options[1].samples = 0;
    options[2].samples = (1u << 24) + 1;
    options[3].threads = 257;
    options[4].measures = 16;
    for (int i = 0; i < 5; i++) {
        nsdf_encoder_error error = {NSDF_OK, ""};
        nsdf_compare *compare = NULL;
        assert_int_equal(nsdf_compare_create(&compare, &options[i], &error), NSDF_INVALID_ARGUMENT);
        assert_null(compare);
        if (messages[i] != NULL) {
            assert_string_equal(error.message, messages[i]);
        } else {
            assert_non_null(strstr(error.message, "nsdf_compare_options_init"));
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_mesh_is_no_distance_from_itself),
        cmocka_unit_test(concentric_spheres_are_the_difference_of_radii_apart),
        cmocka_unit_test(a_moved_sphere_has_the_analytic_distances),
        cmocka_unit_test(parallel_squares_have_one_distance_and_no_angle),
        cmocka_unit_test(a_tilted_square_is_off_by_its_angle),
        cmocka_unit_test(d1_is_the_distance_to_the_nearest_point),
        cmocka_unit_test(points_are_spread_by_area),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(every_decoded_vertex_gets_its_distance),
        cmocka_unit_test(bad_meshes_are_refused),
        cmocka_unit_test(bad_options_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
