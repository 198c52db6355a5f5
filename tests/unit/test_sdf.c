#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "geometry_shapes.h"
#include "sampler.h"
#include "sdf.h"

#define TOLERANCE 1e-6

static nsdf_sdf *create(const nsdf_surface *s, nsdf_sign_rule rule) {
    nsdf_sdf *sdf = nsdf_sdf_create(s, rule);
    assert_non_null(sdf);
    return sdf;
}

static void assert_near(double got, double wanted) {
    if (!(fabs(got - wanted) < TOLERANCE)) {
        fail_msg("got %.9g, wanted %.9g", got, wanted);
    }
}

/* Compares with the slow answers at points displaced from the surface by normal noise. */
static void check_near_surface(const nsdf_surface *s, float width, size_t count, uint64_t seed) {
    nsdf_sdf *sdf = create(s, NSDF_SIGN_PSEUDO_NORMAL);
    nsdf_random random = nsdf_random_start(seed, 1);
    float *xyz = malloc(3 * sizeof(float) * count);
    assert_int_equal(nsdf_sample_surface(s, count, &random, xyz), 0);
    for (size_t i = 0; i < count; i++) {
        for (size_t k = 0; k < 3; k++) {
            xyz[3 * i + k] += width * nsdf_random_normal(&random);
        }
        assert_near((double)nsdf_sdf_distance(sdf, &xyz[3 * i]), exact_signed(s, &xyz[3 * i]));
    }
    free(xyz);
    nsdf_sdf_free(sdf);
}

static void check_in_box(const nsdf_surface *s, float half, size_t count) {
    nsdf_sdf *sdf = create(s, NSDF_SIGN_PSEUDO_NORMAL);
    nsdf_random random = nsdf_random_start(5, 2);
    for (size_t i = 0; i < count; i++) {
        float p[3];
        random_point(&random, half, p);
        assert_near((double)nsdf_sdf_distance(sdf, p), exact_signed(s, p));
    }
    nsdf_sdf_free(sdf);
}

static double cube_distance(const float p[3], double h) {
    double outside2 = 0.0, inside = -INFINITY;
    for (int k = 0; k < 3; k++) {
        double side = fabs((double)p[k]) - h;
        outside2 += side > 0.0 ? side * side : 0.0;
        inside = fmax(inside, side);
    }
    return inside > 0.0 ? sqrt(outside2) : inside;
}

static void cube_has_the_analytic_distance(void **state) {
    (void)state;
    nsdf_surface s = shape_cube(0.25);
    nsdf_sdf *sdf = create(&s, NSDF_SIGN_PSEUDO_NORMAL);
    nsdf_random random = nsdf_random_start(1, 1);
    for (int i = 0; i < 20000; i++) {
        float p[3];
        random_point(&random, i % 2 ? 0.5f : 0.27f, p);
        assert_near((double)nsdf_sdf_distance(sdf, p), cube_distance(p, 0.25));
    }
    nsdf_sdf_free(sdf);
    nsdf_surface_free(&s);
}

static void points_that_tie_between_features_have_the_right_sign(void **state) {
    (void)state;
    nsdf_surface s = shape_cube(0.25);
    nsdf_sdf *sdf = create(&s, NSDF_SIGN_PSEUDO_NORMAL);
    for (int i = 0; i < 17 * 17 * 17; i++) {
        const float p[3] = {(float)(i % 17 - 8) / 16.0f, (float)(i / 17 % 17 - 8) / 16.0f,
                            (float)(i / 289 - 8) / 16.0f};
        assert_near((double)nsdf_sdf_distance(sdf, p), cube_distance(p, 0.25));
    }
    nsdf_sdf_free(sdf);
    nsdf_surface_free(&s);
}

static void sphere_with_many_triangles_at_its_poles_matches_brute_force(void **state) {
    (void)state;
    nsdf_surface s = shape_sphere(0.3, 12, 90);
    check_in_box(&s, 0.5f, 600);
    check_near_surface(&s, 0.001f, 600, 3);
    nsdf_sdf *sdf = create(&s, NSDF_SIGN_PSEUDO_NORMAL);
    assert_near((double)nsdf_sdf_distance(sdf, (const float[3]){0.0f, 0.0f, 0.4f}), 0.4 - (double)0.3f);
    nsdf_sdf_free(sdf);
    nsdf_surface_free(&s);
}

