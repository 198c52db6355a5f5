/* The encoder's public interface: what it refuses and how it says so, and the order of its calls. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "encode_samples.h"

static nsdf_encoder *new_encoder(void) {
    const nsdf_encoder_options o = hasty_options();
    nsdf_encoder *encoder = NULL;
    assert_int_equal(nsdf_encoder_create(&encoder, &o, NULL), NSDF_OK);
    return encoder;
}

static void assert_refused(nsdf_status status, const nsdf_encoder_error *error, const char *message) {
    assert_int_equal(status, NSDF_INVALID_ARGUMENT);
    assert_int_equal(error->status, NSDF_INVALID_ARGUMENT);
    assert_string_equal(error->message, message);
}

/* ---- Options -------------------------------------------------------------------------------------------- */

static void test_presets_are_valid(void **state) {
    (void)state;
    for (int preset = NSDF_PRESET_FAST; preset <= NSDF_PRESET_BEST; preset++) {
        nsdf_encoder_options o;
        nsdf_encoder *encoder = NULL;
        nsdf_encoder_options_init(&o, (nsdf_preset)preset);
        assert_int_equal(o.struct_size, sizeof o);
        assert_true(o.rate_num == 25 && o.rate_den == 1 && o.seed == 1 && o.resolution == 0 && o.verify);
        assert_int_equal(nsdf_encoder_create(&encoder, &o, NULL), NSDF_OK);
        nsdf_encoder_close(&encoder);
        assert_null(encoder);
    }
    nsdf_encoder *by_default = NULL;
    assert_int_equal(nsdf_encoder_create(&by_default, NULL, NULL), NSDF_OK);
    nsdf_encoder_close(&by_default);
}

static void test_slower_presets_do_more_and_thesis_is_its_network(void **state) {
    nsdf_encoder_options fast, medium, slow, best, thesis;
    (void)state;
    nsdf_encoder_options_init(&fast, NSDF_PRESET_FAST);
    nsdf_encoder_options_init(&medium, NSDF_PRESET_MEDIUM);
    nsdf_encoder_options_init(&slow, NSDF_PRESET_SLOW);
    nsdf_encoder_options_init(&best, NSDF_PRESET_BEST);
    nsdf_encoder_options_init(&thesis, NSDF_PRESET_THESIS);
    assert_true(fast.steps < medium.steps && medium.steps < slow.steps);
    assert_true(fast.blocks < medium.blocks && medium.blocks < slow.blocks && slow.blocks < best.blocks);
    assert_true(slow.bones < best.bones && slow.pose_step > best.pose_step && best.steps >= slow.steps);
    assert_true(thesis.layers == 16 && thesis.width == 256 && thesis.activation == NSDF_MODEL_RELU);
    assert_true(thesis.input == NSDF_MODEL_XYZT && thesis.output_tanh && !thesis.quantise_aware);
    assert_true(thesis.sampling == NSDF_SAMPLE_REJECTION && thesis.sdf_norm == NSDF_SDF_UNIT_RANGE);
    assert_true(thesis.loss == NSDF_LOSS_MAE && thesis.entropy == NSDF_CODER_DEFLATE);
    assert_true(fast.optimiser == NSDF_OPTIMISER_MUON && thesis.optimiser == NSDF_OPTIMISER_ADAM);
    assert_true(fast.hard_samples && medium.hard_samples && slow.hard_samples && !thesis.hard_samples);
}

/* One option out of range: what is set, and how the message begins. */
typedef struct mistake {
    void (*make)(nsdf_encoder_options *o);
    const char *message;
} mistake;

#define MISTAKE(field, value)                                                                                          \
    static void set_##field(nsdf_encoder_options *o) {                                                                 \
        o->field = value;                                                                                              \
    }
MISTAKE(layers, 0)
MISTAKE(width, 1025)
MISTAKE(knot_spacing, NAN)
MISTAKE(rank, 0)
MISTAKE(omega_first, 0.0)
MISTAKE(omega_hidden, INFINITY)
MISTAKE(fourier_features, 513)
MISTAKE(fourier_sigma, -1.0)
MISTAKE(rate_num, 0)
MISTAKE(rate_den, 0)
MISTAKE(threads, 257)
MISTAKE(samples_per_frame, 200000000)
MISTAKE(d_half, 0.0)
MISTAKE(shell, -0.1)
MISTAKE(loss_d0, -1.0)
MISTAKE(loss_slope, 0.0)
MISTAKE(steps, 0)
MISTAKE(batch_frames, 0)
MISTAKE(batch_points, 0)
MISTAKE(learning_rate, 0.0)
MISTAKE(parameter_rate, 1.5)
MISTAKE(resolution, 1)
MISTAKE(weight_bits, 3.9)
MISTAKE(input, NSDF_MODEL_XYZT)
#undef MISTAKE

