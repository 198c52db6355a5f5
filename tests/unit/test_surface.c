#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "geometry_shapes.h"
#include "surface.h"
#include "surface_error.h"

static void assert_edges(const nsdf_surface *s, uint32_t boundary, uint32_t non_manifold, uint32_t inconsistent) {
    nsdf_edge_count edges = {99, 99, 99};
    assert_int_equal(nsdf_surface_count_edges(s, &edges), 0);
    assert_int_equal(edges.boundary, boundary);
    assert_int_equal(edges.non_manifold, non_manifold);
    assert_int_equal(edges.inconsistent, inconsistent);
}

static void closed_meshes_have_no_odd_edges(void **state) {
    (void)state;
    nsdf_surface shapes[3] = {shape_cube(1), shape_sphere(1, 9, 14), shape_torus(1, 0.3, 12, 7)};
    for (int i = 0; i < 3; i++) {
        assert_edges(&shapes[i], 0, 0, 0);
        nsdf_surface_free(&shapes[i]);
    }
}

static void equal_positions_are_welded_and_zero_has_no_sign(void **state) {
    (void)state;
    nsdf_surface sphere = shape_sphere(1, 8, 12), soup = shape_unwelded(&sphere);
    for (uint32_t i = 0; i < soup.vertex_count; i++) {
        for (int k = 0; k < 3; k++) {
            float *x = &soup.positions[3 * i + (uint32_t)k];
            *x = *x == 0.0f && i % 2 ? -0.0f : *x;
        }
    }
    assert_edges(&soup, 0, 0, 0);
    nsdf_surface_free(&sphere);
    nsdf_surface_free(&soup);
}

static void a_hole_has_boundary_edges(void **state) {
    (void)state;
    nsdf_surface s = shape_cube(1);
    s.triangle_count--;
    assert_edges(&s, 3, 0, 0);
    nsdf_surface_free(&s);
}

static void a_turned_triangle_is_inconsistent(void **state) {
    (void)state;
    nsdf_surface s = shape_cube(1);
    uint32_t first = s.indices[0];
    s.indices[0] = s.indices[1];
    s.indices[1] = first;
    assert_edges(&s, 0, 0, 3);
    nsdf_surface_free(&s);
}

static void a_fin_makes_an_edge_non_manifold(void **state) {
    (void)state;
    nsdf_surface s = shape_cube(1);
    uint32_t tip = shape_vertex(&s, -3, 0, -1);
    shape_triangle(&s, 0, 2, tip);
    assert_edges(&s, 2, 1, 0);
    nsdf_surface_free(&s);
}

static void triangles_without_area_are_left_out(void **state) {
    (void)state;
    nsdf_surface s = shape_cube(1);
    uint32_t a = shape_vertex(&s, 0, 0, 0), b = shape_vertex(&s, 1, 1, 1), c = shape_vertex(&s, 3, 3, 3);
    shape_triangle(&s, a, b, c);
    shape_triangle(&s, a, a, b);
    assert_edges(&s, 0, 0, 0);
    assert_true(fabs(nsdf_surface_area(&s) - 24.0) < 1e-9);
    nsdf_surface_free(&s);
}

static void an_empty_surface_has_no_edges_and_no_area(void **state) {
    (void)state;
    nsdf_surface s = shape_empty();
    assert_edges(&s, 0, 0, 0);
    assert_true(nsdf_surface_area(&s) == 0.0);
    nsdf_surface_free(&s);
    assert_null(s.positions);
}

static void components_are_counted_across_seams(void **state) {
    (void)state;
    nsdf_surface s = shape_empty();
    shape_add_sphere(&s, 0.4, 8, 10, 0, 0);
    uint32_t first_count = s.triangle_count;
    shape_add_sphere(&s, 0.2, 6, 8, 0, 0);
    nsdf_surface soup = shape_unwelded(&s);
    uint32_t *component = malloc(sizeof *component * s.triangle_count);
    const nsdf_surface *both[2] = {&s, &soup};
    for (int which = 0; which < 2; which++) {
        memset(component, 0xff, sizeof *component * s.triangle_count);
        assert_int_equal(nsdf_surface_components(both[which], component), 2);
        for (uint32_t i = 0; i < s.triangle_count; i++) {
            assert_int_equal(component[i], i < first_count ? 0 : 1);
        }
    }
    free(component);
    nsdf_surface_free(&s);
    nsdf_surface_free(&soup);
}

static void triangles_that_share_one_vertex_are_connected(void **state) {
    (void)state;
    nsdf_surface s = shape_empty();
    for (int i = 0; i < 9; i++) {
        (void)shape_vertex(&s, i, i * i, 0);
    }
    shape_triangle(&s, 6, 7, 8);
    shape_triangle(&s, 0, 1, 2);
    shape_triangle(&s, 2, 3, 4);
    uint32_t component[3];
    assert_int_equal(nsdf_surface_components(&s, component), 2);
    assert_int_equal(component[0], 0);
    assert_int_equal(component[1], 1);
    assert_int_equal(component[2], 1);
    nsdf_surface_free(&s);
}

static void distances_between_cubes_are_the_analytic_ones(void **state) {
    (void)state;
    nsdf_surface inner = shape_cube(0.2), outer = shape_cube(0.25);
    nsdf_sdf *to_outer = nsdf_sdf_create(&outer, NSDF_SIGN_PSEUDO_NORMAL);
    nsdf_sdf *to_inner = nsdf_sdf_create(&inner, NSDF_SIGN_PSEUDO_NORMAL);
    nsdf_distance_stats in_to_out = {0}, out_to_in = {0};
    nsdf_random random = nsdf_random_start(1, 1);
    (void)shape_vertex(&inner, 5, 5, 5); /* no triangle uses it */
    assert_int_equal(nsdf_add_surface_distances(&inner, to_outer, 1000, &random, &in_to_out), 0);
    assert_int_equal(in_to_out.count, 1000);
    assert_true(fabs(in_to_out.sum - 1000 * 0.05) < 1e-3);
    assert_true(fabs(in_to_out.sum_squares - 1000 * 0.0025) < 1e-4);
    assert_true(fabs(in_to_out.max - 0.05) < 1e-6);
    assert_int_equal(nsdf_add_surface_distances(&outer, to_inner, 0, &random, &out_to_in), 0);
    assert_int_equal(out_to_in.count, 0);
    assert_true(fabs(out_to_in.max - 0.05 * sqrt(3.0)) < 1e-6);
    assert_int_equal(nsdf_add_surface_distances(&outer, to_inner, 500, &random, &in_to_out), 0);
    assert_int_equal(in_to_out.count, 1500);
    assert_true(fabs(in_to_out.max - 0.05 * sqrt(3.0)) < 1e-6);
    nsdf_sdf_free(to_outer);
    nsdf_sdf_free(to_inner);
    nsdf_surface_free(&inner);
    nsdf_surface_free(&outer);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_meshes_have_no_odd_edges),
        cmocka_unit_test(equal_positions_are_welded_and_zero_has_no_sign),
        cmocka_unit_test(a_hole_has_boundary_edges),
        cmocka_unit_test(a_turned_triangle_is_inconsistent),
        cmocka_unit_test(a_fin_makes_an_edge_non_manifold),
        cmocka_unit_test(triangles_without_area_are_left_out),
        cmocka_unit_test(an_empty_surface_has_no_edges_and_no_area),
        cmocka_unit_test(components_are_counted_across_seams),
        cmocka_unit_test(triangles_that_share_one_vertex_are_connected),
        cmocka_unit_test(distances_between_cubes_are_the_analytic_ones),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
