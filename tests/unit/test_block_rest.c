/* Values at rest: their gradients against differences, what their steps keep, and what is left when they settle. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "block_fixture.h"
#include "block_rest.h"

static const double at_time = 0.3;

/* Two balls on four bones, and weights of their blocks that are spread over three of these. */
static fixture blended_balls(void) {
    static const float shares[1][4] = {{0.5f, 0.375f, 0.125f, 0.0f}};
    fixture x = two_balls(40, 4, 1);
    spread_weights(&x, shares, 1);
    nsdf_block_frame_compose(&x.frame, &x.model, x.model.values, at_time);
    return x;
}

/* L = sum over blocks of g . pose. */
static double linear_loss(fixture *x, const float (*g)[12]) {
    double sum = 0.0;
    nsdf_block_model_set_influences(&x->model);
    nsdf_block_frame_compose(&x->frame, &x->model, x->model.values, at_time);
    for (uint32_t k = 0; k < x->model.desc.block_count; k++)
        for (int i = 0; i < 12; i++)
            sum += (double)g[k][i] * (double)x->frame.pose[k][i];
    return sum;
}

static double slope_of(fixture *x, const float (*g)[12], float *value) {
    const float kept = *value;
    *value = kept + 0.0625f;
    const double up = linear_loss(x, g);
    *value = kept - 0.0625f;
    const double slope = (up - linear_loss(x, g)) / 0.125;
    *value = kept;
    linear_loss(x, g);
    return slope;
}

/* The loss is linear in weights and in centres, each on its own. */
static void test_gradients_of_weights_and_centres(void **state) {
    fixture x = blended_balls();
    nsdf_block_model *m = &x.model;
    float(*g)[12] = (float(*)[12])(void *)random_floats(12 * (size_t)m->desc.block_count, 1.0f, 3);
    float *gradient = calloc(m->value_count, sizeof *gradient);
    const size_t weights = nsdf_block_offset(&m->desc, NSDF_BLOCK_WEIGHTS);
    const size_t centres = nsdf_block_offset(&m->desc, NSDF_BLOCK_CENTRES);
    const nsdf_block_gradient none = {0};
    uint32_t unused = 0;
    (void)state;
    for (uint32_t k = 0; k < m->desc.block_count; k++) {
        float rest[NSDF_REST_VALUES];
        nsdf_block_rest_gradient(m, &x.frame, k, g[k], &none, rest);
        nsdf_block_rest_add_gradient(m, k, rest, gradient);
    }
    for (size_t i = weights; i < weights + NSDF_BONE_INFLUENCES * (size_t)m->desc.block_count; i++) {
        if (m->values[i] == 0.0f) {
            assert_true(gradient[i] == 0.0f);
            unused++;
            continue;
        }
        const double slope = slope_of(&x, (const float(*)[12])g, &m->values[i]);
        assert_true(fabs(slope - (double)gradient[i]) < 1e-3 + 1e-3 * fabs(slope));
    }
    for (size_t i = centres; i < centres + 3 * (size_t)m->desc.block_count; i++) {
        const double slope = slope_of(&x, (const float(*)[12])g, &m->values[i]);
        assert_true(fabs(slope - (double)gradient[i]) < 1e-3 + 1e-3 * fabs(slope));
    }
    assert_int_equal(unused, m->desc.block_count);
    free(gradient);
    free(g);
    free_fixture(&x);
}

/* L = sum over points of g . u, with u of one block. */
static double ball_loss(fixture *x, uint32_t block, const float (*points)[3], const float (*g)[3], uint32_t count,
                        nsdf_block_gradient *sums) {
    double loss = 0.0;
    memset(sums, 0, sizeof *sums);
    nsdf_block_frame_compose(&x->frame, &x->model, x->model.values, at_time);
    for (uint32_t i = 0; i < count; i++) {
        float u[3];
        to_ball(&x->frame, block, points[i], u);
        for (int n = 0; n < 9; n++)
            sums->moment[n / 3][n % 3] += g[i][n / 3] * u[n % 3];
        for (int axis = 0; axis < 3; axis++)
            loss += (double)g[i][axis] * (double)u[axis];
    }
    return loss;
}

