#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>
#include <math.h>

#include "spline.h"

/* Value at u of the spline through `control`, summed in double. */
static double value_at(double u, uint32_t knots, const double *control) {
    float weight[4];
    uint32_t first = nsdf_spline_weights(u, knots, weight);
    double sum = 0.0;
    for (uint32_t k = 0; k < 4; k++)
        sum += (double)weight[k] * control[first + k];
    return sum;
}

static void weights_sum_to_one_and_stay_inside(void **state) {
    (void)state;
    for (uint32_t knots = 4; knots <= 40; knots++)
        for (int i = -2; i <= 1002; i++) {
            float w[4];
            uint32_t first = nsdf_spline_weights(i / 1000.0, knots, w);
            assert_true(first + 3 < knots);
            double sum = (double)w[0] + (double)w[1] + (double)w[2] + (double)w[3];
            assert_true(fabs(sum - 1.0) < 2e-7);
            assert_true(w[0] >= 0.0f && w[1] >= 0.0f && w[2] >= 0.0f && w[3] >= 0.0f);
        }
}

static void weights_at_a_knot_are_one_four_one(void **state) {
    (void)state;
    float w[4];
    for (uint32_t knot = 0; knot < 5; knot++) {
        assert_int_equal(nsdf_spline_weights(knot / 5.0, 8, w), knot);
        assert_true(fabsf(w[0] - 1.0f / 6) < 1e-6f && fabsf(w[1] - 4.0f / 6) < 1e-6f && fabsf(w[2] - 1.0f / 6) < 1e-6f);
        assert_true(fabsf(w[3]) < 1e-6f);
    }
    assert_int_equal(nsdf_spline_weights(1.0, 8, w), 4);
    assert_true(w[0] == 0.0f && w[3] == (float)(1.0 / 6.0));
}

static void times_outside_are_clamped(void **state) {
    (void)state;
    float a[4], b[4];
    assert_int_equal(nsdf_spline_weights(-3.0, 9, a), nsdf_spline_weights(0.0, 9, b));
    assert_true(a[0] == b[0] && a[3] == b[3]);
    assert_int_equal(nsdf_spline_weights(7.0, 9, a), nsdf_spline_weights(1.0, 9, b));
    assert_true(a[0] == b[0] && a[3] == b[3]);
}

/* Uniform cubic B-splines reproduce straight lines: control points k give s + 1 at s spans. */
static void straight_lines_are_reproduced(void **state) {
    (void)state;
    const double control[7] = {0, 1, 2, 3, 4, 5, 6};
    for (int i = 0; i <= 200; i++)
        assert_true(fabs(value_at(i / 200.0, 7, control) - (4.0 * i / 200.0 + 1.0)) < 2e-6);
}

/* One-sided differences of value, slope and curvature at every inner knot; float weights limit the step. */
static void value_slope_and_curvature_are_continuous(void **state) {
    (void)state;
    const double control[8] = {1.0, -2.0, 0.5, 3.0, -1.0, 2.0, 2.5, -0.5};
    const double h = 0.02 / 5.0;
    for (int knot = 1; knot < 5; knot++) {
        double u = knot / 5.0, f[7];
        for (int i = 0; i < 7; i++)
            f[i] = value_at(u + h * (i - 3), 8, control);
        double step = h * 5.0; /* in spans */
        double slope_left = (3.0 * f[3] - 4.0 * f[2] + f[1]) / (2.0 * step);
        double slope_right = (-3.0 * f[3] + 4.0 * f[4] - f[5]) / (2.0 * step);
        double bend_left = (2.0 * f[3] - 5.0 * f[2] + 4.0 * f[1] - f[0]) / (step * step);
        double bend_right = (2.0 * f[3] - 5.0 * f[4] + 4.0 * f[5] - f[6]) / (step * step);
        double expected_bend = control[knot] - 2.0 * control[knot + 1] + control[knot + 2];
        assert_true(fabs(slope_left - slope_right) < 0.02);
        assert_true(fabs(bend_left - expected_bend) < 0.02 && fabs(bend_right - expected_bend) < 0.02);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(weights_sum_to_one_and_stay_inside),
        cmocka_unit_test(weights_at_a_knot_are_one_four_one),
        cmocka_unit_test(times_outside_are_clamped),
        cmocka_unit_test(straight_lines_are_reproduced),
        cmocka_unit_test(value_slope_and_curvature_are_continuous),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
