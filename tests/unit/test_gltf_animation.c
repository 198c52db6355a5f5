#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <unistd.h>

#include <cmocka.h>

#include "make_gltf.h"
#include "nsdf/sequence.h"

static const char *const path = "test_gltf_animation.glb";

/* Opens a file of these bytes at a rate, 0 = its own; skips the test where the library was built without glTF. */
static nsdf_status open_bytes(const unsigned char *bytes, size_t size, uint32_t rate, nsdf_sequence **sequence,
                              nsdf_encoder_error *error) {
    nsdf_sequence_options options;
    nsdf_input_mesh mesh;
    FILE *file = fopen(path, "wb");
    assert_true(file && fwrite(bytes, 1, size, file) == size && fclose(file) == 0);
    nsdf_sequence_options_init(&options);
    options.rate_num = rate;
    options.rate_den = rate ? 1 : 0;
    nsdf_status status = nsdf_sequence_open(sequence, &path, 1, &options, error);
    if (status == NSDF_OK && nsdf_sequence_load(*sequence, 0, &mesh, error) == NSDF_UNSUPPORTED_FEATURE) {
        nsdf_sequence_close(sequence);
        skip();
    }
    return status;
}

static nsdf_sequence *open_kind(const char *kind, uint32_t rate) {
    nsdf_sequence *sequence = NULL;
    nsdf_encoder_error error = {NSDF_OK, ""};
    unsigned char *bytes = NULL;
    const size_t size = gltf_make(kind, &bytes);
    assert_true(size > 0);
    const nsdf_status status = open_bytes(bytes, size, rate, &sequence, &error);
    free(bytes);
    if (status != NSDF_OK)
        fail_msg("%s: %s", kind, error.message);
    return sequence;
}

/* Where a vertex of the bar goes at a time. */
typedef void (*motion)(double seconds, double p[3]);

static void assert_frame(nsdf_sequence *sequence, uint32_t frame, double seconds, motion move) {
    nsdf_input_mesh mesh;
    nsdf_encoder_error error;
    float bar[3 * GLTF_VERTICES];
    gltf_bar_positions(bar);
    assert_int_equal(nsdf_sequence_load(sequence, frame, &mesh, &error), NSDF_OK);
    assert_int_equal(mesh.vertex_count, GLTF_VERTICES);
    assert_int_equal(mesh.triangle_count, GLTF_TRIANGLES);
    for (int i = 0; i < GLTF_VERTICES; i++) {
        double p[3] = {(double)bar[3 * i], (double)bar[3 * i + 1], (double)bar[3 * i + 2]};
        move(seconds, p);
        for (int k = 0; k < 3; k++)
            assert_float_equal(mesh.positions[3 * i + k], p[k], 2e-6);
    }
}

/* All frames of a kind, in one second at 20 frames a second. */
static void assert_motion(const char *kind, motion move) {
    nsdf_sequence *sequence = open_kind(kind, 20);
    assert_int_equal(nsdf_sequence_frame_count(sequence), 21);
    assert_int_equal(nsdf_sequence_mesh_count(sequence), 21);
    assert_string_equal(nsdf_sequence_note(sequence), "");
    for (uint32_t frame = 21; frame-- > 0;)
        assert_frame(sequence, frame, frame / 20.0, move);
    nsdf_sequence_close(&sequence);
}

static void stand(double seconds, double p[3]) {
    (void)seconds;
    (void)p;
}

static void move_in_a_line(double seconds, double p[3]) {
    p[0] += 2 * seconds;
    p[1] += 4 * seconds;
}

static void turn_about_z(double seconds, double p[3]) {
    const double angle = 0.5 * 3.14159265358979323846 * seconds, x = p[0] + 3;
    p[0] = x * cos(angle) - p[1] * sin(angle);
    p[1] = x * sin(angle) + p[1] * cos(angle);
}

static void move_in_a_curve(double seconds, double p[3]) {
    const double t = seconds;
    p[0] += 3 * t * t - 2 * t * t * t;
    p[1] += 3 * (t * t * t - 2 * t * t + t);
}

/* Rings of y = 0, 1, 2 follow the upper bone by 0, 1/2, 1; it turns about (0, 1). */
static void bend_at_the_joint(double seconds, double p[3]) {
    const double angle = 0.5 * 3.14159265358979323846 * seconds, share = 0.5 * p[1], y = p[1] - 1;
    const double x = p[0] * cos(angle) - y * sin(angle), up = p[0] * sin(angle) + y * cos(angle) + 1;
    p[0] = (1 - share) * p[0] + share * x;
    p[1] = (1 - share) * p[1] + share * up;
}

