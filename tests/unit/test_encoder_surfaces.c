/* Surfaces that come out of the encoder and the decoder as they went in. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "encode_samples.h"
#include "nsdf/export.h"

static float value_at(nsdf_decoder *decoder, double t, float x, float y, float z) {
    const float xyz[3] = {x, y, z};
    float value = NAN;
    assert_int_equal(nsdf_evaluate(decoder, t, xyz, 1, &value, NULL), NSDF_OK);
    return value;
}

static nsdf_encoder_options sphere_options(void) {
    nsdf_encoder_options o = sample_options(2, 16);
    o.omega_first = 12.0;
    o.learning_rate = 5e-3;
    o.steps = 800;
    o.samples_per_frame = 20000;
    o.batch_frames = 4;
    o.batch_points = 512;
    o.resolution = 48;
    return o;
}

/* Mean distance, as a fraction of the diagonal, of the decoded vertices at nominal frame i from a sphere. */
static double sphere_error(nsdf_decoder *decoder, uint32_t i, double radius, double diagonal) {
    nsdf_mesh *mesh = NULL;
    nsdf_mesh_view view;
    double t, sum = 0.0;
    assert_int_equal(nsdf_frame_time(decoder, i, &t), NSDF_OK);
    assert_int_equal(nsdf_extract_mesh(decoder, t, NULL, &mesh), NSDF_OK);
    assert_int_equal(nsdf_mesh_get_view(mesh, &view), NSDF_OK);
    assert_true(view.vertex_count > 1000);
    for (size_t v = 0; v < view.vertex_count; v++) {
        const double x = (double)view.positions[3 * v], y = (double)view.positions[3 * v + 1];
        const double z = (double)view.positions[3 * v + 2];
        sum += fabs(sqrt(x * x + y * y + z * z) - radius);
    }
    sum /= (double)view.vertex_count * diagonal;
    nsdf_mesh_free(&mesh);
    return sum;
}

static void test_a_growing_sphere_is_fitted(void **state) {
    const nsdf_encoder_options o = sphere_options();
    double mean = 0.0;
    (void)state;
    encoded e = encode_well(&o, growing_sphere, skip_repair, NULL);
    nsdf_decoder *decoder = open_file(&e);
    for (uint32_t i = 0; i < 4; i++)
        mean += 0.25 * sphere_error(decoder, i, 1.0 + 0.1 * i, e.stats.diagonal);
    assert_true(mean < 0.004);
    assert_true(e.stats.quality.mean_to_decoded < 0.004 && e.stats.quality.mean_to_input < 0.004);
    assert_true(fabs(e.stats.quality.mean_to_input - mean) < 0.001); /* measured on triangles, not on the sphere */
    assert_true(e.stats.quality.max_to_input < 0.04 && e.stats.quality.rms_to_input >= e.stats.quality.mean_to_input);
    assert_true(e.stats.fit_error < 0.006);
    assert_int_equal(e.stats.stray_pieces, 0);
    nsdf_close(&decoder);
    free(e.data);
}

static int inward_sphere(uint32_t i, nsdf_surface *surface, uint32_t *number) {
    *number = i;
    if (i >= 1)
        return 0;
    *surface = shape_empty();
    shape_add_sphere(surface, 1.0, 16, 32, 1, 0);
    return 1;
}

static uint64_t mesh_hash(nsdf_decoder *decoder, uint32_t frame, uint32_t dense) {
    nsdf_mesh_options options;
    nsdf_mesh *mesh = NULL;
    nsdf_mesh_view view;
    double t;
    nsdf_mesh_options_init(&options);
    options.resolution = 96;
    options.dense = dense;
    assert_int_equal(nsdf_frame_time(decoder, frame, &t), NSDF_OK);
    assert_int_equal(nsdf_extract_mesh(decoder, t, &options, &mesh), NSDF_OK);
    assert_int_equal(nsdf_mesh_get_view(mesh, &view), NSDF_OK);
    assert_true(view.triangle_count > 1000);
    const uint64_t hash = nsdf_mesh_hash(&view);
    nsdf_mesh_free(&mesh);
    return hash;
}