static void torus_matches_brute_force(void **state) {
    (void)state;
    nsdf_surface s = shape_torus(0.3, 0.1, 40, 20);
    check_in_box(&s, 0.5f, 500);
    check_near_surface(&s, 0.01f, 500, 4);
    check_near_surface(&s, 1e-5f, 500, 5);
    nsdf_surface_free(&s);
}

static void cavity_between_nested_spheres_is_outside(void **state) {
    (void)state;
    nsdf_surface s = shape_empty();
    shape_add_sphere(&s, 0.4, 16, 24, 0, 0);
    shape_add_sphere(&s, 0.2, 16, 24, 1, 0);
    nsdf_sdf *sdf = create(&s, NSDF_SIGN_PSEUDO_NORMAL);
    assert_true(nsdf_sdf_distance(sdf, (const float[3]){0.0f, 0.0f, 0.0f}) > 0.19f);
    assert_true(nsdf_sdf_distance(sdf, (const float[3]){0.3f, 0.0f, 0.0f}) < -0.09f);
    nsdf_sdf_free(sdf);
    check_in_box(&s, 0.5f, 500);
    nsdf_surface_free(&s);
}

/* The sign of the offset against the normal of the first triangle that is nearest: wrong on sharp edges. */
static double naive_sign(const nsdf_surface *s, const float point[3]) {
    nsdf_vec3 p = nsdf_vec3_load(point);
    double least = INFINITY, side = 0.0;
    for (uint32_t i = 0; i < s->triangle_count; i++) {
        nsdf_vec3 a = shape_corner(s, i, 0), b = shape_corner(s, i, 1), c = shape_corner(s, i, 2);
        double d = exact_triangle2(p, a, b, c);
        if (d < least) {
            least = d;
            side = nsdf_vec3_dot(nsdf_vec3_cross(nsdf_vec3_sub(b, a), nsdf_vec3_sub(c, a)), nsdf_vec3_sub(p, a));
        }
    }
    return side < 0.0 ? -1.0 : 1.0;
}

static void check_sharp(const nsdf_surface *s, float half) {
    nsdf_sdf *sdf = create(s, NSDF_SIGN_PSEUDO_NORMAL);
    nsdf_random random = nsdf_random_start(9, 9);
    int naive_failures = 0;
    for (int i = 0; i < 20000; i++) {
        float p[3];
        random_point(&random, half, p);
        double wanted = exact_signed(s, p);
        assert_near((double)nsdf_sdf_distance(sdf, p), wanted);
        naive_failures += naive_sign(s, p) * wanted < 0.0;
    }
    assert_true(naive_failures > 100);
    nsdf_sdf_free(sdf);
}

static void spikes_and_wedges_have_right_signs_where_face_normals_fail(void **state) {
    (void)state;
    const double spike[4][3] = {{0.01, 0, -0.3}, {-0.005, 0.009, -0.3}, {-0.005, -0.009, -0.3}, {0, 0, 0.3}};
    const double wedge[4][3] = {{-0.3, 0, 0}, {0.3, 0, 0}, {0, 0.3, 0.01}, {0, 0.3, -0.01}};
    const double flat[4][3] = {{0.3, 0, 0}, {-0.2, 0.25, 0}, {-0.2, -0.25, 0}, {0, 0, 0.004}};
    const double(*shapes[3])[3] = {spike, wedge, flat};
    for (int i = 0; i < 3; i++) {
        nsdf_surface s = shape_tetrahedron(shapes[i]);
        float p[3] = {0.0f, 0.0f, 0.0f};
        if (exact_winding(&s, p) < -0.5 || exact_winding(&s, (const float[3]){0.0f, 0.1f, 0.001f}) < -0.5) {
            for (uint32_t t = 0; t < s.triangle_count; t++) {
                uint32_t swapped = s.indices[3 * t];
                s.indices[3 * t] = s.indices[3 * t + 1];
                s.indices[3 * t + 1] = swapped;
            }
        }
        check_sharp(&s, 0.4f);
        nsdf_surface_free(&s);
    }
}

static void duplicated_vertices_change_nothing(void **state) {
    (void)state;
    nsdf_surface welded = shape_sphere(0.3, 10, 14), soup = shape_unwelded(&welded);
    nsdf_sdf *a = create(&welded, NSDF_SIGN_PSEUDO_NORMAL), *b = create(&soup, NSDF_SIGN_PSEUDO_NORMAL);
    nsdf_random random = nsdf_random_start(2, 2);
    for (int i = 0; i < 5000; i++) {
        float p[3];
        random_point(&random, 0.5f, p);
        assert_true(nsdf_sdf_distance(a, p) == nsdf_sdf_distance(b, p));
    }
    nsdf_sdf_free(a);
    nsdf_sdf_free(b);
    nsdf_surface_free(&welded);
    nsdf_surface_free(&soup);
}

