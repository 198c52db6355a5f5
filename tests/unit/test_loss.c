/* Losses: values, derivatives, and the limits that the thesis asks of the surface-sensitive one. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>

#include "loss.h"
#include "random.h"

static const nsdf_loss_params mae = {NSDF_LOSS_MAE, 0.02f, 0.01f, 200.0f, 1.0f};
static const nsdf_loss_params weighted = {NSDF_LOSS_WEIGHTED_MAE, 0.02f, 0.01f, 200.0f, 1.0f};
static const nsdf_loss_params sensitive = {NSDF_LOSS_SURFACE_SENSITIVE, 0.02f, 0.01f, 200.0f, 1.0f};

/* The losses from their definitions, in double. */
static double reference(const nsdf_loss_params *p, double f, double d) {
    const double s = (double)p->slope, delta = (double)p->delta, error = fabs(f - d);
    if (p->kind == NSDF_LOSS_WEIGHTED_MAE)
        return f * d < 0.0 ? error : error / (1.0 + fabs(d) / (double)p->d0);
    if (p->kind == NSDF_LOSS_MAE)
        return error;
    const double c1 = fabs(0.5 * (tanh(s * d) + tanh(s * f)));
    const double c2 = 0.5 * tanh(s * (fabs(d) - delta)) + 0.5;
    const double c3 = 0.5 * tanh(s * (fabs(f) - delta)) + 0.5;
    return (1.0 - c1 * c2 * c3) * error;
}

static float value(const nsdf_loss_params *p, float f, float d) {
    float derivative;
    return nsdf_loss_value(p, f, d, &derivative);
}

static float draw(nsdf_random *random, float range) {
    return range * (2.0f * nsdf_random_unit(random) - 1.0f);
}

/* Not near f = d, f = 0, f = -d, where the losses have kinks or jumps. */
static int smooth(float f, float d) {
    return fabsf(f - d) > 2e-4f && fabsf(f) > 2e-4f && fabsf(f + d) > 2e-4f;
}

static void check_loss(const nsdf_loss_params *p, float range, uint64_t seed) {
    nsdf_random random = nsdf_random_start(seed, 0);
    const double h = 1e-6;
    int tried = 0;
    for (int i = 0; i < 4000; i++) {
        const float f = draw(&random, range), d = draw(&random, range);
        float derivative = 99.0f;
        const float loss = nsdf_loss_value(p, f, d, &derivative);
        assert_true(fabs((double)loss - reference(p, (double)f, (double)d)) <= 2e-6 * (double)fabsf(f - d) + 1e-9);
        if (!smooth(f, d))
            continue;
        tried++;
        const double slope =
            (reference(p, (double)f + h, (double)d) - reference(p, (double)f - h, (double)d)) / (2.0 * h);
        assert_true(fabs((double)derivative - slope) <= 2e-4);
    }
    assert_true(tried > 3000);
}

static void test_values_and_derivatives_follow_the_definitions(void **state) {
    (void)state;
    check_loss(&mae, 0.05f, 1);
    check_loss(&weighted, 0.05f, 2);
    check_loss(&sensitive, 0.05f, 3);
    check_loss(&sensitive, 0.5f, 4);
}

static void test_every_loss_is_zero_at_the_true_distance(void **state) {
    const nsdf_loss_params *all[] = {&mae, &weighted, &sensitive};
    (void)state;
    for (int k = 0; k < 3; k++)
        for (int i = -20; i <= 20; i++)
            assert_true(value(all[k], 0.01f * (float)i, 0.01f * (float)i) == 0.0f);
}

static void test_weighted_loss_halves_at_d0(void **state) {
    (void)state;
    assert_true(fabsf(value(&weighted, 0.03f, 0.02f) - 0.005f) < 1e-8f);
    assert_true(fabsf(value(&weighted, -0.03f, -0.02f) - 0.005f) < 1e-8f);
    assert_true(fabsf(value(&weighted, 0.001f, 0.0f) - 0.001f) < 1e-9f);
}

static void test_wrong_signs_weigh_more_at_the_surface(void **state) {
    (void)state;
    nsdf_loss_params p = weighted;
    float derivative;
    p.sign = 4.0f;
    /* 1 + 3 / 2 where the weight of right signs is a half */
    assert_true(fabsf(nsdf_loss_value(&p, 0.01f, -0.02f, &derivative) - 0.075f) < 1e-7f && derivative == 2.5f);
    assert_true(fabsf(nsdf_loss_value(&p, -0.01f, 0.02f, &derivative) - 0.075f) < 1e-7f && derivative == -2.5f);
    assert_true(fabsf(value(&p, 1e-6f, -1e-6f) - 8e-6f) < 1e-8f);
    assert_true(fabsf(value(&p, -0.03f, -0.02f) - 0.005f) < 1e-8f);
}

