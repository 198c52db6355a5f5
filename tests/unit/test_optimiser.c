/* Adam and the schedule of its rate. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>

#include "optimiser.h"

static void test_first_step_is_the_rate_against_the_gradient(void **state) {
    static const float gradient[] = {1e-6f, -1e-6f, 3.0f, -1e5f, 0.0f};
    float parameters[] = {1.0f, 1.0f, 1.0f, 1.0f, 1.0f};
    nsdf_adam adam;
    (void)state;
    assert_int_equal(nsdf_adam_create(&adam, 5), 0);
    nsdf_adam_step(&adam, parameters, gradient, 0.125);
    /* epsilon takes 1 % off the steps for the two smallest gradients */
    assert_true(fabs((double)parameters[0] - 0.875) < 0.0013);
    assert_true(fabs((double)parameters[1] - 1.125) < 0.0013);
    assert_true(fabs((double)parameters[2] - 0.875) < 1e-6);
    assert_true(fabs((double)parameters[3] - 1.125) < 1e-6);
    assert_true(parameters[4] == 1.0f);
    assert_true(adam.step == 1);
    nsdf_adam_free(&adam);
}

/* Kingma & Ba 2015, algorithm 1, in double. */
static void test_steps_follow_the_paper(void **state) {
    nsdf_adam adam;
    (void)state;
    assert_int_equal(nsdf_adam_create(&adam, 1), 0);
    const double b1 = (double)adam.beta1, b2 = (double)adam.beta2;
    float parameter = 0.5f;
    double expected = 0.5, m = 0.0, v = 0.0;
    for (int t = 1; t <= 200; t++) {
        const float g = (float)sin(0.3 * t) * 1e-3f;
        m = b1 * m + (1.0 - b1) * (double)g;
        v = b2 * v + (1.0 - b2) * (double)g * (double)g;
        expected -= 1e-3 * (m / (1.0 - pow(b1, t))) / (sqrt(v / (1.0 - pow(b2, t))) + (double)adam.epsilon);
        nsdf_adam_step(&adam, &parameter, &g, 1e-3);
        assert_true(fabs((double)parameter - expected) < 1e-5);
    }
    nsdf_adam_free(&adam);
}

/* sum of c_i (x_i - i)^2 with curvatures six orders of magnitude apart. */
static void test_reaches_the_minimum_of_a_quadratic(void **state) {
    enum { COUNT = 7, STEPS = 4000 };
    float x[COUNT] = {5, -5, 5, -5, 5, -5, 5}, gradient[COUNT];
    nsdf_adam adam;
    (void)state;
    assert_int_equal(nsdf_adam_create(&adam, COUNT), 0);
    for (uint64_t step = 0; step < STEPS; step++) {
        for (int i = 0; i < COUNT; i++)
            gradient[i] = 2.0f * powf(10.0f, (float)(i - 3)) * (x[i] - (float)i);
        nsdf_adam_step(&adam, x, gradient, nsdf_rate_schedule(step, STEPS, 0.05));
    }
    for (int i = 0; i < COUNT; i++)
        assert_true(fabsf(x[i] - (float)i) < 0.02f);
    nsdf_adam_free(&adam);
}

static void test_rate_rises_for_a_hundredth_then_falls_to_a_hundredth(void **state) {
    enum { STEPS = 20000 };
    double before = 0.0;
    (void)state;
    for (uint64_t step = 0; step < STEPS; step++) {
        const double rate = nsdf_rate_schedule(step, STEPS, 3.0);
        assert_true(rate > 0.0 && rate <= 3.0 + 1e-12);
        if (step < STEPS / 100)
            assert_true(rate > before);
        else
            assert_true(rate < before + 1e-12);
        before = rate;
    }
    assert_true(fabs(nsdf_rate_schedule(0, STEPS, 3.0) - 3.0 / 200.0) < 1e-9);
    assert_true(fabs(nsdf_rate_schedule(99, STEPS, 3.0) - 1.5) < 1e-9);
    assert_true(fabs(nsdf_rate_schedule(199, STEPS, 3.0) - 3.0) < 1e-3);
    assert_true(fabs(nsdf_rate_schedule(10099, STEPS, 3.0) - 3.0 * 0.505) < 1e-3);
    assert_true(fabs(nsdf_rate_schedule(STEPS - 1, STEPS, 3.0) - 0.03) < 1e-5);
}

static void test_rate_of_short_runs_stays_in_range(void **state) {
    (void)state;
    for (uint64_t steps = 1; steps < 300; steps++)
        for (uint64_t step = 0; step < steps; step++) {
            const double rate = nsdf_rate_schedule(step, steps, 1.0);
            assert_true(rate >= 0.01 && rate <= 1.0);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_first_step_is_the_rate_against_the_gradient),
        cmocka_unit_test(test_steps_follow_the_paper),
        cmocka_unit_test(test_reaches_the_minimum_of_a_quadratic),
        cmocka_unit_test(test_rate_rises_for_a_hundredth_then_falls_to_a_hundredth),
        cmocka_unit_test(test_rate_of_short_runs_stays_in_range),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
