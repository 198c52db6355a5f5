/* Blocks whose coefficients of degree 0, their levels, move in time. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "block_fixture.h"
#include "block_rate.h"
#include "block_stage.h"
#include "blocks.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A still ball, levels with a control point every second of five frames. */
static fixture still_ball(uint32_t degree) {
    fixture x = make_level_fixture(shape_sphere(0.3, 30, 60), UINT32_MAX, sample_still, 100, 2, degree, 2.0);
    start(&x);
    return x;
}

static void fill_levels(nsdf_block_model *m) {
    for (size_t i = 0; i < m->level_count; i++)
        m->values[m->level_offset + i] = 1e-3f * (float)(i * 7919 % 31) - 0.015f;
}

static void test_levels_have_their_own_control_points(void **state) {
    (void)state;
    for (uint32_t degree = 1; degree <= 3; degree++) {
        fixture x = still_ball(degree);
        const nsdf_block_model *m = &x.model;
        const uint32_t blocks = m->desc.block_count;
        assert_int_equal(m->level_knots, 5);
        assert_int_equal(m->level_count, 5 * blocks);
        assert_int_equal(m->level_offset, nsdf_block_offset(&m->desc, NSDF_BLOCK_COEFFICIENTS));
        assert_int_equal(m->term_offset + m->term_count, m->value_count);
        assert_int_equal(m->terms,
                         nsdf_degree_terms(0) + nsdf_degree_terms(1) + (degree > 1 ? 6 : 0) + (degree > 2 ? 10 : 0));
        for (uint32_t d = 1; d <= degree; d++)
            assert_int_equal(nsdf_block_degree_offset(m, 3, d),
                             nsdf_block_offset(&m->desc, NSDF_BLOCK_COEFFICIENTS + d) + 3 * nsdf_degree_terms(d));
        for (size_t k = 0; k < m->level_count; k++) /* the start is the same at all times */
            assert_true(m->values[m->level_offset + k] == m->values[m->level_offset + k % blocks]);
        free_fixture(&x);
    }
}

/* Without degrees above 0 nothing else would be left to fit. */
static void test_levels_alone_do_not_move(void **state) {
    fixture x = make_level_fixture(shape_sphere(0.3, 30, 60), UINT32_MAX, sample_still, 50, 2, 0, 2.0);
    (void)state;
    assert_int_equal(x.model.level_knots, 0);
    assert_int_equal(x.model.level_count, 0);
    free_fixture(&x);
}

/* The polynomials of one time are the decoder's. */
static void test_polynomials_are_those_of_the_decoder(void **state) {
    fixture x = still_ball(3);
    const nsdf_block_model *m = &x.model;
    nsdf_blocks blocks;
    void *storage = malloc((size_t)nsdf_blocks_storage(&m->desc) + 64);
    (void)state;
    fill_levels(&x.model);
    nsdf_blocks_init(&blocks, &m->desc, m->values, (char *)storage + (64 - (uintptr_t)storage % 64));
    for (int time = 0; time <= 10; time++) {
        nsdf_block_frame_compose(&x.frame, m, m->values, 0.1 * time);
        nsdf_blocks_compose(&blocks, 0.1 * time, NULL);
        for (uint32_t k = 0; k < m->desc.block_count; k++)
            for (uint32_t i = 0; i < m->terms; i++)
                assert_true(fabsf(blocks.own_terms[k][i] - x.frame.terms[k][i]) < 1e-6f);
    }
    free(storage);
    free_fixture(&x);
}

