/* Surface that nobody outside meets, left out of a comparison. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "compare_shapes.h"
#include "geometry_shapes.h"
#include "hidden.h"

/* Adds a copy of `part`, times `scale`, moved along x. */
static void add_moved(nsdf_surface *s, const nsdf_surface *part, double scale, double x) {
    const uint32_t first = s->vertex_count;
    for (uint32_t v = 0; v < part->vertex_count; v++) {
        const float *p = part->positions + 3 * (size_t)v;
        (void)shape_vertex(s, scale * (double)p[0] + x, scale * (double)p[1], scale * (double)p[2]);
    }
    for (uint32_t i = 0; i < part->triangle_count; i++) {
        const uint32_t *t = part->indices + 3 * (size_t)i;
        shape_triangle(s, first + t[0], first + t[1], first + t[2]);
    }
}

static void turn(nsdf_surface *s) {
    for (size_t i = 0; i < s->triangle_count; i++) {
        const uint32_t second = s->indices[3 * i + 1];
        s->indices[3 * i + 1] = s->indices[3 * i + 2];
        s->indices[3 * i + 2] = second;
    }
}

/* How many triangles are hidden; bodies as nsdf_find_bodies finds them. */
static uint32_t hidden_of(const nsdf_surface *s) {
    nsdf_surface bodies, outer;
    assert_int_equal(nsdf_find_bodies(s, &bodies), 0);
    assert_int_equal(nsdf_find_outer(s, &bodies, 1, &outer), 0);
    const uint32_t hidden = outer.triangle_count ? s->triangle_count - outer.triangle_count : 0;
    free(bodies.indices);
    free(outer.indices);
    return hidden;
}

/* ---- Which triangles ------------------------------------------------------------------------------------ */

static nsdf_surface nested_boxes(void) {
    nsdf_surface cube = shape_cube(0.2), s = shape_empty();
    add_moved(&s, &cube, 1.0, 0.0);
    add_moved(&s, &cube, 0.5, 0.0);
    nsdf_surface_free(&cube);
    return s;
}

static void a_box_in_a_box_is_hidden_whichever_way_both_face(void **state) {
    nsdf_surface s = nested_boxes();
    (void)state;
    assert_int_equal(hidden_of(&s), 12);
    turn(&s);
    assert_int_equal(hidden_of(&s), 12);
    nsdf_surface_free(&s);
}

static void the_wall_of_a_cavity_is_not_hidden(void **state) {
    nsdf_surface s = nested_boxes();
    nsdf_surface inner = {s.positions, s.indices + 36, s.vertex_count, 12};
    (void)state;
    turn(&inner);
    assert_int_equal(hidden_of(&s), 0);
    nsdf_surface_free(&s);
}

static void a_sheet_in_a_box_is_hidden(void **state) {
    nsdf_surface s = shape_cube(0.2);
    (void)state;
    const uint32_t a = shape_vertex(&s, -0.1, -0.1, 0.0), b = shape_vertex(&s, 0.1, -0.1, 0.0),
                   c = shape_vertex(&s, 0.0, 0.1, 0.0);
    shape_triangle(&s, a, b, c);
    assert_int_equal(hidden_of(&s), 1);
    nsdf_surface_free(&s);
}

/* Between five sheets the winding number is up to 3/2: that of the inside of a body. */
static void open_sheets_hide_nothing(void **state) {
    nsdf_surface s = shape_empty();
    (void)state;
    for (int i = 0; i < 5; i++) {
        const double z = 0.001 * i;
        const uint32_t a = shape_vertex(&s, -0.3, -0.3, z), b = shape_vertex(&s, 0.3, -0.3, z),
                       c = shape_vertex(&s, 0.3, 0.3, z), d = shape_vertex(&s, -0.3, 0.3, z);
        shape_triangle(&s, a, b, c);
        shape_triangle(&s, a, c, d);
    }
    nsdf_surface bodies, outer;
    assert_int_equal(nsdf_find_bodies(&s, &bodies), 0);
    assert_int_equal(bodies.triangle_count, 0);
    assert_int_equal(hidden_of(&s), 0);
    assert_int_equal(nsdf_find_outer(&s, &s, 1, &outer), 0);
    assert_true(outer.triangle_count > 0); /* so they would, were they taken for bodies */
    free(outer.indices);
    free(bodies.indices);
    nsdf_surface_free(&s);
}

static void a_body_with_a_hole_hides_nothing(void **state) {
    nsdf_surface s = nested_boxes();
    (void)state;
    s.indices[0] = s.indices[1]; /* of the outer one */
    assert_int_equal(hidden_of(&s), 0);
    nsdf_surface_free(&s);
}

/* ---- What is measured ----------------------------------------------------------------------------------- */

static nsdf_difference compare_outer(const nsdf_surface *a, const nsdf_surface *b, uint32_t outer) {
    nsdf_compare_options options;
    nsdf_compare_options_init(&options);
    options.outer = outer;
    world_mesh first = world_copy(a, 7.0, 1.0, 2.0, 3.0), second = world_copy(b, 7.0, 1.0, 2.0, 3.0);
    const nsdf_difference d = compare_with(&first, &second, &options, NULL);
    world_free(&first);
    world_free(&second);
    return d;
}