static void test_weighted_loss_forgives_no_wrong_sign(void **state) {
    (void)state;
    assert_true(fabsf(value(&weighted, -0.1f, 0.3f) - 0.4f) < 1e-7f);
    assert_true(fabsf(value(&weighted, 0.1f, -0.3f) - 0.4f) < 1e-7f);
    assert_true(value(&weighted, 0.1f, 0.3f) < 0.02f);
}

/* Thesis 4.1: far from the surface on its right side nothing is penalised ... */
static void test_surface_sensitive_loss_vanishes_far_away_with_the_right_sign(void **state) {
    (void)state;
    for (int sign = -1; sign <= 1; sign += 2)
        for (int i = 5; i <= 40; i++)
            for (int j = 5; j <= 40; j++) {
                const float f = 0.01f * (float)(sign * i), d = 0.01f * (float)(sign * j);
                assert_true(value(&sensitive, f, d) <= 1e-5f * fabsf(f - d));
            }
}

/* ... and the whole error counts where the truth or the prediction is near the surface, or the sign is wrong. */
static void test_surface_sensitive_loss_is_the_error_near_the_surface(void **state) {
    (void)state;
    for (int i = -60; i <= 60; i++) {
        const float far = 0.005f * (float)i;
        assert_true(value(&sensitive, far, 0.0f) >= 0.98f * fabsf(far));
        assert_true(value(&sensitive, 0.0f, far) >= 0.98f * fabsf(far));
    }
}

static void test_surface_sensitive_loss_is_the_error_with_the_wrong_sign(void **state) {
    (void)state;
    for (int i = 5; i <= 60; i++)
        for (int j = 5; j <= 60; j++) {
            const float f = 0.005f * (float)i, d = -0.005f * (float)j;
            assert_true(value(&sensitive, f, d) >= 0.99f * (f - d));
            assert_true(value(&sensitive, -f, -d) >= 0.99f * (f - d));
        }
}

static void test_batch_gives_losses_their_sum_and_scaled_derivatives(void **state) {
    const nsdf_loss_params *all[] = {&mae, &weighted, &sensitive};
    nsdf_random random = nsdf_random_start(5, 0);
    float f[100], d[100], derivative[101], losses[101];
    (void)state;
    for (int i = 0; i < 100; i++) {
        f[i] = draw(&random, 0.1f);
        d[i] = draw(&random, 0.1f);
    }
    for (int k = 0; k < 3; k++) {
        double expected = 0.0;
        derivative[100] = losses[100] = 7.0f;
        const double sum = nsdf_loss_batch(all[k], f, d, 100, 0.25f, derivative, losses);
        for (int i = 0; i < 100; i++) {
            float one;
            const float loss = nsdf_loss_value(all[k], f[i], d[i], &one);
            expected += (double)loss;
            assert_true(losses[i] == loss && derivative[i] == 0.25f * one);
        }
        assert_true(fabs(sum - expected) <= 1e-12);
        assert_true(derivative[100] == 7.0f && losses[100] == 7.0f);
        derivative[0] = 9.0f;
        assert_true(nsdf_loss_batch(all[k], f, d, 100, 0.25f, derivative, NULL) == sum);
        assert_true(derivative[0] != 9.0f);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_values_and_derivatives_follow_the_definitions),
        cmocka_unit_test(test_every_loss_is_zero_at_the_true_distance),
        cmocka_unit_test(test_weighted_loss_halves_at_d0),
        cmocka_unit_test(test_wrong_signs_weigh_more_at_the_surface),
        cmocka_unit_test(test_weighted_loss_forgives_no_wrong_sign),
        cmocka_unit_test(test_surface_sensitive_loss_vanishes_far_away_with_the_right_sign),
        cmocka_unit_test(test_surface_sensitive_loss_is_the_error_near_the_surface),
        cmocka_unit_test(test_surface_sensitive_loss_is_the_error_with_the_wrong_sign),
        cmocka_unit_test(test_batch_gives_losses_their_sum_and_scaled_derivatives),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
