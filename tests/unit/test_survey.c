/* Where sequences are cut, and parts that are fitted apart and joined. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "encode_samples.h"
#include "random.h"
#include "nsdf/mux.h"
#include "nsdf/survey.h"

/* A tetrahedron at x, with `extra` vertices that no face uses, so that V - F / 2 differs. */
static nsdf_status add_tetrahedron(nsdf_survey *survey, uint32_t frame, double x, uint32_t extra) {
    static const uint32_t indices[] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    double positions[3 * 8] = {x, 0, 0, x + 1, 0, 0, x, 1, 0, x, 0, 1};
    const nsdf_input_mesh mesh = {positions, indices, 4 + extra, 4};
    nsdf_encoder_error error;
    return nsdf_survey_add(survey, frame, &mesh, &error);
}

static nsdf_survey *new_survey(void) {
    nsdf_survey *survey = NULL;
    nsdf_encoder_error error;
    assert_int_equal(nsdf_survey_create(&survey, &error), NSDF_OK);
    return survey;
}

static const nsdf_span *plan(nsdf_survey *survey, uint32_t most, uint32_t *count) {
    nsdf_plan_options options;
    nsdf_encoder_error error;
    const nsdf_span *spans;
    nsdf_plan_options_init(&options);
    options.most_frames = most;
    assert_int_equal(nsdf_survey_plan(survey, &options, &spans, count, &error), NSDF_OK);
    return spans;
}

/* For every length and limit: all frames, in order, the cut frame shared, none too long, as few as can be, and overlaps
 * that leave every cross-fade its own frames. */
static void test_plans_cover_all_frames_within_the_limit(void **state) {
    (void)state;
    for (uint32_t frames = 1; frames <= 60; frames++) {
        nsdf_survey *survey = new_survey();
        nsdf_random random = nsdf_random_start(frames, 1);
        for (uint32_t i = 0; i < frames; i++)
            assert_int_equal(add_tetrahedron(survey, 2 * i, (double)(nsdf_random_u32(&random) % 100), i / 7 % 2),
                             NSDF_OK);
        for (uint32_t most = 2; most <= frames + 1; most++) {
            uint32_t count;
            const nsdf_span *s = plan(survey, most, &count);
            assert_int_equal(count, frames < 2 ? 1 : (frames - 1 + most - 2) / (most - 1));
            assert_true(s[0].first == 0 && s[0].lead == 0);
            assert_true(s[count - 1].last == frames - 1 && s[count - 1].trail == 0);
            for (uint32_t i = 0; i < count; i++) {
                assert_true(s[i].last - s[i].first + 1 <= most && (s[i].last > s[i].first || frames == 1));
                assert_true(i == 0 || (s[i].first == s[i - 1].last && s[i].lead == s[i - 1].trail));
                assert_true(s[i].lead + s[i].trail <= s[i].last - s[i].first && s[i].lead <= 2);
            }
        }
        nsdf_survey_close(&survey);
    }
}

static void test_cuts_lie_where_the_surface_moves_as_usual_or_changes_its_topology(void **state) {
    uint32_t count;
    (void)state;
    nsdf_survey *survey = new_survey();
    double x = 0.0;
    for (uint32_t i = 0; i <= 40; i++) {
        x += i <= 14 ? 0.1 : i <= 23 ? 0.0 : i <= 27 ? 1.0 : 3.0; /* creeps, rests, moves as on average, runs */
        assert_int_equal(add_tetrahedron(survey, i, x, 0), NSDF_OK);
    }
    const nsdf_span *s = plan(survey, 31, &count);
    assert_int_equal(count, 2);
    assert_true(s[0].last >= 23 && s[0].last <= 27);
    nsdf_survey_close(&survey);

    survey = new_survey();
    for (uint32_t i = 0; i <= 40; i++)
        assert_int_equal(add_tetrahedron(survey, i, i, i >= 17), NSDF_OK);
    s = plan(survey, 31, &count);
    assert_int_equal(count, 2);
    assert_int_equal(s[0].last, 17);
    nsdf_survey_close(&survey);
}

static void test_surveys_tell_box_and_changes_of_frames(void **state) {
    double low[3], high[3];
    (void)state;
    nsdf_survey *a = new_survey(), *b = new_survey();
    nsdf_encoder_error error;
    assert_int_equal(nsdf_survey_box(a, low, high), NSDF_INVALID_ARGUMENT);
    for (uint32_t i = 0; i < 4; i++) {
        assert_int_equal(add_tetrahedron(a, i, i, 0), NSDF_OK);
        assert_int_equal(add_tetrahedron(b, i, i == 2 ? 2.5 : i, 0), NSDF_OK);
    }
    assert_int_equal(nsdf_survey_box(a, low, high), NSDF_OK);
    assert_true(low[0] == 0.0 && high[0] == 4.0 && low[1] == 0.0 && high[1] == 1.0);
    assert_true(nsdf_survey_hash(a, 0, 2) == nsdf_survey_hash(b, 0, 2));
    assert_true(nsdf_survey_hash(a, 0, 2) != nsdf_survey_hash(a, 1, 2));
    assert_true(nsdf_survey_hash(a, 2, 1) != nsdf_survey_hash(b, 2, 1));
    nsdf_encoder_options options = hasty_options(), other = options;
    const nsdf_span span = {0, 1, 0, 1}, shorter = {0, 1, 0, 0};
    const uint64_t hash = nsdf_survey_span_hash(a, &span, &options);
    assert_true(hash != nsdf_survey_span_hash(b, &span, &options)); /* frame 2 is its trail */
    assert_true(hash != nsdf_survey_span_hash(a, &shorter, &options));
    other.threads = options.threads + 1;
    assert_true(hash == nsdf_survey_span_hash(a, &span, &other));
    other.seed = options.seed + 1;
    assert_true(hash != nsdf_survey_span_hash(a, &span, &other));
    assert_int_equal(add_tetrahedron(a, 3, 0, 0), NSDF_INVALID_ARGUMENT); /* numbers ascend */
    double nan[9] = {0, 0, 0, 1, 0, NAN, 0, 1, 0};
    const uint32_t indices[3] = {0, 1, 2};
    const nsdf_input_mesh bad = {nan, indices, 3, 1};
    assert_int_equal(nsdf_survey_add(a, 9, &bad, &error), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_survey_frame_count(a), 4);
    nsdf_survey_close(&a);
    nsdf_survey_close(&b);
}

