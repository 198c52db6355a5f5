/* The arithmetic of rate control, with sizes and errors from formulas. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>

#include "rate_control.h"

static nsdf_encoder_options fast(void) {
    nsdf_encoder_options o;
    nsdf_encoder_options_init(&o, NSDF_PRESET_FAST);
    return o;
}

/* ---- Levels ----------------------------------------------------------------------------------------------- */

static void test_level_0_is_the_options_given(void **state) {
    const nsdf_encoder_options base = fast(), o = nsdf_rate_options_at(&base, 0.0);
    (void)state;
    assert_int_equal(o.blocks, base.blocks);
    assert_int_equal(o.bones, base.bones);
    assert_true(o.pose_step == base.pose_step && o.coefficient_step == base.coefficient_step);
    assert_true(o.motion_rate == base.motion_rate);
}

static void test_higher_levels_are_predicted_larger(void **state) {
    const nsdf_encoder_options base = fast();
    const nsdf_rate_measure m = nsdf_rate_first_guess(&base, 175);
    double before = 0.0;
    (void)state;
    for (double level = nsdf_rate_lowest_level; level <= nsdf_rate_highest_level; level += 0.1) {
        const nsdf_encoder_options o = nsdf_rate_options_at(&base, level);
        const double bytes = nsdf_rate_predict(&m, &o);
        assert_true(bytes > before && o.bones >= 2 && o.blocks >= 24);
        before = bytes;
    }
}

static void test_a_level_for_bytes_is_predicted_to_have_them(void **state) {
    const nsdf_encoder_options base = fast();
    const nsdf_rate_measure m = nsdf_rate_first_guess(&base, 175);
    (void)state;
    for (double bytes = 8000.0; bytes < 120000.0; bytes *= 1.3) {
        const nsdf_encoder_options o = nsdf_rate_options_at(&base, nsdf_rate_level_for(&m, &base, bytes));
        assert_true(fabs(nsdf_rate_predict(&m, &o) / bytes - 1.0) < 0.03);
    }
}

/* ---- Levels and errors ------------------------------------------------------------------------------------ */

static nsdf_rate_curve curve_of(const double (*fits)[2], uint32_t count) {
    nsdf_rate_curve c = {{0.0}, {0.0}, 0};
    for (uint32_t i = 0; i < count; i++)
        nsdf_rate_curve_add(&c, fits[i][0], fits[i][1]);
    return c;
}

static void test_one_fit_tells_which_way_to_go(void **state) {
    const double fits[][2] = {{-0.5, 4e-4}};
    const nsdf_rate_curve c = curve_of(fits, 1);
    (void)state;
    assert_true(nsdf_rate_curve_level(&c, 3e-4) > -0.5 && nsdf_rate_curve_level(&c, 5e-4) < -0.5);
    assert_true(fabs(nsdf_rate_curve_level(&c, 4e-4) + 0.5) < 1e-9);
    assert_true(fabs(nsdf_rate_curve_level(&c, 1e-6) - 1.0) < 1e-9); /* 1.5 finer */
    assert_true(fabs(nsdf_rate_curve_level(&c, 10.0) + 3.0) < 1e-9); /* 2.5 coarser */
}

/* Whatever order fits come in, lines through their logarithms are found both ways. */
static void test_levels_and_errors_of_a_curve_are_inverses(void **state) {
    const double fits[][2] = {{-1.0, 8e-4}, {0.5, 3e-4}, {-2.0, 3e-3}, {1.2, 2e-4}};
    const nsdf_rate_curve c = curve_of(fits, 4);
    (void)state;
    assert_int_equal(c.count, 4);
    for (int i = 0; i < 4; i++)
        assert_true(fabs(nsdf_rate_curve_error(&c, fits[i][0]) / fits[i][1] - 1.0) < 1e-9);
    for (double level = -3.0; level < 2.0; level += 0.1)
        assert_true(fabs(nsdf_rate_curve_level(&c, nsdf_rate_curve_error(&c, level)) - level) < 1e-6);
    assert_true(fabs(nsdf_rate_curve_error(&c, -1.5) - sqrt(8e-4 * 3e-3)) < 1e-9);
}

/* A coarser fit that is better by chance is the one to take, and no slope runs backwards. */
static void test_errors_that_scatter_do_not_turn_levels_round(void **state) {
    const double fits[][2] = {{-1.0, 3e-4}, {0.0, 3.5e-4}};
    const nsdf_rate_curve c = curve_of(fits, 2);
    (void)state;
    assert_true(nsdf_rate_curve_level(&c, 3.2e-4) < -1.0 && nsdf_rate_curve_level(&c, 3.2e-4) > -2.0);
    assert_true(nsdf_rate_curve_level(&c, 2.5e-4) > 0.0);
    assert_true(nsdf_rate_curve_error(&c, 1.0) < 3.5e-4);
}

