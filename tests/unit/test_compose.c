/* Composition in time and whole networks against formulas in double. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "compose.h"
#include "cpu.h"
#include "make_file.h"
#include "network.h"

static const double times[] = {0.0, 1e-9, 0.1, 1.0 / 3.0, 0.5, 0.71, 0.999999, 1.0};
enum { TIMES = sizeof times / sizeof *times };

static void check_tensor(nsdf_tensor_kind kind, uint32_t rows, uint32_t cols, uint32_t knots) {
    nsdf_tensor_desc tensor = {.kind = 0};
    nsdf_blend blend;
    uint64_t random = knots;
    make_tensor(&tensor, kind, rows, cols);
    if (kind != NSDF_TENSOR_CONSTANT)
        tensor.knots = knots;
    nsdf_tensor_layout(&tensor);
    const size_t size = (size_t)nsdf_tensor_size(&tensor);
    float *values = malloc(size * sizeof *values);
    double *row = malloc(cols * sizeof *row);
    assert_true(values && row);
    for (size_t i = 0; i < size; i++)
        values[i] = (float)make_uniform(&random);
    for (int t = 0; t < TIMES; t++) {
        nsdf_blend_tensor(&blend, &tensor, values, times[t]);
        for (uint32_t r = 0; r < rows; r++) {
            nsdf_blend_row(&blend, r, row);
            for (uint32_t c = 0; c < cols; c++)
                assert_true(fabs(row[c] - reference_element(&tensor, values, (size_t)r * cols + c, times[t])) < 1e-6);
        }
    }
    free(values);
    free(row);
}

static void test_constant_tensors_do_not_move(void **state) {
    (void)state;
    check_tensor(NSDF_TENSOR_CONSTANT, 5, 7, 0);
}

static void test_spline_tensors_follow_the_b_spline(void **state) {
    (void)state;
    for (uint32_t knots = NSDF_MIN_KNOTS; knots <= 40; knots += 9)
        check_tensor(NSDF_TENSOR_SPLINE, 6, 3, knots);
}

static void test_low_rank_tensors_add_their_moving_terms(void **state) {
    (void)state;
    for (uint32_t knots = NSDF_MIN_KNOTS; knots <= 40; knots += 9)
        check_tensor(NSDF_TENSOR_LOW_RANK, 4, 9, knots);
}

typedef struct composed {
    nsdf_network_desc desc;
    nsdf_network network;
    float *values, *storage, *scratch;
} composed;

static void composed_make(composed *c, int shape, uint32_t layers, uint32_t width) {
    uint64_t random = 11 + (uint64_t)shape;
    int32_t *q;
    make_network(&c->desc, shape, layers, width, NSDF_ENTROPY_NONE);
    make_parameters(&c->desc, &random, &q, &c->values);
    free(q);
    c->storage = malloc((size_t)nsdf_network_storage(&c->desc) * sizeof(float));
    assert_non_null(c->storage);
    nsdf_network_init(&c->network, &c->desc, c->storage);
    c->scratch = malloc((size_t)nsdf_network_scratch(&c->network) * sizeof(float));
    assert_non_null(c->scratch);
}

static void composed_free(composed *c) {
    free(c->values);
    free(c->storage);
    free(c->scratch);
}

static void make_points(float xyz[3 * NSDF_TILE]) {
    uint64_t random = 5;
    for (int i = 0; i < 3 * NSDF_TILE; i++)
        xyz[i] = (float)(0.5 * make_uniform(&random));
}

static double reference_at(const composed *c, double u, const float *xyz, int p, int axis, double step) {
    double x[3];
    for (int a = 0; a < 3; a++)
        x[a] = (double)xyz[a * NSDF_TILE + p] + (a == axis ? step : 0.0);
    return reference_value(&c->desc, c->values, u, x);
}

/* Value, and gradient by central differences in double.  relu's are skipped where a kink lies between the two. */
static void check_network(const composed *c, const nsdf_net_kernels *kernels, double u) {
    float xyz[3 * NSDF_TILE], value[NSDF_TILE], gradient[3 * NSDF_TILE];
    make_points(xyz);
    nsdf_network_evaluate(&c->network, kernels, c->scratch, xyz, value, gradient);
    int compared = 0;
    for (int p = 0; p < NSDF_TILE; p++) {
        const double scale = (double)c->desc.value_scale, expected = reference_at(c, u, xyz, p, 0, 0.0);
        assert_true(fabs((double)value[p] * scale + (double)c->desc.value_offset - expected) < 2e-6);
        for (int axis = 0; axis < 3; axis++) {
            const double h = 1e-5, up = reference_at(c, u, xyz, p, axis, h),
                         down = reference_at(c, u, xyz, p, axis, -h);
            const double slope = (up - down) / (2.0 * h), bend = fabs(up - 2.0 * expected + down) / h;
            if (bend > 1e-3)
                continue;
            assert_true(fabs((double)gradient[axis * NSDF_TILE + p] * scale - slope) < 2e-4);
            compared++;
        }
    }
    assert_true(compared > 3 * NSDF_TILE / 2);
}

static void test_networks_of_every_shape_match_the_definition(void **state) {
    (void)state;
    for (int shape = 0; shape < MAKE_SHAPES; shape++) {
        composed c;
        composed_make(&c, shape, 3, 12);
        for (int t = 0; t < TIMES; t++) {
            nsdf_network_compose(&c.network, &c.desc, c.values, times[t]);
            check_network(&c, nsdf_net_kernels_choose(0), times[t]);
            check_network(&c, nsdf_net_kernels_choose(nsdf_cpu_features()), times[t]);
        }
        composed_free(&c);
    }
}

static void test_a_single_layer_is_enough(void **state) {
    (void)state;
    for (int shape = 0; shape < MAKE_SHAPES; shape++) {
        composed c;
        composed_make(&c, shape, 1, 1);
        nsdf_network_compose(&c.network, &c.desc, c.values, 0.4);
        check_network(&c, nsdf_net_kernels_choose(0), 0.4);
        composed_free(&c);
    }
}

static void test_composing_again_leaves_no_trace_of_the_time_before(void **state) {
    float xyz[3 * NSDF_TILE], first[NSDF_TILE], second[NSDF_TILE];
    composed c;
    (void)state;
    make_points(xyz);
    composed_make(&c, MAKE_SPLINE, 3, 12);
    nsdf_network_compose(&c.network, &c.desc, c.values, 0.25);
    nsdf_network_evaluate(&c.network, nsdf_net_kernels_choose(0), c.scratch, xyz, first, NULL);
    nsdf_network_compose(&c.network, &c.desc, c.values, 0.75);
    nsdf_network_compose(&c.network, &c.desc, c.values, 0.25);
    nsdf_network_evaluate(&c.network, nsdf_net_kernels_choose(0), c.scratch, xyz, second, NULL);
    assert_memory_equal(first, second, sizeof first);
    composed_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_constant_tensors_do_not_move),
        cmocka_unit_test(test_spline_tensors_follow_the_b_spline),
        cmocka_unit_test(test_low_rank_tensors_add_their_moving_terms),
        cmocka_unit_test(test_networks_of_every_shape_match_the_definition),
        cmocka_unit_test(test_a_single_layer_is_enough),
        cmocka_unit_test(test_composing_again_leaves_no_trace_of_the_time_before),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
