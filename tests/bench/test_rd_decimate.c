/* The simplifier of the rate-distortion bench, on shapes whose answers are known. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>

#include <cmocka.h>

#include "rd_decimate.h"
#include "unit/geometry_shapes.h"

static int64_t euler_number(const nsdf_surface *s) {
    int64_t vertices = 0;
    bool used[SHAPE_CAPACITY] = {false};
    for (size_t i = 0; i < 3 * (size_t)s->triangle_count; i++) {
        vertices += !used[s->indices[i]];
        used[s->indices[i]] = true;
    }
    return vertices - s->triangle_count / 2; /* closed: three edges for two triangles */
}

static void assert_closed(const nsdf_surface *s) {
    nsdf_edge_count edges;
    assert_int_equal(nsdf_surface_count_edges(s, &edges), 0);
    assert_int_equal(edges.boundary + edges.non_manifold + edges.inconsistent, 0);
}

static double volume_of(const nsdf_surface *s) {
    double sum = 0;
    for (uint32_t i = 0; i < s->triangle_count; i++)
        sum += nsdf_vec3_dot(shape_corner(s, i, 0), nsdf_vec3_cross(shape_corner(s, i, 1), shape_corner(s, i, 2)));
    return sum / 6;
}

static void free_shape(nsdf_surface *s) {
    free(s->positions);
    free(s->indices);
}

/* Vertices on the sphere make the body smaller; quadrics move them outwards. */
static void test_sphere(void **state) {
    (void)state;
    const double exact = 4.0 / 3.0 * 3.141592653589793;
    double lost[2];
    for (int placement = 0; placement < 2; placement++) {
        nsdf_surface s = shape_sphere(1, 40, 60);
        assert_int_equal(rd_decimate(&s, 400, (rd_placement)placement), 0);
        assert_true(s.triangle_count == 400 || s.triangle_count == 399);
        assert_closed(&s);
        assert_int_equal(euler_number(&s), 2);
        lost[placement] = 1 - volume_of(&s) / exact;
        free_shape(&s);
    }
    assert_true(lost[RD_PLACE_ENDPOINT] > 0.01 && lost[RD_PLACE_ENDPOINT] < 0.05);
    assert_true(fabs(lost[RD_PLACE_OPTIMAL]) < 0.6 * lost[RD_PLACE_ENDPOINT]);
}

static void test_endpoints_are_old_vertices(void **state) {
    (void)state;
    nsdf_surface s = shape_torus(1, 0.4, 40, 24), old = shape_torus(1, 0.4, 40, 24);
    assert_int_equal(rd_decimate(&s, 300, RD_PLACE_ENDPOINT), 0);
    for (uint32_t i = 0; i < s.triangle_count; i++) {
        for (int k = 0; k < 3; k++) {
            const nsdf_vec3 p = shape_corner(&s, i, k);
            double least = INFINITY;
            for (uint32_t j = 0; j < old.vertex_count; j++)
                least = fmin(least, nsdf_vec3_length(nsdf_vec3_sub(p, nsdf_vec3_load(&old.positions[3 * (size_t)j]))));
            assert_true(least < 1e-6);
        }
    }
    free_shape(&s);
    free_shape(&old);
}

/* A closed surface of genus 1 has at least 14 triangles. */
static void test_topology_stays(void **state) {
    (void)state;
    nsdf_surface s = shape_torus(1, 0.4, 30, 20);
    assert_int_equal(rd_decimate(&s, 0, RD_PLACE_OPTIMAL), 0);
    assert_true(s.triangle_count >= 14 && s.triangle_count < 120);
    assert_closed(&s);
    assert_int_equal(euler_number(&s), 0);
    free_shape(&s);
}

/* A cube made of 6 n^2 squares is exact with 12 triangles, wherever it lies. */
static void test_cube_is_exact(void **state) {
    (void)state;
    const uint32_t n = 12;
    nsdf_surface s = shape_empty();
    for (int side = 0; side < 6; side++) {
        for (uint32_t i = 0; i < n * n; i++) {
            uint32_t corner[4];
            for (uint32_t k = 0; k < 4; k++) {
                const double u = (i % n + (k == 1 || k == 2)) / (double)n, v = (i / n + (k >> 1)) / (double)n;
                const double w = side < 3 ? 0 : 1, flip = side < 3 ? 1 - u : u;
                const double xyz[3][3] = {{w, flip, v}, {v, w, flip}, {flip, v, w}}, *p = xyz[side % 3];
                corner[k] = shape_vertex(&s, 100 + p[0], p[1] - 50, p[2]);
            }
            shape_triangle(&s, corner[0], corner[1], corner[2]);
            shape_triangle(&s, corner[0], corner[2], corner[3]);
        }
    }
    assert_int_equal(rd_decimate(&s, 12, RD_PLACE_OPTIMAL), 0);
    assert_int_equal(s.triangle_count, 12);
    assert_closed(&s);
    assert_true(fabs(nsdf_surface_area(&s) - 6) < 1e-3);
    free_shape(&s);
}

static void test_border_stays(void **state) {
    (void)state;
    const uint32_t n = 16;
    nsdf_surface s = shape_empty();
    for (uint32_t i = 0; i <= n; i++) {
        for (uint32_t j = 0; j <= n; j++) {
            const uint32_t at = shape_vertex(&s, i / (double)n, j / (double)n, 0);
            if (i < n && j < n) {
                shape_triangle(&s, at, at + n + 1, at + n + 2);
                shape_triangle(&s, at, at + n + 2, at + 1);
            }
        }
    }
    assert_int_equal(rd_decimate(&s, 8, RD_PLACE_OPTIMAL), 0);
    assert_in_range(s.triangle_count, 2, 8);
    assert_true(fabs(nsdf_surface_area(&s) - 1) < 1e-3);
    free_shape(&s);
}

static void test_nothing_to_do(void **state) {
    (void)state;
    nsdf_surface s = shape_cube(1), unwelded = shape_unwelded(&s), empty = {0};
    assert_int_equal(rd_decimate(&unwelded, 12, RD_PLACE_OPTIMAL), 0);
    assert_int_equal(unwelded.triangle_count, 12);
    assert_closed(&unwelded);
    assert_true(fabs(volume_of(&unwelded) - 8) < 1e-6);
    assert_int_equal(rd_decimate(&empty, 0, RD_PLACE_OPTIMAL), 0);
    free_shape(&s);
    free_shape(&unwelded);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sphere),         cmocka_unit_test(test_endpoints_are_old_vertices),
        cmocka_unit_test(test_topology_stays), cmocka_unit_test(test_cube_is_exact),
        cmocka_unit_test(test_border_stays),   cmocka_unit_test(test_nothing_to_do),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