static void lift_the_top(double seconds, double p[3]) {
    p[1] += p[1] > 1.5 ? seconds : 0.0;
    p[2] += 0.5;
}

static void nodes_skins_and_targets_move(void **state) {
    (void)state;
    assert_motion("moving", move_in_a_line);
    assert_motion("turning", turn_about_z);
    assert_motion("cubic", move_in_a_curve);
    assert_motion("skinned", bend_at_the_joint);
    assert_motion("morphed", lift_the_top);
}

static void rates_are_those_of_the_keys(void **state) {
    uint32_t num, den;
    (void)state;
    nsdf_sequence *sequence = open_kind("moving", 0);
    nsdf_sequence_rate(sequence, &num, &den);
    assert_true(num == 25 && den == 1);
    assert_int_equal(nsdf_sequence_frame_count(sequence), 26);
    nsdf_sequence_close(&sequence);
    sequence = open_kind("late", 0); /* keys every 1/24 s, the first of them time 0 */
    nsdf_sequence_rate(sequence, &num, &den);
    assert_true(num == 24 && den == 1);
    assert_int_equal(nsdf_sequence_frame_count(sequence), 25);
    assert_frame(sequence, 0, 0.0, move_in_a_line);
    assert_frame(sequence, 12, 0.5, move_in_a_line);
    assert_frame(sequence, 24, 1.0, move_in_a_line);
    nsdf_sequence_close(&sequence);
    sequence = open_kind("late", 30);
    assert_string_equal(nsdf_sequence_note(sequence),
                        "keys of its animation lie between the frames; with --fps 24 all are frames");
    assert_int_equal(nsdf_sequence_frame_count(sequence), 31);
    nsdf_sequence_close(&sequence);
}

static void move_in_steps(double seconds, double p[3]) {
    p[0] += 10 * seconds;
}

static void stand_aside(double seconds, double p[3]) {
    (void)seconds;
    p[0] += 5;
}

static void steps_end_where_the_last_is_held_to(void **state) {
    uint32_t num, den;
    (void)state;
    nsdf_sequence *sequence = open_kind("steps", 0);
    nsdf_sequence_rate(sequence, &num, &den);
    assert_true(num == 10 && den == 1);
    assert_int_equal(nsdf_sequence_frame_count(sequence), 4);
    for (uint32_t i = 0; i < 4; i++)
        assert_frame(sequence, i, i / 10.0, move_in_steps);
    nsdf_sequence_close(&sequence);
    sequence = open_kind("hiding", 0);
    assert_int_equal(nsdf_sequence_frame_count(sequence), 2);
    assert_frame(sequence, 0, 0.0, stand);
    assert_frame(sequence, 1, 0.5, stand_aside);
    nsdf_sequence_close(&sequence);
}

static void files_without_animation_are_one_frame(void **state) {
    char name[64];
    (void)state;
    nsdf_sequence *sequence = open_kind("still", 0);
    assert_int_equal(nsdf_sequence_frame_count(sequence), 1);
    assert_frame(sequence, 0, 0.0, stand);
    nsdf_sequence_name_frame(sequence, 0, name, sizeof name);
    assert_string_equal(name, path);
    nsdf_sequence_close(&sequence);
}

static void frames_are_named_by_number(void **state) {
    char name[64], missing[8];
    nsdf_input_mesh mesh;
    nsdf_encoder_error error;
    (void)state;
    nsdf_sequence *sequence = open_kind("two", 25);
    assert_string_equal(nsdf_sequence_note(sequence), "it has 2 animations; the first, 'rise', is read");
    nsdf_sequence_name_frame(sequence, 7, name, sizeof name);
    assert_string_equal(name, "test_gltf_animation.glb, frame 7");
    assert_string_equal(nsdf_sequence_frame_path(sequence, 25), path);
    assert_null(nsdf_sequence_frame_path(sequence, 26));
    nsdf_sequence_name_frame(sequence, 26, name, sizeof name);
    assert_string_equal(name, "");
    assert_int_equal(nsdf_sequence_missing(sequence, missing, sizeof missing), 0);
    assert_int_equal(nsdf_sequence_load(sequence, 26, &mesh, &error), NSDF_INVALID_ARGUMENT);
    nsdf_sequence_close(&sequence);
}