/* What a gradient of all monomials makes of the values: that of sum_k g_k monomial_k(u), by differences. */
static void test_gradients_reach_the_control_points(void **state) {
    fixture x = still_ball(2);
    nsdf_block_model *m = &x.model;
    const uint32_t blocks = m->desc.block_count;
    float *gradient = calloc(m->value_count, sizeof *gradient);
    float(*g)[NSDF_BLOCK_MOST_TERMS] = calloc(blocks, sizeof *g);
    const double u = 0.37;
    (void)state;
    for (uint32_t k = 0; k < blocks; k++)
        g[k][0] = (float)(k % 5) - 1.5f;
    for (uint32_t k = 0; k < blocks; k++)
        nsdf_block_add_gradient(m, k, g[k], gradient);
    for (size_t i = m->level_offset; i < m->term_offset; i++)
        assert_true(gradient[i] == 0.0f);
    nsdf_block_scatter_levels(m, u, (const float(*)[NSDF_BLOCK_MOST_TERMS])g, gradient);
    for (size_t i = 0; i < m->level_count; i += 3) {
        float *value = &m->values[m->level_offset + i];
        const size_t k = i % blocks;
        nsdf_block_frame_compose(&x.frame, m, m->values, u);
        const float before = x.frame.terms[k][0];
        *value += 0.25f;
        nsdf_block_frame_compose(&x.frame, m, m->values, u);
        const float slope = g[k][0] * (x.frame.terms[k][0] - before) / 0.25f;
        *value -= 0.25f;
        assert_true(fabsf(gradient[m->level_offset + i] - slope) < 1e-5f);
    }
    free(gradient);
    free(g);
    free_fixture(&x);
}

/* A bit of a level costs what a bit of a pose costs. */
static void test_levels_have_a_rate(void **state) {
    fixture x = still_ball(2);
    nsdf_block_model *m = &x.model;
    float *gradient = calloc(m->value_count, sizeof *gradient);
    const double step = (double)m->desc.list.tensors[NSDF_BLOCK_COEFFICIENTS].arrays[0].step;
    const size_t at = m->level_offset + 2 * m->desc.block_count + 7;
    (void)state;
    m->values[at] += (float)step; /* differences of one step, up and down again */
    nsdf_block_add_rate(m, m->values, 0.5, gradient);
    const size_t numbers = m->pose_count + m->level_count + m->term_count + NSDF_BONE_INFLUENCES * m->desc.block_count;
    const double slope = 0.5 / (log(2.0) * (double)numbers) * 2.0 * step / (2.0 * step * step);
    assert_true(fabs((double)gradient[at] - slope) < 1e-3 * slope);
    assert_true(fabs((double)gradient[at + m->desc.block_count] + 0.5 * slope) < 1e-3 * slope);
    free(gradient);
    free_fixture(&x);
}

/* Waves that no blend of two bones follows. */
static double error_of_waves(double level_spacing) {
    fixture x = make_level_fixture(shape_sphere(0.3, 30, 60), UINT32_MAX, sample_still, 100, 2, 2, level_spacing);
    fit_fixture fit;
    nsdf_fit_result result;
    start(&x);
    make_fit(&fit, &x, 1500);
    for (int f = 0; f < SAMPLE_FRAMES; f++)
        for (size_t i = 0; i < fit.sets[f].count; i++)
            fit.sets[f].d[i] += 0.01f * sinf(20.0f * fit.sets[f].x[i] + 1.5f * (float)f);
    assert_int_equal(nsdf_block_fit_run(&fit.job, &x.model, &result), 0);
    free_fit(&fit);
    free_fixture(&x);
    return result.near_error;
}

static void test_levels_follow_what_bones_do_not(void **state) {
    (void)state;
    assert_true(error_of_waves(1.0) < 0.8 * error_of_waves(0.0));
}

static void test_levels_are_weighed_apart(void **state) {
    fixture x = still_ball(2), still = make_fixture(shape_sphere(0.3, 30, 60), UINT32_MAX, sample_still, 100, 2, 2);
    nsdf_block_bytes bytes;
    (void)state;
    fill_levels(&x.model);
    assert_int_equal(nsdf_weigh_blocks(&x.model, &bytes), 0);
    assert_true(bytes.levels > 200 && bytes.shapes > 100);
    assert_int_equal(nsdf_weigh_blocks(&still.model, &bytes), 0);
    assert_int_equal(bytes.levels, 0);
    free_fixture(&x);
    free_fixture(&still);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_levels_have_their_own_control_points),
        cmocka_unit_test(test_levels_alone_do_not_move),
        cmocka_unit_test(test_polynomials_are_those_of_the_decoder),
        cmocka_unit_test(test_gradients_reach_the_control_points),
        cmocka_unit_test(test_levels_have_a_rate),
        cmocka_unit_test(test_levels_follow_what_bones_do_not),
        cmocka_unit_test(test_levels_are_weighed_apart),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