static void a_hidden_box_counts_unless_it_is_left_out(void **state) {
    nsdf_surface both = nested_boxes(), cube = shape_cube(0.2);
    (void)state;
    nsdf_difference d = compare_outer(&both, &cube, 0);
    assert_near(d.hausdorff, 0.7, 1e-5); /* from the inner box, of half the size */
    assert_true(d.reference.hidden_share == 0.0);
    const nsdf_shape whole = d.reference;
    d = compare_outer(&both, &cube, NSDF_COMPARE_REFERENCE);
    assert_true(d.hausdorff == 0.0 && d.to_decoded.mean == 0.0);
    assert_near(d.reference.hidden_share, 0.2, 1e-6); /* 1/4 of 5/4 */
    assert_true(d.decoded.hidden_share == 0.0);
    assert_same_shape(&d.reference, &whole);
    d = compare_outer(&cube, &both, NSDF_COMPARE_REFERENCE);
    assert_near(d.hausdorff, 0.7, 1e-5);
    d = compare_outer(&cube, &both, NSDF_COMPARE_DECODED);
    assert_true(d.hausdorff == 0.0 && d.reference.hidden_share == 0.0);
    assert_near(d.decoded.hidden_share, 0.2, 1e-6);
    nsdf_surface_free(&both);
    nsdf_surface_free(&cube);
}

/* Of each of two spheres that are 1.2 radii apart, a cap of (1 - 0.6) / 2 = 1/5 lies in the other. */
static void of_two_spheres_the_caps_are_left_out(void **state) {
    nsdf_surface sphere = shape_sphere(0.2, 40, 60), both = shape_empty();
    (void)state;
    add_moved(&both, &sphere, 1.0, -0.12);
    add_moved(&both, &sphere, 1.0, 0.12);
    const nsdf_difference d = compare_outer(&both, &both, NSDF_COMPARE_REFERENCE);
    assert_near(d.reference.hidden_share, 0.2, 0.01);
    assert_near(d.to_decoded.max, 0.0, 0.0);
    assert_near(d.to_reference.max, 7.0 * hypot(0.16, 0.08),
                7.0 * 0.02); /* from a cap to the circle that is left, to an edge */
    nsdf_surface_free(&sphere);
    nsdf_surface_free(&both);
}

static void where_nothing_is_hidden_the_figures_are_the_same(void **state) {
    nsdf_surface torus = shape_torus(0.7, 0.3, 30, 20), sphere = shape_sphere(0.8, 12, 20);
    (void)state;
    const nsdf_difference plain = compare_outer(&torus, &sphere, 0);
    const nsdf_difference outer = compare_outer(&torus, &sphere, NSDF_COMPARE_REFERENCE | NSDF_COMPARE_DECODED);
    assert_same_distances(&plain.to_decoded, &outer.to_decoded);
    assert_same_distances(&plain.to_reference, &outer.to_reference);
    assert_true(plain.hausdorff == outer.hausdorff && plain.fmpd == outer.fmpd);
    assert_same_shape(&plain.reference, &outer.reference);
    assert_true(outer.reference.hidden_share == 0.0 && outer.decoded.hidden_share == 0.0);
    nsdf_surface_free(&torus);
    nsdf_surface_free(&sphere);
}

static void the_summary_has_shares_of_both(void **state) {
    nsdf_difference d[2] = {{.hausdorff = 0.0}, {.hausdorff = 0.0}};
    nsdf_difference_summary s;
    (void)state;
    d[1].reference.hidden_share = 0.5;
    d[0].decoded.hidden_share = 0.25;
    assert_int_equal(nsdf_compare_summarise(d, 2, 1.0, &s), NSDF_OK);
    assert_true(s.hidden_mean[0] == 0.25 && s.hidden_max[0] == 0.5);
    assert_true(s.hidden_mean[1] == 0.125 && s.hidden_max[1] == 0.25);
}

static void unknown_meshes_are_refused(void **state) {
    nsdf_compare_options options;
    nsdf_compare *compare = NULL;
    nsdf_encoder_error error;
    (void)state;
    nsdf_compare_options_init(&options);
    options.outer = 4;
    assert_int_equal(nsdf_compare_create(&compare, &options, &error), NSDF_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "outer is 4"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_in_a_box_is_hidden_whichever_way_both_face),
        cmocka_unit_test(the_wall_of_a_cavity_is_not_hidden),
        cmocka_unit_test(a_sheet_in_a_box_is_hidden),
        cmocka_unit_test(open_sheets_hide_nothing),
        cmocka_unit_test(a_body_with_a_hole_hides_nothing),
        cmocka_unit_test(a_hidden_box_counts_unless_it_is_left_out),
        cmocka_unit_test(of_two_spheres_the_caps_are_left_out),
        cmocka_unit_test(where_nothing_is_hidden_the_figures_are_the_same),
        cmocka_unit_test(the_summary_has_shares_of_both),
        cmocka_unit_test(unknown_meshes_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