/* Replaces the one place of a text in a file by another of the same length. */
static void assert_patched(const char *kind, const char *from, const char *to, nsdf_status wanted,
                           const char *message) {
    nsdf_sequence *sequence = NULL;
    nsdf_encoder_error error = {NSDF_OK, ""};
    unsigned char *bytes = NULL;
    size_t at = 0;
    const size_t size = gltf_make(kind, &bytes), length = strlen(from);
    assert_int_equal(length, strlen(to));
    while (at + length < size && memcmp(bytes + at, from, length) != 0)
        at++;
    assert_true(at + length < size);
    memcpy(bytes + at, to, length);
    const nsdf_status status = open_bytes(bytes, size, 0, &sequence, &error);
    free(bytes);
    nsdf_input_mesh mesh;
    if (status == NSDF_OK)
        assert_int_equal(nsdf_sequence_load(sequence, 1, &mesh, &error), wanted);
    else
        assert_int_equal(status, wanted);
    if (wanted != NSDF_OK && !strstr(error.message, message))
        fail_msg("'%s' is not in '%s'", message, error.message);
    if (wanted == NSDF_OK)
        assert_string_equal(nsdf_sequence_note(sequence), message);
    nsdf_sequence_close(&sequence);
}

static void what_cannot_be_read_is_said(void **state) {
    (void)state;
    assert_patched("moving", "\"translation\"}", "\"visibility_\"}", NSDF_INVALID_ARGUMENT, "there is no frame 1");
    assert_patched("two", "\"translation\"}", "\"visibility_\"}", NSDF_OK,
                   "the animation of 'visibility_' is left out");
    assert_patched("moving", "\"LINEAR\"", "\"CURVED\"", NSDF_CORRUPT, "keys cannot be read");
    assert_patched("moving", "\"sampler\":0", "\"sampler\":7", NSDF_CORRUPT, "not there");
    assert_patched("turning", "\"node\":0", "\"node\":9", NSDF_CORRUPT, "not there");
    assert_patched("turning", "\"children\":[1]", "\"children\":[0]", NSDF_CORRUPT, "in a circle");
    assert_patched("skinned", "\"joints\":[1,2]", "\"joints\":[1,9]", NSDF_CORRUPT, "a skin whose joints");
    assert_patched("skinned", "\"joints\":[1,2]", "\"joints\":[1]  ", NSDF_CORRUPT, "a skin whose joints");
    assert_patched("morphed", "{\"count\":4,", "{\"count\":9,", NSDF_CORRUPT, "morph targets");
}

/* No truncated or damaged file does harm; sanitizers watch. */
static void damaged_files_do_no_harm(void **state) {
    (void)state;
    for (size_t kind = 0; kind < sizeof gltf_kinds / sizeof *gltf_kinds; kind++) {
        unsigned char *bytes = NULL;
        const size_t size = gltf_make(gltf_kinds[kind], &bytes);
        uint32_t random = 1;
        for (int round = 0; round < 300; round++) {
            nsdf_sequence *sequence = NULL;
            nsdf_encoder_error error;
            nsdf_input_mesh mesh;
            random = random * 1664525u + 1013904223u;
            const size_t at = 20 + (random >> 8) % (size - 20);
            const unsigned char kept = bytes[at];
            bytes[at] = (unsigned char)(at < size - 400 ? '0' + (random >> 4) % 10 : random >> 24);
            if (open_bytes(bytes, size, 25, &sequence, &error) == NSDF_OK)
                for (uint32_t i = 0; i < 3; i++)
                    (void)!nsdf_sequence_load(sequence, i, &mesh, &error);
            nsdf_sequence_close(&sequence);
            bytes[at] = kept;
        }
        free(bytes);
    }
}

static int remove_file(void **state) {
    (void)state;
    return remove(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nodes_skins_and_targets_move),
        cmocka_unit_test(rates_are_those_of_the_keys),
        cmocka_unit_test(steps_end_where_the_last_is_held_to),
        cmocka_unit_test(files_without_animation_are_one_frame),
        cmocka_unit_test(frames_are_named_by_number),
        cmocka_unit_test(what_cannot_be_read_is_said),
        cmocka_unit_test(damaged_files_do_no_harm),
    };
    return cmocka_run_group_tests(tests, NULL, remove_file);
}