static void test_gradients_of_radii(void **state) {
    enum { COUNT = 20 };
    fixture x = blended_balls();
    nsdf_block_model *m = &x.model;
    const size_t radii = nsdf_block_offset(&m->desc, NSDF_BLOCK_RADII);
    const float none[12] = {0.0f};
    (void)state;
    for (uint32_t k = 0; k < m->desc.block_count; k += 3) {
        float *radius = &m->values[radii + k], rest[NSDF_REST_VALUES];
        const float kept = *radius, by = 0.01f * kept;
        float(*points)[3] = (float(*)[3])(void *)random_floats(3 * COUNT, 0.5f, k);
        float(*g)[3] = (float(*)[3])(void *)random_floats(3 * COUNT, 1.0f, 100 + k);
        nsdf_block_gradient sums;
        *radius = kept + by;
        const double up = ball_loss(&x, k, (const float(*)[3])points, (const float(*)[3])g, COUNT, &sums);
        *radius = kept - by;
        const double down = ball_loss(&x, k, (const float(*)[3])points, (const float(*)[3])g, COUNT, &sums);
        *radius = kept;
        const double loss = ball_loss(&x, k, (const float(*)[3])points, (const float(*)[3])g, COUNT, &sums);
        nsdf_block_rest_gradient(m, &x.frame, k, none, &sums, rest);
        const double slope = (up - down) / (2.0 * (double)by);
        assert_true(fabs(loss) > 1e-3);
        assert_true(fabs(slope - (double)rest[NSDF_BONE_INFLUENCES + 3]) < 0.01 * fabs(slope));
        free(points);
        free(g);
    }
    free_fixture(&x);
}

/* ---- Steps ----------------------------------------------------------------------------------------------- */

static void check_weights(const nsdf_block_model *m) {
    const float *weight = values_of(m, NSDF_BLOCK_WEIGHTS);
    for (size_t k = 0; k < m->desc.block_count; k++, weight += NSDF_BONE_INFLUENCES) {
        assert_true(fabsf(weight[0] + weight[1] + weight[2] - 1.0f) < 1e-5f && weight[3] == 0.0f);
        for (size_t i = 0; i < 3; i++) {
            assert_true(weight[i] > 0.01f);
            assert_true(m->influences[NSDF_BONE_INFLUENCES * k + i].weight == weight[i]);
        }
    }
}

static void check_radii(const nsdf_block_model *m, uint32_t *at_limits) {
    const float *radii = values_of(m, NSDF_BLOCK_RADII);
    for (size_t k = 0; k < m->desc.block_count; k++) {
        assert_true(radii[k] >= 0.8f * m->radius && radii[k] <= 1.5f * m->radius);
        *at_limits += radii[k] == 0.8f * m->radius || radii[k] == 1.5f * m->radius;
    }
}

/* Steps against a gradient that stays the same, on and on. */
static void test_steps_keep_sums_and_shares(void **state) {
    fixture x = blended_balls();
    nsdf_block_model *m = &x.model;
    nsdf_block_rest rest;
    float *gradient = calloc(m->value_count, sizeof *gradient);
    float *slope = random_floats(m->value_count, 1.0f, 8);
    float *before = malloc(m->value_count * sizeof *before);
    uint32_t at_limits = 0;
    (void)state;
    memcpy(before, m->values, m->value_count * sizeof *before);
    assert_int_equal(nsdf_block_rest_create(&rest, m, 0), 0);
    for (int step = 0; step < 200; step++) {
        memcpy(gradient, slope, m->value_count * sizeof *gradient);
        nsdf_block_rest_step(&rest, m, gradient, 1.0);
        check_weights(m);
        check_radii(m, &at_limits);
    }
    assert_true(at_limits > 40);
    for (uint32_t t = 0; t < m->desc.list.count; t++) { /* what is not at rest, and bones, lives, anchors, stay */
        const size_t at = nsdf_block_offset(&m->desc, t);
        const size_t size = (size_t)nsdf_array_size(&m->desc.list.tensors[t].arrays[0]) * sizeof *before;
        const int moves = t == NSDF_BLOCK_WEIGHTS || t == NSDF_BLOCK_CENTRES || t == NSDF_BLOCK_RADII;
        assert_true((memcmp(before + at, m->values + at, size) != 0) == moves);
    }
    nsdf_block_rest_free(&rest);
    free(before);
    free(slope);
    free(gradient);
    free_fixture(&x);
}