/* A thin wedge whose sharp edge, 0 to 1, is cut at its middle on one side only; a triangle without area fills the
 * T-junction. */
static nsdf_surface wedge_with_t_junction(void) {
    nsdf_surface s = shape_empty();
    (void)shape_vertex(&s, -0.25, 0, 0);
    (void)shape_vertex(&s, 0.25, 0, 0);
    (void)shape_vertex(&s, 0, 0.25, 0.0078125);
    (void)shape_vertex(&s, 0, 0.25, -0.0078125);
    (void)shape_vertex(&s, 0.0625, 0, 0);
    shape_triangle(&s, 0, 4, 2);
    shape_triangle(&s, 4, 1, 2);
    shape_triangle(&s, 0, 1, 4);
    shape_triangle(&s, 1, 0, 3);
    shape_triangle(&s, 0, 2, 3);
    shape_triangle(&s, 2, 1, 3);
    return s;
}

static void triangles_without_area_do_not_disturb_signs(void **state) {
    (void)state;
    nsdf_surface s = wedge_with_t_junction();
    check_in_box(&s, 0.4f, 20000);
    shape_triangle(&s, 2, 2, 3);
    shape_triangle(&s, 1, 1, 1);
    check_in_box(&s, 0.4f, 5000);
    nsdf_surface_free(&s);
}

static void repeated_triangles_do_not_disturb_signs(void **state) {
    (void)state;
    nsdf_surface once = wedge_with_t_junction(), often = wedge_with_t_junction();
    for (int i = 0; i < 50; i++) {
        shape_triangle(&often, i % 2 ? 1 : 0, i % 2 ? 0 : 3, i % 2 ? 3 : 1);
    }
    nsdf_sdf *a = create(&once, NSDF_SIGN_PSEUDO_NORMAL), *b = create(&often, NSDF_SIGN_PSEUDO_NORMAL);
    nsdf_random random = nsdf_random_start(3, 2);
    for (int i = 0; i < 5000; i++) {
        float p[3];
        random_point(&random, 0.4f, p);
        assert_true(nsdf_sdf_distance(a, p) == nsdf_sdf_distance(b, p));
    }
    nsdf_sdf_free(a);
    nsdf_sdf_free(b);
    nsdf_surface_free(&once);
    nsdf_surface_free(&often);
}

static void needles_match_brute_force(void **state) {
    (void)state;
    nsdf_surface s = shape_empty();
    uint32_t top = shape_vertex(&s, 0, 0, 0.4), bottom = shape_vertex(&s, 0, 0, -0.4);
    for (uint32_t j = 0; j < 2000; j++) {
        double phi = 6.283185307179586 * j / 2000;
        (void)shape_vertex(&s, 0.02 * cos(phi), 0.02 * sin(phi), 0);
        shape_triangle(&s, top, 2 + j, 2 + (j + 1) % 2000);
        shape_triangle(&s, bottom, 2 + (j + 1) % 2000, 2 + j);
    }
    check_near_surface(&s, 0.003f, 300, 6);
    check_in_box(&s, 0.5f, 200);
    nsdf_surface_free(&s);
}

static void distance_is_zero_on_the_surface(void **state) {
    (void)state;
    nsdf_surface s = shape_torus(0.3, 0.1, 30, 16);
    nsdf_sdf *sdf = create(&s, NSDF_SIGN_PSEUDO_NORMAL);
    nsdf_random random = nsdf_random_start(8, 8);
    float xyz[3 * 500];
    for (uint32_t i = 0; i < s.vertex_count; i++) {
        assert_true(nsdf_sdf_distance(sdf, &s.positions[3 * i]) == 0.0f);
    }
    assert_int_equal(nsdf_sample_surface(&s, 500, &random, xyz), 0);
    for (size_t i = 0; i < 500; i++) {
        assert_true(fabsf(nsdf_sdf_distance(sdf, &xyz[3 * i])) < 1e-7f);
    }
    nsdf_sdf_free(sdf);
    nsdf_surface_free(&s);
}

