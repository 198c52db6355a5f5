/* Blocks of a given size or error, after verification. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "block_fixture.h"
#include "rate_blocks.h"

enum { SIZE = 3000, STEPS = 60 };

typedef struct {
    fixture x;
    fit_fixture f;
    nsdf_encoder_stats stats;
    nsdf_rate_blocks *rate;
    nsdf_block_model model;
    nsdf_fit_result result;
    nsdf_encoder_error error;
    nsdf_sample_set strays[SAMPLE_FRAMES];
} sized;

static void start_target(sized *s, uint64_t size, double error) {
    memset(s, 0, sizeof *s);
    s->x = two_balls(40, 4, 2);
    make_fit(&s->f, &s->x, STEPS);
    s->f.options.block_steps = STEPS;
    s->f.options.blocks = 40;
    s->f.options.bones = 4;
    s->f.options.block_degree = 2;
    s->f.options.target_size = size;
    s->f.options.target_error = error;
    s->f.options.verify = 1;
    const nsdf_rate_job job = {s->f.job, size, &s->x.frames, {0}, &s->stats};
    s->rate = nsdf_rate_blocks_create(&job);
    assert_non_null(s->rate);
    assert_int_equal(nsdf_rate_blocks_fit(s->rate, &s->model, &s->result, &s->error), NSDF_OK);
}

static void start_sized(sized *s) {
    start_target(s, SIZE, 0.0);
}

static void end_sized(sized *s) {
    for (int i = 0; i < SAMPLE_FRAMES; i++)
        nsdf_sample_set_free(&s->strays[i]);
    nsdf_rate_blocks_free(s->rate);
    nsdf_block_model_free(&s->model);
    free_fit(&s->f);
    free_fixture(&s->x);
}

/* A point away from both balls. */
static void put_stray(sized *s) {
    nsdf_sample_set *set = &s->strays[1];
    assert_int_equal(nsdf_sample_set_create(set, 1), 0);
    set->x[0] = set->z[0] = 0.0f;
    set->y[0] = 0.4f;
    nsdf_sdf *sdf = nsdf_frame_sdf(&s->x.frames.frames[1]);
    const float p[3] = {0.0f, 0.4f, 0.0f};
    set->d[0] = nsdf_sdf_distance(sdf, p);
    nsdf_sdf_free(sdf);
}

static int judge(sized *s, double to_decoded, double to_input) {
    const nsdf_quality quality = {.mean_to_decoded = to_decoded, .mean_to_input = to_input};
    int again = -1;
    assert_int_equal(nsdf_rate_blocks_judge(s->rate, &s->model, &s->result, &quality, s->strays, &again, &s->error),
                     NSDF_OK);
    return again;
}

static nsdf_rate_round last_round(const sized *s) {
    return s->stats.rounds[s->stats.round_count - 1];
}

static void test_surface_in_its_place_needs_nothing(void **state) {
    sized s;
    (void)state;
    start_sized(&s);
    assert_int_equal(judge(&s, 1e-3, 1.2e-3), 0);
    assert_int_equal(last_round(&s).kind, NSDF_RATE_VERIFY);
    end_sized(&s);
}

static void test_mending_keeps_the_size(void **state) {
    sized s;
    (void)state;
    start_sized(&s);
    const uint64_t steps = s.result.steps;
    put_stray(&s);
    assert_int_equal(judge(&s, 1e-3, 5e-3), 1);
    assert_null(s.strays[1].x); /* taken over */
    assert_int_equal(last_round(&s).kind, NSDF_RATE_QUANTISE);
    assert_in_range(last_round(&s).bytes, SIZE * 97 / 100, SIZE);
    assert_int_equal(s.result.steps, steps + STEPS / 4); /* 0.15 of them would be too few */
    assert_int_equal(judge(&s, 1e-3, 1e-3), 0);
    end_sized(&s);
}

static void test_what_mending_made_worse_comes_back(void **state) {
    sized s;
    nsdf_block_model before;
    (void)state;
    start_sized(&s);
    assert_int_equal(nsdf_block_model_copy(&before, &s.model), 0);
    const size_t bytes = before.value_count * sizeof *before.values;
    put_stray(&s);
    assert_int_equal(judge(&s, 1e-3, 5e-3), 1);
    assert_true(memcmp(s.model.values, before.values, bytes) != 0);
    assert_int_equal(judge(&s, 1e-3, 6e-3), 1);
    assert_memory_equal(s.model.values, before.values, bytes);
    assert_int_equal(judge(&s, 1e-3, 5e-3), 0);
    assert_memory_equal(s.model.values, before.values, bytes);
    nsdf_block_model_free(&before);
    end_sized(&s);
}

static void test_mending_ends(void **state) {
    sized s;
    (void)state;
    start_sized(&s);
    double back = 9e-3;
    int rounds = 0;
    while (judge(&s, 1e-3, back) && ++rounds < 9)
        back *= 0.9;
    assert_int_equal(rounds, 2);
    end_sized(&s);
}

static int count_rounds(const sized *s, nsdf_rate_kind kind) {
    int count = 0;
    for (uint32_t i = 0; i < s->stats.round_count; i++)
        count += s->stats.rounds[i].kind == kind;
    return count;
}

/* Some frames had the error, but all of them are so far from it that finer steps will not do. */
static void test_what_verification_refuses_is_fitted_anew_and_finer(void **state) {
    const double target = 0.02;
    sized s;
    (void)state;
    start_target(&s, 0, target);
    assert_int_equal(count_rounds(&s, NSDF_RATE_FIT), 1);
    assert_true(last_round(&s).error <= target);
    const uint32_t blocks = s.model.desc.block_count;
    assert_int_equal(judge(&s, 3.0 * target, 3.0 * target), 1);
    assert_true(count_rounds(&s, NSDF_RATE_FIT) > 1);
    assert_true(s.model.desc.block_count > blocks);
    end_sized(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_surface_in_its_place_needs_nothing),
        cmocka_unit_test(test_mending_keeps_the_size),
        cmocka_unit_test(test_what_mending_made_worse_comes_back),
        cmocka_unit_test(test_mending_ends),
        cmocka_unit_test(test_what_verification_refuses_is_fitted_anew_and_finer),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