static void test_settled_values_are_rounded_once(void **state) {
    static const uint32_t tensors[] = {NSDF_BLOCK_CENTRES, NSDF_BLOCK_RADII, NSDF_BLOCK_WEIGHTS};
    fixture x = blended_balls();
    nsdf_block_model *m = &x.model;
    nsdf_block_rest rest;
    float *gradient = random_floats(m->value_count, 1.0f, 8), *settled = malloc(m->value_count * sizeof *settled);
    (void)state;
    assert_int_equal(nsdf_block_rest_create(&rest, m, 0), 0);
    nsdf_block_rest_step(&rest, m, gradient, 0.7);
    nsdf_block_rest_settle(&rest, m);
    assert_true(rest.settled);
    memcpy(settled, m->values, m->value_count * sizeof *settled);
    for (int t = 0; t < 3; t++) {
        const nsdf_array_desc *a = &m->desc.list.tensors[tensors[t]].arrays[0];
        const float *v = values_of(m, tensors[t]);
        for (size_t i = 0; i < (size_t)nsdf_array_size(a); i++) {
            int32_t q;
            assert_int_equal(nsdf_quantise(&v[i], 1, a->step, a->offset, &q), 0);
            const float read = nsdf_dequantise(q, a->step, a->offset);
            assert_memory_equal(&read, &v[i], sizeof read);
        }
    }
    check_weights(m);
    m->values[nsdf_block_offset(&m->desc, NSDF_BLOCK_CENTRES)] += 1e-4f;
    nsdf_block_rest_settle(&rest, m);
    assert_true(memcmp(settled, m->values, m->value_count * sizeof *settled) != 0);
    nsdf_block_rest_free(&rest);
    free(settled);
    free(gradient);
    free_fixture(&x);
}

/* ---- As part of fitting ---------------------------------------------------------------------------------- */

static int stop_at_once(void *user, const nsdf_progress *progress) {
    (void)user;
    (void)progress;
    return NSDF_FINISH;
}

/* Fitting moves them, and leaves them rounded even when it is stopped before they would settle. */
static void test_fitting_leaves_them_settled(void **state) {
    (void)state;
    for (int stopped = 0; stopped < 2; stopped++) {
        fixture x = make_fixture(shape_sphere(0.3, 30, 60), UINT32_MAX, sample_shear, 100, 3, 2);
        nsdf_block_model *m = &x.model;
        float *before = malloc(m->value_count * sizeof *before), *rounded = malloc(m->value_count * sizeof *rounded);
        const size_t centres = nsdf_block_offset(&m->desc, NSDF_BLOCK_CENTRES);
        const size_t rest_end = nsdf_block_offset(&m->desc, NSDF_BLOCK_POSES);
        fit_fixture fit;
        nsdf_fit_result result;
        start(&x);
        memcpy(before, m->values, m->value_count * sizeof *before);
        make_fit(&fit, &x, stopped ? 1u << 30 : 300);
        fit.job.progress = stopped ? stop_at_once : NULL;
        assert_int_equal(nsdf_block_fit_run(&fit.job, m, &result), 0);
        assert_true(stopped || memcmp(before + centres, m->values + centres, 300 * sizeof *before) != 0);
        memcpy(rounded, m->values, m->value_count * sizeof *rounded);
        nsdf_block_model_round_rest(m);
        assert_memory_equal(rounded, m->values, rest_end * sizeof *rounded);
        free(before);
        free(rounded);
        free_fit(&fit);
        free_fixture(&x);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_gradients_of_weights_and_centres), cmocka_unit_test(test_gradients_of_radii),
        cmocka_unit_test(test_steps_keep_sums_and_shares),       cmocka_unit_test(test_settled_values_are_rounded_once),
        cmocka_unit_test(test_fitting_leaves_them_settled),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