static void distance_is_lipschitz(void **state) {
    (void)state;
    nsdf_surface shapes[2] = {shape_torus(0.3, 0.1, 40, 20), wedge_with_t_junction()};
    for (int which = 0; which < 2; which++) {
        nsdf_sdf *sdf = create(&shapes[which], NSDF_SIGN_PSEUDO_NORMAL);
        nsdf_random random = nsdf_random_start(11, 1);
        for (int i = 0; i < 20000; i++) {
            float p[3], q[3];
            random_point(&random, 0.5f, p);
            random_point(&random, i % 2 ? 0.5f : 0.001f, q);
            double apart2 = 0.0;
            for (int k = 0; k < 3; k++) {
                q[k] = i % 2 ? q[k] : p[k] + q[k];
                apart2 += pow((double)p[k] - (double)q[k], 2);
            }
            double change = (double)nsdf_sdf_distance(sdf, p) - (double)nsdf_sdf_distance(sdf, q);
            assert_true(fabs(change) <= sqrt(apart2) + 1e-7);
        }
        nsdf_sdf_free(sdf);
        nsdf_surface_free(&shapes[which]);
    }
}

static void winding_number_is_close_to_the_exact_one(void **state) {
    (void)state;
    nsdf_surface s = shape_torus(0.3, 0.1, 60, 30);
    nsdf_sdf *sdf = create(&s, NSDF_SIGN_WINDING);
    nsdf_random random = nsdf_random_start(12, 1);
    for (int i = 0; i < 1000; i++) {
        float p[3];
        random_point(&random, 0.5f, p);
        assert_true(fabs((double)nsdf_sdf_winding(sdf, p) - exact_winding(&s, p)) < 0.1);
    }
    nsdf_sdf_free(sdf);
    nsdf_surface_free(&s);
}

static void sign_by_winding_is_right_away_from_a_hole(void **state) {
    (void)state;
    nsdf_surface s = shape_empty();
    shape_add_sphere(&s, 0.3, 24, 32, 0, 4); /* open above z = 0.26, a hole of radius 0.15 */
    nsdf_sdf *sdf = create(&s, NSDF_SIGN_WINDING);
    nsdf_random random = nsdf_random_start(13, 1);
    int inside = 0;
    for (int i = 0; i < 5000; i++) {
        float p[3];
        random_point(&random, 0.5f, p);
        double r = sqrt((double)(p[0] * p[0] + p[1] * p[1] + p[2] * p[2])), d = exact_distance(&s, p);
        bool near_hole = hypot(hypot((double)p[0], (double)p[1]), (double)p[2] - 0.26) < 0.2;
        if (!near_hole && fabs(r - 0.3) > 0.005) {
            assert_near((double)nsdf_sdf_distance(sdf, p), r < 0.3 ? -d : d);
            inside += r < 0.3;
        }
    }
    assert_true(inside > 200);
    nsdf_sdf_free(sdf);
    nsdf_surface_free(&s);
}

static void unsigned_search_respects_its_limit_and_gives_the_nearest_point(void **state) {
    (void)state;
    nsdf_surface s = shape_cube(0.25);
    nsdf_sdf *sdf = create(&s, NSDF_SIGN_PSEUDO_NORMAL);
    const float p[3] = {0.1f, 0.05f, 0.45f};
    float nearest[3] = {9.0f, 9.0f, 9.0f};
    assert_true(nsdf_sdf_unsigned(sdf, p, 0.1f, nearest) == 0.1f);
    assert_true(nearest[0] == 9.0f);
    assert_near((double)nsdf_sdf_unsigned(sdf, p, INFINITY, nearest), 0.2);
    assert_near((double)nearest[0], 0.1);
    assert_near((double)nearest[1], 0.05);
    assert_near((double)nearest[2], 0.25);
    assert_near((double)nsdf_sdf_unsigned(sdf, p, 0.21f, NULL), 0.2);
    nsdf_sdf_free(sdf);
    nsdf_surface_free(&s);
}

