/* The model: layout, first values, composition at a time, and gradients back from it. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "fit_samples.h"
#include "make_file.h"

enum { FRAMES = 12 };
static const double times[] = {0.0, 0.05, 0.3, 0.5, 0.7123, 0.999, 1.0};
enum { TIMES = sizeof times / sizeof *times };

static nsdf_model describe(int kind, uint32_t layers, uint32_t width) {
    const nsdf_encoder_options o = sample_model_options(kind, layers, width);
    nsdf_model model;
    nsdf_model_describe(&model, &o, FRAMES);
    return model;
}

/* ---- Description and layout ----------------------------------------------------------------------------- */

static void test_arrays_follow_each_other_in_the_order_of_the_file(void **state) {
    (void)state;
    for (int kind = 0; kind < SAMPLE_MODELS; kind++) {
        const nsdf_model m = describe(kind, 3, 7);
        uint64_t at = 0;
        for (uint32_t t = 0; t < m.desc.list.count; t++)
            for (uint32_t a = 0; a < m.desc.list.tensors[t].array_count; a++) {
                assert_true(m.array_offset[t][a] == at);
                at += nsdf_array_size(&m.desc.list.tensors[t].arrays[a]);
            }
        assert_true(m.parameter_count == at);
        assert_true(m.parameter_count == nsdf_parameter_count(&m.desc.list));
        assert_int_equal(m.desc.list.count, nsdf_weight_index(&m.desc, m.desc.layer_count));
    }
}

static void test_composed_vector_holds_matrices_with_bias_columns_then_b(void **state) {
    (void)state;
    for (int kind = 0; kind < SAMPLE_MODELS; kind++) {
        const nsdf_model m = describe(kind, 2, 7);
        const size_t in = kind < 6 ? 3 : kind < 8 ? 4 : 10;
        assert_int_equal(m.desc.layer_count, 3);
        assert_int_equal(nsdf_layer_inputs(&m, 0), in);
        assert_int_equal(nsdf_layer_inputs(&m, 1), 7);
        assert_int_equal(m.layer_offset[0], 0);
        assert_int_equal(m.layer_offset[1], 7 * (in + 1));
        assert_int_equal(m.layer_offset[2], 7 * (in + 1) + 7 * 8);
        assert_int_equal(m.fourier_offset, 7 * (in + 1) + 7 * 8 + 8);
        assert_int_equal(m.composed_size, m.fourier_offset + (kind >= 8 ? 20 : 0));
        assert_int_equal(m.widest, in > 7 ? in : 7);
    }
}

static void test_only_first_weights_and_hidden_biases_change_with_time(void **state) {
    (void)state;
    for (int kind = 2; kind < 6; kind++) {
        const nsdf_model m = describe(kind, 3, 7);
        const uint8_t moving = kind < 4 ? NSDF_TENSOR_SPLINE : NSDF_TENSOR_LOW_RANK;
        for (uint32_t t = 0; t < m.desc.list.count; t++) {
            const int moves = t == 0 || (t % 2 == 1 && t + 1 < m.desc.list.count);
            assert_int_equal(m.desc.list.tensors[t].kind, moves ? moving : NSDF_TENSOR_CONSTANT);
            assert_int_equal(m.desc.list.tensors[t].knots, moves ? 3 + 6 : 0); /* 11 steps of frames, 2 to a span */
            assert_int_equal(m.desc.list.tensors[t].rank, moves && kind >= 4 ? 3 : 0);
        }
    }
}

static void test_knots_follow_the_number_of_frames(void **state) {
    static const uint32_t frames[] = {1, 2, 5, 6, 100}, knots[] = {0, 4, 4, 5, 3 + 25};
    (void)state;
    for (size_t i = 0; i < sizeof frames / sizeof *frames; i++) {
        nsdf_encoder_options o = sample_options(2, 8);
        nsdf_model m;
        o.knot_spacing = 4.0;
        nsdf_model_describe(&m, &o, frames[i]);
        assert_int_equal(m.desc.list.tensors[0].knots, knots[i]);
        assert_int_equal(m.desc.list.tensors[0].kind, frames[i] == 1 ? NSDF_TENSOR_CONSTANT : NSDF_TENSOR_SPLINE);
    }
}