/* A fitted distance has a slope near 1, so a bound near 1 must do; on a finer grid than the one it was checked on. */
static void test_the_bound_is_small_and_skips_nothing(void **state) {
    nsdf_encoder_options o = sphere_options();
    (void)state;
    o.verify = 0;
    encoded e = encode_well(&o, growing_sphere, skip_repair, NULL);
    nsdf_decoder *decoder = open_file(&e);
    assert_true(e.stats.bound >= 1.0 && e.stats.bound < 3.0);
    for (uint32_t i = 0; i < 4; i++)
        assert_true(mesh_hash(decoder, i, 0) == mesh_hash(decoder, i, 1));
    nsdf_close(&decoder);
    free(e.data);
}

static void test_inward_meshes_are_turned_round(void **state) {
    nsdf_encoder_options o = sphere_options();
    (void)state;
    o.steps = 150;
    o.verify = 0;
    encoded e = encode_well(&o, inward_sphere, skip_repair, NULL);
    assert_int_equal(e.stats.input.reversed, 1);
    nsdf_decoder *decoder = open_file(&e);
    assert_true(value_at(decoder, 0.0, 0.0f, 0.0f, 0.0f) < 0.0f);
    assert_true(value_at(decoder, 0.0, 0.0f, 0.0f, 0.8f) < 0.0f);
    assert_true(value_at(decoder, 0.0, 0.7f, 0.7f, 0.7f) > 0.0f);
    nsdf_close(&decoder);
    free(e.data);
}

/* A square of side 2 in the plane z = 0. */
static int square_sheet(uint32_t i, nsdf_surface *surface, uint32_t *number) {
    *number = 11;
    if (i >= 1)
        return 0;
    *surface = shape_empty();
    for (int k = 0; k < 4; k++)
        (void)shape_vertex(surface, k & 1 ? 1.0 : -1.0, k & 2 ? 1.0 : -1.0, 0.0);
    shape_triangle(surface, 0, 1, 3);
    shape_triangle(surface, 0, 3, 2);
    return 1;
}

static void test_open_sheets_get_a_thickness(void **state) {
    nsdf_encoder_options o = sphere_options();
    (void)state;
    o.shell = NSDF_NO_SHELL;
    encoded e = encode(&o, square_sheet, skip_repair, NULL);
    assert_int_equal(e.status, NSDF_INVALID_ARGUMENT);
    assert_string_equal(e.error.message, "frame 11 has no inside: it is a sheet with 4 open edges; give it a thickness "
                                         "(shell)");
    o.shell = 0.08;
    o.steps = 1200;
    e = encode_well(&o, square_sheet, skip_repair, NULL);
    nsdf_decoder *decoder = open_file(&e);
    for (int k = 0; k < 9; k++) {
        const float x = 0.4f * (float)(k % 3 - 1), y = 0.4f * (float)(k / 3 - 1);
        assert_true(value_at(decoder, 0.0, x, y, 0.0f) < 0.0f);
        assert_true(value_at(decoder, 0.0, x, y, 0.08f) > 0.0f);
        assert_true(value_at(decoder, 0.0, x, y, -0.08f) > 0.0f);
    }
    assert_int_equal(e.stats.input.sheets, 1);
    assert_int_equal(e.stats.input.open_edges, 4);
    assert_true(e.stats.input.sheet_thickness == 0.08 && e.stats.blocks == 0);
    assert_int_equal(e.stats.stray_pieces, 0);
    nsdf_close(&decoder);
    free(e.data);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_growing_sphere_is_fitted),
        cmocka_unit_test(test_the_bound_is_small_and_skips_nothing),
        cmocka_unit_test(test_inward_meshes_are_turned_round),
        cmocka_unit_test(test_open_sheets_get_a_thickness),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