/* Limits right at the distance, a little to either side, and anywhere. */
static void being_within_a_limit_is_being_nearer_than_it(void **state) {
    (void)state;
    nsdf_surface s = shape_sphere(0.3, 20, 30);
    nsdf_sdf *sdf = create(&s, NSDF_SIGN_PSEUDO_NORMAL), *plain = nsdf_sdf_create_unsigned(&s);
    nsdf_random random = nsdf_random_start(15, 1);
    assert_non_null(plain);
    for (int i = 0; i < 3000; i++) {
        float p[3];
        random_point(&random, 0.5f, p);
        const float d = fabsf(nsdf_sdf_distance(sdf, p));
        const float limits[] = {0.0f, d, nextafterf(d, 1.0f), nextafterf(d, 0.0f), 1.001f * d, 0.999f * d, 0.2f, 9.0f};
        for (size_t k = 0; k < sizeof limits / sizeof *limits; k++)
            assert_true(nsdf_sdf_is_within(sdf, p, limits[k]) == (d < limits[k]));
        assert_true(nsdf_sdf_is_within(sdf, p, INFINITY));
        assert_true(nsdf_sdf_unsigned(plain, p, INFINITY, NULL) == d);
    }
    nsdf_sdf_free(sdf);
    nsdf_sdf_free(plain);
    nsdf_surface_free(&s);
}

static void guesses_never_change_the_distance(void **state) {
    (void)state;
    nsdf_surface s = shape_sphere(0.3, 20, 30);
    nsdf_sdf *sdf = create(&s, NSDF_SIGN_PSEUDO_NORMAL);
    nsdf_random random = nsdf_random_start(14, 1);
    for (int i = 0; i < 3000; i++) {
        static const float factors[4] = {0.0f, 0.5f, 1.0f, 1.5f};
        float p[3];
        random_point(&random, 0.5f, p);
        float d = nsdf_sdf_distance(sdf, p);
        assert_true(nsdf_sdf_distance_below(sdf, p, factors[i % 4] * fabsf(d)) == d);
    }
    nsdf_sdf_free(sdf);
    nsdf_surface_free(&s);
}

static void far_points_are_outside_and_ever_farther(void **state) {
    (void)state;
    nsdf_surface s = shape_torus(0.3, 0.1, 30, 20);
    for (int rule = 0; rule < 2; rule++) {
        nsdf_sdf *sdf = create(&s, (nsdf_sign_rule)rule);
        float before = 0.0f;
        for (float r = 1.0f; r < 1e6f; r *= 2.0f) {
            float d = nsdf_sdf_distance(sdf, (const float[3]){r, -0.3f * r, 0.7f * r});
            assert_true(d > before);
            before = d;
        }
        nsdf_sdf_free(sdf);
    }
    nsdf_surface_free(&s);
}

static void surface_of_one_point_has_a_distance(void **state) {
    (void)state;
    nsdf_surface s = shape_empty();
    (void)shape_vertex(&s, 0.1, 0.2, 0.3);
    assert_null(nsdf_sdf_create(&s, NSDF_SIGN_PSEUDO_NORMAL));
    for (int i = 0; i < 100; i++) {
        shape_triangle(&s, 0, 0, 0);
    }
    nsdf_sdf *sdf = create(&s, NSDF_SIGN_PSEUDO_NORMAL);
    assert_near((double)nsdf_sdf_distance(sdf, (const float[3]){0.1f, 0.2f, 0.8f}), 0.5);
    nsdf_sdf_free(sdf);
    nsdf_surface_free(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cube_has_the_analytic_distance),
        cmocka_unit_test(points_that_tie_between_features_have_the_right_sign),
        cmocka_unit_test(sphere_with_many_triangles_at_its_poles_matches_brute_force),
        cmocka_unit_test(torus_matches_brute_force),
        cmocka_unit_test(cavity_between_nested_spheres_is_outside),
        cmocka_unit_test(spikes_and_wedges_have_right_signs_where_face_normals_fail),
        cmocka_unit_test(duplicated_vertices_change_nothing),
        cmocka_unit_test(triangles_without_area_do_not_disturb_signs),
        cmocka_unit_test(repeated_triangles_do_not_disturb_signs),
        cmocka_unit_test(needles_match_brute_force),
        cmocka_unit_test(distance_is_zero_on_the_surface),
        cmocka_unit_test(distance_is_lipschitz),
        cmocka_unit_test(winding_number_is_close_to_the_exact_one),
        cmocka_unit_test(sign_by_winding_is_right_away_from_a_hole),
        cmocka_unit_test(unsigned_search_respects_its_limit_and_gives_the_nearest_point),
        cmocka_unit_test(being_within_a_limit_is_being_nearer_than_it),
        cmocka_unit_test(guesses_never_change_the_distance),
        cmocka_unit_test(far_points_are_outside_and_ever_farther),
        cmocka_unit_test(surface_of_one_point_has_a_distance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