/* ---- Composition ---------------------------------------------------------------------------------------- */

static void check_layer(const nsdf_model *m, const float *parameters, const float *composed, uint32_t l, double u) {
    const uint32_t at = nsdf_weight_index(&m->desc, l), in = nsdf_layer_inputs(m, l);
    const float *weights = reference_values(&m->desc, parameters, at);
    const float *biases = reference_values(&m->desc, parameters, at + 1);
    const float *matrix = composed + m->layer_offset[l];
    for (uint32_t o = 0; o < m->desc.layers[l].width; o++) {
        for (uint32_t i = 0; i < in; i++) {
            const double w = reference_element(&m->desc.list.tensors[at], weights, (size_t)o * in + i, u);
            assert_true(fabs((double)matrix[o * (in + 1) + i] - w) <= 1e-6);
        }
        const double b = reference_element(&m->desc.list.tensors[at + 1], biases, o, u);
        assert_true(fabs((double)matrix[o * (in + 1) + in] - b) <= 1e-6);
    }
}

static void test_composition_follows_the_definition_of_each_kind(void **state) {
    (void)state;
    for (int kind = 0; kind < SAMPLE_MODELS; kind++) {
        const nsdf_model m = describe(kind, 3, 7);
        float *parameters = random_parameters(&m, (uint64_t)kind), *composed = random_floats(m.composed_size, 9.0f, 1);
        for (int t = 0; t < TIMES; t++) {
            nsdf_model_compose(&m, parameters, times[t], composed);
            for (uint32_t l = 0; l < m.desc.layer_count; l++)
                check_layer(&m, parameters, composed, l, times[t]);
        }
        free(parameters);
        free(composed);
    }
}

static void test_b_comes_from_the_seed_or_from_the_parameters(void **state) {
    (void)state;
    for (int kind = 8; kind < 12; kind++) {
        const nsdf_model m = describe(kind, 1, 4);
        float *parameters = random_parameters(&m, 3), *composed = random_floats(m.composed_size, 9.0f, 1), seeded[20];
        nsdf_fourier_matrix(m.desc.fourier_seed, m.desc.fourier_sigma, 5, seeded);
        nsdf_model_compose(&m, parameters, 0.5, composed);
        assert_memory_equal(composed + m.fourier_offset, kind < 10 ? seeded : parameters, sizeof seeded);
        free(parameters);
        free(composed);
    }
}

/* ---- Gradients ------------------------------------------------------------------------------------------ */

static double dot(const float *a, const float *b, size_t count) {
    double sum = 0.0;
    for (size_t i = 0; i < count; i++)
        sum += (double)a[i] * (double)b[i];
    return sum;
}

/* (compose(p + dp / 2) - compose(p - dp / 2)), which is compose'(p) dp: compose is at most bilinear. */
static float *directional(const nsdf_model *m, const float *p, const float *dp, double u) {
    const size_t count = (size_t)m->parameter_count;
    float *moved = random_floats(count, 0.0f, 0), *up = random_floats(m->composed_size, 0.0f, 0);
    float *down = random_floats(m->composed_size, 0.0f, 0);
    for (size_t i = 0; i < count; i++)
        moved[i] = p[i] + 0.5f * dp[i];
    nsdf_model_compose(m, moved, u, up);
    for (size_t i = 0; i < count; i++)
        moved[i] = p[i] - 0.5f * dp[i];
    nsdf_model_compose(m, moved, u, down);
    for (size_t i = 0; i < m->composed_size; i++)
        up[i] -= down[i];
    free(moved);
    free(down);
    return up;
}

