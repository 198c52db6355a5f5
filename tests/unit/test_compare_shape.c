#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "compare_shapes.h"
#include "geometry_shapes.h"

/* The numbers of a shape, measured as the reference of a comparison with itself. */
static nsdf_shape shape_of(const nsdf_surface *surface, double scale) {
    world_mesh mesh = world_copy(surface, scale, 10.0, -4.0, 3.0);
    nsdf_difference d = compare_meshes(&mesh, &mesh, 10, NSDF_COMPARE_SHAPES);
    world_free(&mesh);
    assert_same_shape(&d.reference, &d.decoded);
    assert_int_equal(d.reference.vertices, surface->vertex_count);
    assert_int_equal(d.reference.triangles, surface->triangle_count);
    assert_true(d.reference.roughness == 0.0 && d.fmpd == 0.0); /* not asked for */
    return d.reference;
}

static void assert_topology(const nsdf_shape *shape, uint32_t components, int64_t euler, uint32_t open_edges) {
    assert_int_equal(shape->components, components);
    assert_int_equal(shape->euler, euler);
    assert_int_equal(shape->open_edges, open_edges);
}

static void a_cube_is_measured_exactly(void **state) {
    (void)state;
    nsdf_surface cube = shape_cube(1.0);
    nsdf_shape shape = shape_of(&cube, 1.5);
    assert_topology(&shape, 1, 2, 0);
    assert_near(shape.area, 54.0, 1e-4);
    assert_near(shape.volume, 27.0, 1e-4);
    nsdf_surface_free(&cube);
}

static void a_torus_has_the_euler_number_0(void **state) {
    (void)state;
    const double pi = 3.141592653589793;
    nsdf_surface torus = shape_torus(0.7, 0.2, 90, 40);
    nsdf_shape shape = shape_of(&torus, 1.0);
    assert_topology(&shape, 1, 0, 0);
    assert_near(shape.area, 4.0 * pi * pi * 0.7 * 0.2, 0.02);
    assert_near(shape.volume, 2.0 * pi * pi * 0.7 * 0.2 * 0.2, 0.005);
    nsdf_surface_free(&torus);
}

static void pieces_add_up(void **state) {
    (void)state;
    nsdf_surface two = shape_empty();
    shape_add_sphere(&two, 0.9, 20, 30, 0, 0);
    shape_add_sphere(&two, 0.5, 20, 30, 1, 0); /* a hollow */
    nsdf_shape shape = shape_of(&two, 1.0);
    assert_topology(&shape, 2, 4, 0);
    assert_near(shape.volume, 4.18879 * (0.729 - 0.125), 0.05);
    nsdf_surface soup = shape_unwelded(&two);
    nsdf_shape same = shape_of(&soup, 1.0);
    assert_topology(&same, 2, 4, 0);
    assert_near(same.volume, shape.volume, 1e-9);
    nsdf_surface_free(&two);
    nsdf_surface_free(&soup);
}

static void an_open_sphere_counts_its_open_edges(void **state) {
    (void)state;
    nsdf_surface open = shape_empty();
    shape_add_sphere(&open, 1.0, 20, 30, 0, 3);
    nsdf_shape shape = shape_of(&open, 1.0);
    assert_topology(&shape, 1, 1, 30);
    nsdf_surface_free(&open);
}

static void a_sphere_turned_inside_out_has_negative_volume(void **state) {
    (void)state;
    nsdf_surface sphere = shape_empty();
    shape_add_sphere(&sphere, 1.0, 40, 60, 1, 0);
    nsdf_shape shape = shape_of(&sphere, 2.0);
    assert_topology(&shape, 1, 2, 0);
    assert_near(shape.volume, -33.51, 0.3);
    nsdf_surface_free(&sphere);
}

static void triangles_without_area_and_unused_vertices_are_nothing(void **state) {
    (void)state;
    nsdf_surface cube = shape_cube(1.0);
    uint32_t a = shape_vertex(&cube, 0.0, 0.0, 0.0), b = shape_vertex(&cube, 0.5, 0.5, 0.5);
    shape_triangle(&cube, a, a, b);
    shape_triangle(&cube, 0, b, 7); /* on the diagonal */
    (void)shape_vertex(&cube, 9.0, 9.0, 9.0);
    nsdf_shape shape = shape_of(&cube, 1.0);
    assert_topology(&shape, 1, 2, 0);
    assert_near(shape.area, 24.0, 1e-5);
    nsdf_surface_free(&cube);
}