static void test_a_curve_keeps_what_is_near(void **state) {
    nsdf_rate_curve c = {{0.0}, {0.0}, 0};
    (void)state;
    assert_true(isinf(nsdf_rate_curve_distance(&c, 0.0)));
    for (int i = 0; i < 2 * NSDF_RATE_MOST_FITS; i++)
        nsdf_rate_curve_add(&c, 0.25 * i, 1e-3);
    nsdf_rate_curve_add(&c, 0.25 * (2 * NSDF_RATE_MOST_FITS - 1), 2e-3); /* again */
    assert_int_equal(c.count, NSDF_RATE_MOST_FITS);
    assert_true(c.error[NSDF_RATE_MOST_FITS - 1] == 2e-3 && c.error[0] == 1e-3);
    for (int i = 1; i < NSDF_RATE_MOST_FITS; i++)
        assert_true(c.level[i] > c.level[i - 1]);
    assert_true(fabs(nsdf_rate_curve_distance(&c, c.level[2] + 0.1) - 0.1) < 1e-9);
}

/* ---- Sizes ------------------------------------------------------------------------------------------------ */

/* Falls with x, but for noise that is the same whenever x is. */
typedef struct {
    double base, slope, noise, floor;
    int calls;
} formula;

static int formula_size(void *user, double x, uint64_t *bytes) {
    formula *f = user;
    const double jump = (double)((uint64_t)(fabs(x) * 1e6) * 2654435761u % 1000u) / 1000.0 - 0.5;
    f->calls++;
    *bytes = (uint64_t)(f->floor + f->base * exp(-f->slope * x) * (1.0 + f->noise * jump));
    return 0;
}

static void check_search(formula f, uint64_t most) {
    const nsdf_rate_search search = {formula_size, &f, most, -8.0, 8.0};
    double x = 0.0;
    uint64_t bytes = 0, there = 0;
    assert_int_equal(nsdf_rate_find(&search, &x, &bytes), 0);
    assert_true(nsdf_rate_size_met(bytes, most) && f.calls < 30);
    assert_int_equal(formula_size(&f, x, &there), 0);
    assert_int_equal(there, bytes);
}

static void test_sizes_are_found_from_above_and_below(void **state) {
    (void)state;
    for (double slope = 0.1; slope < 1.2; slope *= 1.6)
        for (double factor = 0.5; factor < 2.2; factor *= 1.17) {
            check_search((formula){40000.0, slope, 0.0, 700.0, 0}, (uint64_t)(40000.0 * factor));
            check_search((formula){40000.0, slope, 0.01, 700.0, 0}, (uint64_t)(40000.0 * factor));
        }
}

static void test_sizes_below_the_floor_are_not_found(void **state) {
    formula f = {40000.0, 0.5, 0.0, 5000.0, 0};
    const nsdf_rate_search search = {formula_size, &f, 5100, -2.0, 2.0};
    double x = 0.0;
    uint64_t bytes = 0;
    (void)state;
    assert_int_equal(nsdf_rate_find(&search, &x, &bytes), 1);
    assert_true(bytes > 5100 && f.calls < 30);
}

static void test_the_largest_there_is_counts_when_all_are_small(void **state) {
    formula f = {4000.0, 0.5, 0.0, 0.0, 0};
    const nsdf_rate_search search = {formula_size, &f, 100000, -2.0, 2.0};
    double x = 0.0;
    uint64_t bytes = 0;
    (void)state;
    assert_int_equal(nsdf_rate_find(&search, &x, &bytes), 0);
    assert_true(x == -2.0 && bytes == (uint64_t)(4000.0 * exp(1.0)));
    assert_false(nsdf_rate_size_met(bytes, 100000));
}

static int broken_size(void *user, double x, uint64_t *bytes) {
    (void)user;
    (void)x;
    *bytes = 0;
    return -1;
}

static void test_failures_are_passed_on(void **state) {
    const nsdf_rate_search search = {broken_size, NULL, 1000, -1.0, 1.0};
    double x = 0.0;
    uint64_t bytes;
    (void)state;
    assert_int_equal(nsdf_rate_find(&search, &x, &bytes), -1);
}

static void test_what_is_promised_of_sizes(void **state) {
    (void)state;
    assert_true(nsdf_rate_size_met(1000, 1000) && nsdf_rate_size_met(970, 1000));
    assert_false(nsdf_rate_size_met(1001, 1000) || nsdf_rate_size_met(969, 1000));
}