static void check_adjoint(const nsdf_model *m, double u, uint64_t seed) {
    const size_t count = (size_t)m->parameter_count;
    float *p = random_parameters(m, seed), *dp = random_floats(count, 1.0f, seed + 1);
    float *g = random_floats(m->composed_size, 1.0f, seed + 2), *gradient = random_floats(count, 1.0f, seed + 3);
    float *step = directional(m, p, dp, u);
    const double before = dot(dp, gradient, count);
    nsdf_model_scatter(m, p, u, g, gradient);
    const double forward = dot(step, g, m->composed_size), backward = dot(dp, gradient, count) - before;
    assert_true(fabs(forward - backward) <= 2e-5 * sqrt((double)count));
    free(p);
    free(dp);
    free(g);
    free(gradient);
    free(step);
}

static void test_scatter_is_the_adjoint_of_compose(void **state) {
    (void)state;
    for (int kind = 0; kind < SAMPLE_MODELS; kind++) {
        const nsdf_model m = describe(kind, 3, 7);
        for (int t = 0; t < TIMES; t++)
            check_adjoint(&m, times[t], (uint64_t)(100 * kind + t));
    }
}

/* Each control point on its own, so that errors cannot cancel. */
static void test_scatter_gives_every_spline_knot_its_weight(void **state) {
    const nsdf_model m = describe(2, 1, 2);
    const nsdf_tensor_desc *t = &m.desc.list.tensors[0];
    float *p = random_parameters(&m, 5), *g = random_floats(m.composed_size, 0.0f, 0);
    (void)state;
    g[m.layer_offset[0] + 1 * 4 + 2] = 1.0f; /* row 1, column 2 */
    for (int i = 0; i < TIMES; i++) {
        float *gradient = random_floats((size_t)m.parameter_count, 0.0f, 0);
        nsdf_model_scatter(&m, p, times[i], g, gradient);
        for (uint32_t k = 0; k < t->knots; k++) {
            const double weight = reference_basis(times[i] * (double)(t->knots - 3) - (double)k + 1.0);
            assert_true(fabs((double)gradient[k * 6 + 1 * 3 + 2] - weight) <= 1e-6);
            gradient[k * 6 + 1 * 3 + 2] = 0.0f;
        }
        assert_true(dot(gradient, gradient, (size_t)m.parameter_count) == 0.0);
        free(gradient);
    }
    free(p);
    free(g);
}

/* ---- First values --------------------------------------------------------------------------------------- */

/* Uniform in +-range: none beyond, some near the ends, both signs. */
static void assert_spread(const float *values, size_t count, double range) {
    double low = 0.0, high = 0.0;
    for (size_t i = 0; i < count; i++) {
        low = fmin(low, (double)values[i]);
        high = fmax(high, (double)values[i]);
    }
    assert_true(high <= range * 1.000001 && low >= -range * 1.000001);
    assert_true(high >= 0.8 * range && low <= -0.8 * range);
}

static const float *start_values(nsdf_model *m, const nsdf_encoder_options *o, uint64_t seed) {
    nsdf_random random = nsdf_random_start(seed, 1);
    nsdf_model_describe(m, o, FRAMES);
    float *values = random_floats((size_t)m->parameter_count, 9.0f, 1);
    nsdf_model_initialise(m, &random, values);
    return values;
}

static void check_ranges(const nsdf_encoder_options *o, const double weights[3], const double biases[3]) {
    nsdf_model m;
    const float *values = start_values(&m, o, 1);
    for (uint32_t l = 0; l < 3; l++) {
        const uint32_t w = nsdf_weight_index(&m.desc, l);
        const size_t rows = m.desc.list.tensors[w].rows, cols = m.desc.list.tensors[w].cols;
        assert_spread(values + m.array_offset[w][0], rows * cols, weights[l]);
        if (rows > 1)
            assert_spread(values + m.array_offset[w + 1][0], rows, biases[l]);
    }
    free((void *)values);
}