static void test_options_out_of_range_are_named(void **state) {
    static const mistake mistakes[] = {
        {set_layers, "layers is 0, expected 1 to 31"},
        {set_width, "width is 1025, expected 1 to 1024"},
        {set_knot_spacing, "knot spacing is nan, expected 0.25 to 1000000"},
        {set_rank, "rank is 0, expected 1 to 256"},
        {set_omega_first, "omega of the first layer is 0, expected 0.001 to 10000"},
        {set_omega_hidden, "omega of the hidden layers is inf, expected 0.001 to 10000"},
        {set_fourier_features, "Fourier features is 513, expected 1 to 512"},
        {set_fourier_sigma, "Fourier sigma is -1, expected 1e-06 to 1000"},
        {set_rate_num, "frame rate numerator is 0, expected 1 to 4294967295"},
        {set_rate_den, "frame rate denominator is 0, expected 1 to 4294967295"},
        {set_threads, "threads is 257, expected 0 to 256"},
        {set_samples_per_frame, "samples per frame is 200000000, expected 0 to 100000000"},
        {set_d_half, "d_0.5 is 0, expected 1e-06 to 10"},
        {set_shell, "shell is -0.1, expected 0 to 1e+30"},
        {set_loss_d0, "loss d0 is -1, expected 1e-06 to 1000000"},
        {set_loss_slope, "loss slope is 0, expected 0.001 to 1000000000"},
        {set_steps, "steps is 0, expected 1 to 1e+12"},
        {set_batch_frames, "batch frames is 0, expected 1 to 4096"},
        {set_batch_points, "batch points is 0, expected 1 to 1048576"},
        {set_learning_rate, "learning rate is 0, expected 1e-12 to 1"},
        {set_parameter_rate, "parameter rate is 1.5, expected 0 to 1"},
        {set_resolution, "resolution is 1, expected 2 to 4096"},
        {set_weight_bits, "weight bits are 3.9, expected 4 to 16, or 32"},
        {set_input, "weights that change with time go with xyz input only: time is an input otherwise"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof mistakes / sizeof *mistakes; i++) {
        nsdf_encoder_options o = hasty_options();
        nsdf_encoder_error error = {NSDF_OK, ""};
        nsdf_encoder *encoder = NULL;
        mistakes[i].make(&o);
        assert_refused(nsdf_encoder_create(&encoder, &o, &error), &error, mistakes[i].message);
        assert_int_equal(nsdf_encoder_create(&encoder, &o, NULL), NSDF_INVALID_ARGUMENT);
        assert_null(encoder);
    }
}

static void test_weight_bits_are_4_to_16_or_32(void **state) {
    static const double good[] = {4.0, 7.5, 16.0, 32.0}, bad[] = {0.0, 16.5, 31.0, 33.0, NAN};
    nsdf_encoder *encoder = NULL;
    (void)state;
    for (size_t i = 0; i < 4; i++) {
        nsdf_encoder_options o = hasty_options();
        o.weight_bits = good[i];
        assert_int_equal(nsdf_encoder_create(&encoder, &o, NULL), NSDF_OK);
        nsdf_encoder_close(&encoder);
    }
    for (size_t i = 0; i < 5; i++) {
        nsdf_encoder_options o = hasty_options();
        o.weight_bits = bad[i];
        assert_int_equal(nsdf_encoder_create(&encoder, &o, NULL), NSDF_INVALID_ARGUMENT);
    }
}

static void test_options_of_another_size_are_refused(void **state) {
    nsdf_encoder_options o = hasty_options();
    nsdf_encoder_error error = {NSDF_OK, ""};
    nsdf_encoder *encoder = NULL;
    char expected[120];
    (void)state;
    o.struct_size = 8;
    snprintf(expected, sizeof expected, "the options have 8 bytes, expected %zu: call nsdf_encoder_options_init",
             sizeof o);
    assert_refused(nsdf_encoder_create(&encoder, &o, &error), &error, expected);
}

static void test_nulls_are_refused_with_a_message(void **state) {
    nsdf_encoder_error error;
    nsdf_encoder *encoder = new_encoder(), *none = NULL;
    const nsdf_input_mesh mesh = {NULL, NULL, 0, 0};
    (void)state;
    assert_refused(nsdf_encoder_create(NULL, NULL, &error), &error, "a NULL was given");
    assert_refused(nsdf_encoder_add_frame(NULL, 0, &mesh, &error), &error, "a NULL was given");
    assert_refused(nsdf_encoder_add_frame(encoder, 0, NULL, &error), &error, "a NULL was given");
    error.message[0] = 0;
    assert_refused(nsdf_encoder_run(NULL, NULL, NULL, &error), &error, "a NULL was given");
    assert_refused(nsdf_encoder_write(NULL, append_bytes, NULL, &error), &error, "a NULL was given");
    assert_refused(nsdf_encoder_write(encoder, NULL, NULL, &error), &error, "a NULL was given");
    assert_int_equal(nsdf_encoder_get_stats(encoder, NULL), NSDF_INVALID_ARGUMENT);
    nsdf_encoder_close(NULL);
    nsdf_encoder_close(&none);
    nsdf_encoder_close(&encoder);
    assert_null(encoder);
}

/* ---- Frames --------------------------------------------------------------------------------------------- */

static const uint32_t tetrahedron[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
static const double corners[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};

static void refuse_mesh(nsdf_encoder *encoder, const double *positions, const uint32_t *indices, uint32_t vertices,
                        uint32_t triangles, const char *message) {
    const nsdf_input_mesh mesh = {positions, indices, vertices, triangles};
    nsdf_encoder_error error = {NSDF_OK, ""};
    assert_refused(nsdf_encoder_add_frame(encoder, 3, &mesh, &error), &error, message);
}

static void test_bad_meshes_are_refused_and_do_no_harm(void **state) {
    nsdf_encoder *encoder = new_encoder();
    nsdf_encoder_error error;
    double positions[12];
    uint32_t indices[12];
    (void)state;
    refuse_mesh(encoder, corners, tetrahedron, 4, 0, "frame 3: no faces");
    refuse_mesh(encoder, corners, tetrahedron, 0, 4, "frame 3: no faces");
    refuse_mesh(encoder, NULL, tetrahedron, 4, 4, "frame 3: no faces");
    refuse_mesh(encoder, corners, NULL, 4, 4, "frame 3: no faces");
    memcpy(positions, corners, sizeof positions);
    positions[7] = NAN;
    refuse_mesh(encoder, positions, tetrahedron, 4, 4, "frame 3: vertex 2 is not finite");
    positions[7] = -INFINITY;
    refuse_mesh(encoder, positions, tetrahedron, 4, 4, "frame 3: vertex 2 is not finite");
    positions[7] = -1e39;
    refuse_mesh(encoder, positions, tetrahedron, 4, 4, "frame 3: vertex 2 is further away than 1e+30");
    memcpy(indices, tetrahedron, sizeof indices);
    indices[10] = 4;
    refuse_mesh(encoder, corners, indices, 4, 4, "frame 3: triangle 3 uses vertex 4, but there are 4");
    const nsdf_input_mesh good = {corners, tetrahedron, 4, 4};
    assert_int_equal(nsdf_encoder_add_frame(encoder, 3, &good, &error), NSDF_OK);
    assert_int_equal(nsdf_encoder_run(encoder, skip_repair, NULL, &error), NSDF_OK);
    nsdf_encoder_close(&encoder);
}

static void test_frame_numbers_ascend(void **state) {
    const nsdf_input_mesh mesh = {corners, tetrahedron, 4, 4};
    nsdf_encoder *encoder = new_encoder();
    nsdf_encoder_error error;
    (void)state;
    assert_int_equal(nsdf_encoder_add_frame(encoder, 5, &mesh, &error), NSDF_OK);
    assert_refused(nsdf_encoder_add_frame(encoder, 5, &mesh, &error), &error, "frame 5 was added after frame 5");
    assert_refused(nsdf_encoder_add_frame(encoder, 3, &mesh, &error), &error, "frame 3 was added after frame 5");
    assert_int_equal(nsdf_encoder_add_frame(encoder, 7, &mesh, &error), NSDF_OK);
    assert_refused(nsdf_encoder_add_frame(encoder, 6, &mesh, &error), &error, "frame 6 was added after frame 7");
    nsdf_encoder_close(&encoder);
}

/* Numbers from 0 to 2^32 - 1 would be one frame more than a file can count. */
static void test_frames_that_cannot_be_counted_are_refused(void **state) {
    const nsdf_input_mesh mesh = {corners, tetrahedron, 4, 4};
    nsdf_encoder *encoder = new_encoder();
    nsdf_encoder_error error;
    (void)state;
    assert_int_equal(nsdf_encoder_add_frame(encoder, 0, &mesh, &error), NSDF_OK);
    assert_refused(nsdf_encoder_add_frame(encoder, UINT32_MAX, &mesh, &error), &error,
                   "frame 4294967295 is too far from frame 0: a file counts to 4294967295");
    nsdf_encoder_close(&encoder);
}

/* ---- Running -------------------------------------------------------------------------------------------- */

static int fail_to_write(void *user, const void *data, size_t size) {
    (void)data;
    *(size_t *)user += size;
    return 1;
}

static void test_calls_out_of_order_are_refused(void **state) {
    const nsdf_input_mesh mesh = {corners, tetrahedron, 4, 4};
    nsdf_encoder *encoder = new_encoder();
    nsdf_encoder_error error;
    encoded e = {.size = 0};
    size_t offered = 0;
    (void)state;
    assert_refused(nsdf_encoder_run(encoder, NULL, NULL, &error), &error, "no frames were added");
    assert_refused(nsdf_encoder_write(encoder, append_bytes, &e, &error), &error, "nothing was encoded");
    assert_int_equal(nsdf_encoder_add_frame(encoder, 0, &mesh, &error), NSDF_OK);
    assert_int_equal(nsdf_encoder_run(encoder, skip_repair, NULL, &error), NSDF_OK);
    assert_refused(nsdf_encoder_run(encoder, NULL, NULL, &error), &error, "an encoder runs once");
    assert_refused(nsdf_encoder_add_frame(encoder, 1, &mesh, &error), &error, "frames cannot be added after a run");
    assert_int_equal(nsdf_encoder_write(encoder, fail_to_write, &offered, &error), NSDF_IO);
    assert_int_equal(error.status, NSDF_IO);
    assert_string_equal(error.message, "the file cannot be written");
    assert_true(offered > 0);
    for (int i = 0; i < 2; i++) { /* the bytes stay, and can be had again */
        assert_int_equal(nsdf_encoder_write(encoder, append_bytes, &e, &error), NSDF_OK);
        assert_true(e.size == (size_t)(i + 1) * offered);
    }
    assert_memory_equal(e.data, e.data + offered, offered);
    free(e.data);
    nsdf_encoder_close(&encoder);
}

static void test_sequences_without_extent_are_refused(void **state) {
    static const double point[9] = {2, 2, 2, 2, 2, 2, 2, 2, 2}, line[9] = {0, 0, 0, 1, 1, 1, 2, 2, 2};
    static const uint32_t triangle[3] = {0, 1, 2};
    static const char *const messages[2] = {"the sequence has no extent: all its faces are in one point",
                                            "frame 0 has no area"};
    (void)state;
    for (int i = 0; i < 2; i++) {
        const nsdf_input_mesh mesh = {i ? line : point, triangle, 3, 1};
        nsdf_encoder *encoder = new_encoder();
        nsdf_encoder_error error;
        encoded e = {.size = 0};
        assert_int_equal(nsdf_encoder_add_frame(encoder, 0, &mesh, &error), NSDF_OK);
        assert_refused(nsdf_encoder_run(encoder, NULL, NULL, &error), &error, messages[i]);
        assert_refused(nsdf_encoder_write(encoder, append_bytes, &e, &error), &error, "nothing was encoded");
        assert_true(e.size == 0);
        nsdf_encoder_close(&encoder);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_presets_are_valid),
        cmocka_unit_test(test_slower_presets_do_more_and_thesis_is_its_network),
        cmocka_unit_test(test_options_out_of_range_are_named),
        cmocka_unit_test(test_weight_bits_are_4_to_16_or_32),
        cmocka_unit_test(test_options_of_another_size_are_refused),
        cmocka_unit_test(test_nulls_are_refused_with_a_message),
        cmocka_unit_test(test_bad_meshes_are_refused_and_do_no_harm),
        cmocka_unit_test(test_frame_numbers_ascend),
        cmocka_unit_test(test_frames_that_cannot_be_counted_are_refused),
        cmocka_unit_test(test_calls_out_of_order_are_refused),
        cmocka_unit_test(test_sequences_without_extent_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