static void psnr_is_in_decibels_of_three_peaks_squared(void **state) {
    (void)state;
    assert_near(nsdf_psnr(12.0, 2.0), 0.0, 1e-12);
    assert_near(nsdf_psnr(3e-4, 1.0), 40.0, 1e-12);
    assert_near(nsdf_psnr(3e-4, 10.0), 60.0, 1e-12);
    assert_true(isinf(nsdf_psnr(0.0, 1.0)) && nsdf_psnr(0.0, 1.0) > 0.0);
}

static void a_summary_is_of_all_frames(void **state) {
    (void)state;
    nsdf_difference frames[2] = {{.to_decoded = {1.0, 3.0, 7.0, 5.0, 10.0, 30.0},
                                  .to_reference = {2.0, 2.0, 4.0, 1.0, 8.0, 6.0},
                                  .hausdorff = 7.0,
                                  .fmpd = 0.25,
                                  .reference = {.components = 1, .euler = 2},
                                  .decoded = {.components = 2, .euler = 2}},
                                 {.to_decoded = {3.0, 4.0, 5.0, 5.0, 20.0, 40.0},
                                  .to_reference = {4.0, 14.0, 16.0, 1.0, 4.0, 8.0},
                                  .hausdorff = 16.0,
                                  .fmpd = 0.75,
                                  .reference = {.components = 3, .euler = 0},
                                  .decoded = {.components = 2, .euler = 2}}};
    nsdf_difference_summary s;
    assert_int_equal(nsdf_compare_summarise(frames, 2, 10.0, &s), NSDF_OK);
    assert_int_equal(s.frames, 2);
    assert_near(s.mean[0], 2.0, 1e-12);
    assert_near(s.mean[1], 3.0, 1e-12);
    assert_near(s.rms[0], sqrt(12.5), 1e-12);
    assert_near(s.rms[1], 10.0, 1e-12);
    assert_near(s.max[0], 7.0, 1e-12);
    assert_near(s.max[1], 16.0, 1e-12);
    assert_near(s.hausdorff_max, 16.0, 1e-12);
    assert_near(s.hausdorff_mean, 11.5, 1e-12);
    assert_near(s.psnr_d1, 10.0 * log10(300.0 / 25.0), 1e-12);
    assert_near(s.psnr_d2, 10.0 * log10(300.0 / 100.0), 1e-12);
    assert_near(s.normal_mean[0], 15.0, 1e-12);
    assert_near(s.normal_mean[1], 6.0, 1e-12);
    assert_near(s.normal_rms[0], sqrt(1250.0), 1e-12);
    assert_near(s.normal_rms[1], sqrt(50.0), 1e-12);
    assert_near(s.fmpd_max, 0.75, 1e-12);
    assert_near(s.fmpd_mean, 0.5, 1e-12);
    assert_int_equal(s.component_mismatches, 2);
    assert_int_equal(s.euler_mismatches, 1);
}

static void summaries_of_nothing_are_refused(void **state) {
    (void)state;
    nsdf_difference frame = {0};
    nsdf_difference_summary s = {.frames = 42};
    assert_int_equal(nsdf_compare_summarise(&frame, 0, 1.0, &s), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_compare_summarise(&frame, 1, 0.0, &s), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_compare_summarise(&frame, 1, NAN, &s), NSDF_INVALID_ARGUMENT);
    assert_int_equal(s.frames, 42);
    assert_int_equal(nsdf_compare_summarise(&frame, 1, 1.0, &s), NSDF_OK);
    assert_true(isinf(s.psnr_d1) && isinf(s.psnr_d2));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cube_is_measured_exactly),
        cmocka_unit_test(a_torus_has_the_euler_number_0),
        cmocka_unit_test(pieces_add_up),
        cmocka_unit_test(an_open_sphere_counts_its_open_edges),
        cmocka_unit_test(a_sphere_turned_inside_out_has_negative_volume),
        cmocka_unit_test(triangles_without_area_and_unused_vertices_are_nothing),
        cmocka_unit_test(psnr_is_in_decibels_of_three_peaks_squared),
        cmocka_unit_test(a_summary_is_of_all_frames),
        cmocka_unit_test(summaries_of_nothing_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