static void test_first_values_have_the_stated_ranges(void **state) {
    nsdf_encoder_options o = sample_options(2, 64);
    const double hidden = sqrt(6.0 / 64.0);
    (void)state;
    o.omega_first = 40.0;
    o.omega_hidden = 3.0;
    check_ranges(&o, (double[]){1.0 / 3.0, hidden / 3.0, 0.1 * hidden}, (double[]){1.0 / sqrt(3.0), 0.125 / 3.0, 0.0});
    o.activation = NSDF_MODEL_RELU;
    check_ranges(&o, (double[]){sqrt(2.0), hidden, hidden}, (double[]){0.0, 0.0, 0.0});
    o.weight_time = NSDF_TIME_CONSTANT;
    o.input = NSDF_MODEL_FOURIER;
    o.fourier_features = 12;
    check_ranges(&o, (double[]){0.5, hidden, hidden}, (double[]){0.0, 0.0, 0.0});
}

static void test_first_values_are_alike_at_all_knots(void **state) {
    (void)state;
    nsdf_encoder_options o = sample_model_options(2, 3, 9);
    nsdf_model m;
    const float *values = start_values(&m, &o, 1);
    for (uint32_t t = 0; t < m.desc.list.count; t++) {
        const nsdf_array_desc *a = &m.desc.list.tensors[t].arrays[0];
        const size_t plane = (size_t)a->rows * a->cols;
        for (uint32_t k = 1; k < a->planes; k++)
            assert_memory_equal(values + m.array_offset[t][0] + k * plane, values + m.array_offset[t][0],
                                plane * sizeof *values);
    }
    free((void *)values);
}

static void test_low_rank_factors_start_small_but_not_at_zero(void **state) {
    (void)state;
    nsdf_encoder_options o = sample_options(2, 48);
    nsdf_model m;
    o.weight_time = NSDF_TIME_LOW_RANK;
    o.rank = 12;
    const float *values = start_values(&m, &o, 1);
    assert_spread(values + m.array_offset[0][1], 12 * 48 * 3, 0.3 / 3.0);
    assert_spread(values + m.array_offset[0][2], 12 * (size_t)m.desc.list.tensors[0].knots, 0.3);
    free((void *)values);
}

static void test_first_values_follow_the_seed(void **state) {
    (void)state;
    for (int kind = 0; kind < SAMPLE_MODELS; kind++) {
        const nsdf_encoder_options o = sample_model_options(kind, 2, 5);
        nsdf_model m;
        const float *a = start_values(&m, &o, 1), *b = start_values(&m, &o, 1), *c = start_values(&m, &o, 2);
        const size_t bytes = (size_t)m.parameter_count * sizeof *a;
        assert_memory_equal(a, b, bytes);
        assert_memory_not_equal(a, c, bytes);
        if (m.desc.input == NSDF_INPUT_FOURIER && m.desc.fourier_source == NSDF_FOURIER_STORED)
            assert_memory_equal(a, c, 20 * sizeof *a); /* B has a seed of its own: the one in the options */
        free((void *)a);
        free((void *)b);
        free((void *)c);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_arrays_follow_each_other_in_the_order_of_the_file),
        cmocka_unit_test(test_composed_vector_holds_matrices_with_bias_columns_then_b),
        cmocka_unit_test(test_only_first_weights_and_hidden_biases_change_with_time),
        cmocka_unit_test(test_knots_follow_the_number_of_frames),
        cmocka_unit_test(test_composition_follows_the_definition_of_each_kind),
        cmocka_unit_test(test_b_comes_from_the_seed_or_from_the_parameters),
        cmocka_unit_test(test_scatter_is_the_adjoint_of_compose),
        cmocka_unit_test(test_scatter_gives_every_spline_knot_its_weight),
        cmocka_unit_test(test_first_values_have_the_stated_ranges),
        cmocka_unit_test(test_first_values_are_alike_at_all_knots),
        cmocka_unit_test(test_low_rank_factors_start_small_but_not_at_zero),
        cmocka_unit_test(test_first_values_follow_the_seed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