/* ---- Parts -------------------------------------------------------------------------------------------------- */

/* A box at frames 3 to 12 that moves along x. */
static int moving_box(uint32_t i, nsdf_surface *surface, uint32_t *number) {
    if (i >= 10)
        return 0;
    *surface = shape_cube(0.5);
    for (size_t k = 0; k < 24; k += 3)
        surface->positions[k] += 0.1f * (float)i;
    *number = 3 + i;
    return 1;
}

static nsdf_encoder *new_encoder(void) {
    const nsdf_encoder_options o = hasty_options();
    nsdf_encoder *encoder = NULL;
    nsdf_encoder_error error;
    assert_int_equal(nsdf_encoder_create(&encoder, &o, &error), NSDF_OK);
    assert_int_equal(add_frames(encoder, moving_box, &error), NSDF_OK);
    return encoder;
}

static void test_a_part_has_its_own_frames_and_the_sequence_s_box(void **state) {
    const nsdf_sequence_part part = {2, 3, {-9, -9, -9}, {9, 9, 9}};
    encoded e = {.data = NULL};
    nsdf_info info;
    (void)state;
    nsdf_encoder *encoder = new_encoder();
    assert_int_equal(nsdf_encoder_set_part(encoder, &part, &e.error), NSDF_OK);
    assert_int_equal(nsdf_encoder_run(encoder, NULL, NULL, &e.error), NSDF_OK);
    assert_int_equal(nsdf_encoder_write(encoder, append_bytes, &e, &e.error), NSDF_OK);
    assert_int_equal(nsdf_encoder_get_stats(encoder, &e.stats), NSDF_OK);
    assert_true(e.stats.frames == 5 && e.stats.nominal_frames == 5);
    nsdf_decoder *decoder = open_file(&e);
    assert_int_equal(nsdf_get_info(decoder, &info), NSDF_OK);
    assert_int_equal(info.frame_count, 5);
    assert_true(info.box_min[1] == -9.0 && info.box_max[2] == 9.0);
    nsdf_close(&decoder);

    /* What lies beyond the ends is there to join with. */
    nsdf_mux *a = NULL, *b = NULL;
    assert_int_equal(nsdf_mux_open(&a, e.data, e.size, &e.error), NSDF_OK);
    assert_int_equal(nsdf_mux_open(&b, e.data, e.size, &e.error), NSDF_OK);
    assert_int_equal(nsdf_mux_append(a, b, 3, &e.error), NSDF_INVALID_ARGUMENT); /* more than the lead */
    assert_int_equal(nsdf_mux_append(a, b, 2, &e.error), NSDF_OK);
    assert_int_equal(nsdf_mux_frame_count(a), 9);
    nsdf_mux_close(&a);
    nsdf_mux_close(&b);
    nsdf_encoder_close(&encoder);
    free(e.data);
}

static void test_parts_that_cannot_be_are_refused(void **state) {
    nsdf_encoder_error error;
    const nsdf_sequence_part small = {0, 0, {-9, 0, -9}, {9, 0.01, 9}}, none = {5, 5, {-9, -9, -9}, {9, 9, 9}};
    const nsdf_sequence_part one = {5, 4, {-9, -9, -9}, {9, 9, 9}};
    (void)state;
    nsdf_encoder *encoder = new_encoder();
    assert_int_equal(nsdf_encoder_set_part(encoder, &small, &error), NSDF_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "along axis 1"));
    assert_int_equal(nsdf_encoder_set_part(encoder, &none, &error), NSDF_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "leave none of 10 frames"));
    assert_int_equal(nsdf_encoder_set_part(encoder, &one, &error), NSDF_OK);
    nsdf_encoder_close(&encoder);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_plans_cover_all_frames_within_the_limit),
        cmocka_unit_test(test_cuts_lie_where_the_surface_moves_as_usual_or_changes_its_topology),
        cmocka_unit_test(test_surveys_tell_box_and_changes_of_frames),
        cmocka_unit_test(test_a_part_has_its_own_frames_and_the_sequence_s_box),
        cmocka_unit_test(test_parts_that_cannot_be_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