/* Bytes follow x only in part at once, and shrink by themselves while fitting goes on. */
static void test_steering_arrives(void **state) {
    const uint64_t wanted = 30000;
    (void)state;
    for (double start = 15000.0; start < 61000.0; start *= 1.3) {
        double x = 0.0, slow = 0.0;
        uint64_t bytes = 0;
        for (int i = 0; i < 15; i++) {
            slow += 0.3 * (x - slow);
            bytes = (uint64_t)(start * (1.0 + 0.2 * exp(-0.3 * i)) * exp(-0.35 * x - 0.1 * slow));
            x = nsdf_rate_steer(x, bytes, wanted);
        }
        assert_true(fabs((double)bytes / (double)wanted - 1.0) < 0.03);
    }
}

/* ---- Errors ----------------------------------------------------------------------------------------------- */

static void test_secants_arrive_at_an_error(void **state) {
    (void)state;
    for (double slope = 0.15; slope < 0.9; slope *= 1.5)
        for (double wanted = 3.2e-4; wanted < 5.5e-4; wanted *= 1.1) {
            nsdf_rate_trials trials = {{0.0}, {0.0}, 0};
            double x = 0.0, error = 0.0;
            for (int i = 0; i < 7; i++) {
                error = 4e-4 * exp(slope * x);
                nsdf_rate_tried(&trials, x, error);
                x = nsdf_rate_next(&trials, wanted);
            }
            assert_true(fabs(error / wanted - 1.0) < 0.03);
        }
}

static void test_noise_does_not_turn_a_secant_round(void **state) {
    nsdf_rate_trials trials = {{0.0}, {0.0}, 0};
    (void)state;
    nsdf_rate_tried(&trials, 0.0, 4e-4);
    nsdf_rate_tried(&trials, 0.1, 3.98e-4); /* coarser, and better by chance */
    const double x = nsdf_rate_next(&trials, 4.4e-4);
    assert_true(x > 0.1 && x < 1.0);
}

/* Between an x that had the error and one that had not, whatever the last two say. */
static void test_trials_stay_within_what_is_known(void **state) {
    nsdf_rate_trials trials = {{0.0}, {0.0}, 0};
    (void)state;
    nsdf_rate_tried(&trials, 0.0, 3e-4);
    nsdf_rate_tried(&trials, 1.0, 6e-4);
    nsdf_rate_tried(&trials, 0.9, 5.9e-4);
    double x = nsdf_rate_next(&trials, 4e-4);
    assert_true(x > 0.0 && x < 0.9);
    for (int i = 0; i < 2 * NSDF_RATE_MOST_TRIALS; i++)
        nsdf_rate_tried(&trials, 0.5, 3.9e-4);
    assert_int_equal(trials.count, NSDF_RATE_MOST_TRIALS);
    x = nsdf_rate_next(&trials, 4e-4);
    assert_true(x > 0.5 && x < 1.3); /* what was forgotten limits nothing */
}

/* Fitting on brings the error down: what failed at first holds nothing back that does not fail there later. */
static void test_trials_that_were_overtaken_limit_nothing(void **state) {
    nsdf_rate_trials trials = {{0.0}, {0.0}, 0};
    (void)state;
    nsdf_rate_tried(&trials, 0.3, 9.6e-4);
    nsdf_rate_tried(&trials, 0.2, 8.0e-4);
    double x = nsdf_rate_next(&trials, 9.5e-4);
    assert_true(x > 0.2 && x < 0.3);
    nsdf_rate_tried(&trials, 0.28, 7.7e-4);
    x = nsdf_rate_next(&trials, 9.5e-4);
    assert_true(x > 0.5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_level_0_is_the_options_given),
        cmocka_unit_test(test_higher_levels_are_predicted_larger),
        cmocka_unit_test(test_a_level_for_bytes_is_predicted_to_have_them),
        cmocka_unit_test(test_one_fit_tells_which_way_to_go),
        cmocka_unit_test(test_levels_and_errors_of_a_curve_are_inverses),
        cmocka_unit_test(test_errors_that_scatter_do_not_turn_levels_round),
        cmocka_unit_test(test_a_curve_keeps_what_is_near),
        cmocka_unit_test(test_sizes_are_found_from_above_and_below),
        cmocka_unit_test(test_sizes_below_the_floor_are_not_found),
        cmocka_unit_test(test_the_largest_there_is_counts_when_all_are_small),
        cmocka_unit_test(test_failures_are_passed_on),
        cmocka_unit_test(test_what_is_promised_of_sizes),
        cmocka_unit_test(test_steering_arrives),
        cmocka_unit_test(test_secants_arrive_at_an_error),
        cmocka_unit_test(test_noise_does_not_turn_a_secant_round),
        cmocka_unit_test(test_trials_stay_within_what_is_known),
        cmocka_unit_test(test_trials_that_were_overtaken_limit_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
