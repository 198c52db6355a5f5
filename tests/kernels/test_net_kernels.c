/* Kernels of every instruction set against plain C and against libm in double. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <stdio.h>

#include "compose.h"
#include "cpu.h"
#include "make_file.h"
#include "net_kernels.h"
#include "network.h"
#include "nsdf/decoder.h"

enum { GUARD = 32, MAX_TABLES = 3 };
static const float guard_value = -12345.5f;

/* The tables that this machine can run, C first. */
static int list_tables(const nsdf_net_kernels *tables[MAX_TABLES]) {
    const uint32_t features = nsdf_cpu_features();
    int count = 0;
    tables[count++] = nsdf_net_kernels_c();
    if (features & NSDF_CPU_AVX2)
        tables[count++] = nsdf_net_kernels_avx2();
    if (features & NSDF_CPU_AVX512)
        tables[count++] = nsdf_net_kernels_avx512();
    if (features & NSDF_CPU_NEON)
        tables[count++] = nsdf_net_kernels_neon();
    return count;
}

/* `count` floats with guards around them, `shift` floats away from an aligned address. */
typedef struct guarded {
    float *block, *data;
    size_t count;
} guarded;

static guarded guarded_new(size_t count, size_t shift) {
    guarded g = {malloc((count + 2 * GUARD + shift) * sizeof(float)), NULL, count};
    assert_non_null(g.block);
    g.data = g.block + GUARD + shift;
    for (size_t i = 0; i < count + 2 * GUARD; i++)
        g.data[(ptrdiff_t)i - GUARD] = guard_value;
    return g;
}

static void guarded_check_free(guarded *g) {
    for (size_t i = 0; i < GUARD; i++) {
        assert_true(g->data[-(ptrdiff_t)i - 1] == guard_value);
        assert_true(g->data[g->count + i] == guard_value);
    }
    free(g->block);
}

static void fill(float *out, size_t count, double range, uint64_t *random) {
    for (size_t i = 0; i < count; i++)
        out[i] = (float)(range * make_uniform(random));
}

/* One random product, compared with the sum in double. */
static void check_linear(const nsdf_net_kernels *k, uint32_t outputs, uint32_t inputs, size_t shift, int with_bias,
                         int with_gain, uint64_t *random) {
    const size_t size = (size_t)outputs * inputs, rows_in = (size_t)inputs * NSDF_TILE;
    const size_t rows_out = (size_t)outputs * NSDF_TILE;
    float *weights = malloc(size * sizeof *weights), *packed = malloc(size * sizeof *packed);
    guarded in = guarded_new(rows_in, shift), gain = guarded_new(rows_out, shift), out = guarded_new(rows_out, shift);
    guarded bias = guarded_new(outputs, shift);
    assert_true(weights && packed);
    fill(weights, size, 1.0, random);
    fill(in.data, rows_in, 1.0, random);
    fill(gain.data, rows_out, 1.0, random);
    fill(bias.data, outputs, 1.0, random);
    for (uint32_t o = 0; o < outputs; o++)
        for (uint32_t i = 0; i < inputs; i++)
            packed[nsdf_panel_index(outputs, inputs, o, i)] = weights[(size_t)o * inputs + i];
    k->linear(outputs, inputs, packed, with_bias ? bias.data : NULL, in.data, with_gain ? gain.data : NULL, out.data);
    for (uint32_t o = 0; o < outputs; o++) {
        for (uint32_t p = 0; p < NSDF_TILE; p++) {
            double sum = with_bias ? (double)bias.data[o] : 0.0, magnitude = fabs(sum);
            for (uint32_t i = 0; i < inputs; i++) {
                const double term = (double)weights[(size_t)o * inputs + i] * (double)in.data[i * NSDF_TILE + p];
                sum += term;
                magnitude += fabs(term);
            }
            const double g = with_gain ? (double)gain.data[(size_t)o * NSDF_TILE + p] : 1.0;
            assert_true(fabs((double)out.data[(size_t)o * NSDF_TILE + p] - sum * g) <= 2e-6 * magnitude * fabs(g));
        }
    }
    guarded_check_free(&bias);
    guarded_check_free(&gain);
    guarded_check_free(&in);
    guarded_check_free(&out);
    free(packed);
    free(weights);
}

static void test_linear_is_the_matrix_product(void **state) {
    const nsdf_net_kernels *tables[MAX_TABLES];
    const int count = list_tables(tables);
    (void)state;
    for (int t = 0; t < count; t++) {
        uint64_t random = 1;
        for (uint32_t width = 1; width <= 130; width += width < 20 ? 1 : 11)
            check_linear(tables[t], width, 131 - width, width % 5, width % 2 == 0, width % 3 == 0, &random);
        check_linear(tables[t], 3, 130, 1, 0, 0, &random);
        check_linear(tables[t], 130, 3, 2, 1, 1, &random);
        check_linear(tables[t], 12, 1024, 3, 1, 1, &random);
    }
}

static void test_packing_is_a_permutation(void **state) {
    (void)state;
    for (uint32_t outputs = 1; outputs <= 40; outputs++) {
        uint8_t seen[40 * 5] = {0};
        for (uint32_t o = 0; o < outputs; o++) {
            for (uint32_t i = 0; i < 5; i++) {
                const size_t at = nsdf_panel_index(outputs, 5, o, i);
                assert_true(at < outputs * 5);
                assert_int_equal(seen[at]++, 0);
            }
        }
    }
}

/* Largest errors of an activation and its slope over a grid of [-range, range]. */
static void measure(const nsdf_net_kernels *k, nsdf_activation kind, double range, double *error, double *slope_error) {
    enum { TILES = 2000 };
    const double pi = 3.14159265358979323846;
    const size_t n = (size_t)TILES * NSDF_TILE;
    guarded z = guarded_new(n, 1), slope = guarded_new(n, 3);
    float *x = malloc(n * sizeof *x);
    assert_non_null(x);
    for (size_t i = 0; i < n; i++)
        x[i] = z.data[i] = (float)(range * (2.0 * (double)i / (double)(n - 1) - 1.0));
    k->activate(kind, TILES, z.data, slope.data);
    *error = *slope_error = 0.0;
    for (size_t i = 0; i < n; i++) {
        const double v = (double)x[i], t = tanh(v);
        const double value = kind == NSDF_ACT_SINE ? sin(pi * v) : t;
        const double derivative = kind == NSDF_ACT_SINE ? pi * cos(pi * v) : 1.0 - t * t;
        *error = fmax(*error, fabs((double)z.data[i] - value));
        *slope_error = fmax(*slope_error, fabs((double)slope.data[i] - derivative));
    }
    guarded_check_free(&z);
    guarded_check_free(&slope);
    free(x);
}

static void test_sine_is_within_2e_7_up_to_1000_radians(void **state) {
    const nsdf_net_kernels *tables[MAX_TABLES];
    const int count = list_tables(tables);
    (void)state;
    for (int t = 0; t < count; t++) {
        double error, slope;
        measure(tables[t], NSDF_ACT_SINE, 1000.0 / 3.14159265358979323846, &error, &slope);
        print_message("%s: sine %.2e, slope %.2e\n", tables[t]->name, error, slope);
        assert_true(error <= 2e-7 && slope <= 7e-7);
        measure(tables[t], NSDF_ACT_SINE, 1.5, &error, &slope);
        assert_true(error <= 2e-7 && slope <= 7e-7);
    }
}

static void test_tanh_is_within_2e_7(void **state) {
    const nsdf_net_kernels *tables[MAX_TABLES];
    const int count = list_tables(tables);
    (void)state;
    for (int t = 0; t < count; t++) {
        double error, slope;
        for (double range = 1e-3; range < 1e5; range *= 10.0) {
            measure(tables[t], NSDF_ACT_TANH, range, &error, &slope);
            assert_true(error <= 2e-7 && error <= 4e-7 * range && slope <= 4e-7);
        }
    }
}

static void test_relu_identity_and_turn_are_exact_in_all_tables(void **state) {
    const nsdf_net_kernels *tables[MAX_TABLES];
    const int count = list_tables(tables);
    (void)state;
    for (int t = 0; t < count; t++) {
        guarded z = guarded_new(NSDF_TILE, 1), slope = guarded_new(NSDF_TILE, 2), other = guarded_new(NSDF_TILE, 3);
        uint64_t random = 7;
        fill(z.data, NSDF_TILE, 1.0, &random);
        z.data[0] = 0.0f;
        memcpy(other.data, z.data, NSDF_TILE * sizeof(float));
        tables[t]->activate(NSDF_ACT_IDENTITY, 1, z.data, slope.data);
        for (int i = 0; i < NSDF_TILE; i++)
            assert_true(z.data[i] == other.data[i] && slope.data[i] == 1.0f);
        tables[t]->activate(NSDF_ACT_RELU, 1, z.data, slope.data);
        for (int i = 0; i < NSDF_TILE; i++) {
            assert_true(z.data[i] == (other.data[i] > 0.0f ? other.data[i] : 0.0f));
            assert_true(slope.data[i] == (other.data[i] > 0.0f ? 1.0f : 0.0f));
        }
        const float quarters[5] = {0.0f, 0.5f, 1.0f, -0.5f, -1.0f}, cosines[5] = {1.0f, 0.0f, -1.0f, 0.0f, -1.0f};
        memcpy(z.data, quarters, sizeof quarters);
        tables[t]->turn(1, z.data, slope.data, other.data);
        for (int i = 0; i < 5; i++)
            assert_true(fabsf(slope.data[i] - cosines[i]) < 2e-7f);
        assert_true(fabsf(other.data[1] - 1.0f) < 2e-7f && fabsf(other.data[3] + 1.0f) < 2e-7f);
        guarded_check_free(&z);
        guarded_check_free(&slope);
        guarded_check_free(&other);
    }
}

static void test_extreme_inputs_stay_in_range(void **state) {
    const nsdf_net_kernels *tables[MAX_TABLES];
    const int count = list_tables(tables);
    const float extremes[8] = {1e30f, -1e30f, 4194304.5f, 8388609.0f, -16777217.0f, 1e-45f, 3.4e38f, -3.4e38f};
    (void)state;
    for (int t = 0; t < count; t++) {
        float z[NSDF_TILE] = {0}, slope[NSDF_TILE];
        memcpy(z, extremes, sizeof extremes);
        z[8] = INFINITY;
        z[9] = NAN;
        float h[NSDF_TILE];
        memcpy(h, z, sizeof h);
        tables[t]->activate(NSDF_ACT_SINE, 1, z, slope);
        tables[t]->activate(NSDF_ACT_TANH, 1, h, slope);
        for (int i = 0; i < 8; i++)
            assert_true(fabsf(z[i]) <= 1.0000002f && fabsf(h[i]) <= 1.0000002f);
        assert_true(isnan(z[9]) && isnan(h[9]) && fabsf(h[8] - 1.0f) < 2e-7f);
    }
}

typedef struct network_fixture {
    nsdf_network_desc desc;
    nsdf_network network;
    float *values, *storage, *scratch;
} network_fixture;

static void fixture_make(network_fixture *f, int shape, uint32_t layers, uint32_t width, uint64_t seed) {
    int32_t *q;
    make_network(&f->desc, shape, layers, width, NSDF_ENTROPY_NONE);
    make_parameters(&f->desc, &seed, &q, &f->values);
    free(q);
    f->storage = malloc((size_t)nsdf_network_storage(&f->desc) * sizeof(float));
    assert_non_null(f->storage);
    nsdf_network_init(&f->network, &f->desc, f->storage);
    nsdf_network_compose(&f->network, &f->desc, f->values, 0.3);
    f->scratch = malloc((size_t)nsdf_network_scratch(&f->network) * sizeof(float));
    assert_non_null(f->scratch);
}

static void fixture_free(network_fixture *f) {
    free(f->values);
    free(f->storage);
    free(f->scratch);
}

/* Whole networks: every table gives what C gives, and writes into its outputs only. */
static void test_networks_agree_with_plain_c(void **state) {
    const nsdf_net_kernels *tables[MAX_TABLES];
    const int count = list_tables(tables);
    (void)state;
    for (int shape = 0; shape < MAKE_SHAPES; shape++) {
        for (uint32_t width = 1; width <= 130; width += 13) {
            network_fixture f;
            float xyz[3 * NSDF_TILE], expected[NSDF_TILE], slope[3 * NSDF_TILE];
            uint64_t random = width;
            fixture_make(&f, shape, 1 + width % 3, width, width);
            fill(xyz, 3 * NSDF_TILE, 0.5, &random);
            nsdf_network_evaluate(&f.network, tables[0], f.scratch, xyz, expected, slope);
            for (int t = 0; t < count; t++) {
                guarded value = guarded_new(NSDF_TILE, width % 7), gradient = guarded_new(3 * NSDF_TILE, width % 3);
                nsdf_network_evaluate(&f.network, tables[t], f.scratch, xyz, value.data, gradient.data);
                for (int p = 0; p < NSDF_TILE; p++)
                    assert_true(fabsf(value.data[p] - expected[p]) <= 2e-5f);
                for (int p = 0; p < 3 * NSDF_TILE; p++) /* a kink of relu may lie between the two */
                    assert_true(shape == MAKE_TIME || shape == MAKE_FOURIER_SEED ||
                                fabsf(gradient.data[p] - slope[p]) <= 2e-4f * (1.0f + fabsf(slope[p])));
                guarded_check_free(&value);
                guarded_check_free(&gradient);
            }
            fixture_free(&f);
        }
    }
}

static void test_choice_follows_the_mask(void **state) {
    (void)state;
    assert_string_equal(nsdf_net_kernels_choose(0)->name, "c");
    if (nsdf_net_kernels_avx2())
        assert_string_equal(nsdf_net_kernels_choose(NSDF_CPU_AVX2)->name, "avx2");
    if (nsdf_net_kernels_avx512()) {
        assert_string_equal(nsdf_net_kernels_choose(NSDF_CPU_AVX512)->name, "avx512");
        assert_string_equal(nsdf_net_kernels_choose(NSDF_CPU_AVX512 | NSDF_CPU_AVX2)->name, "avx512");
    }
    if (nsdf_net_kernels_neon())
        assert_string_equal(nsdf_net_kernels_choose(NSDF_CPU_NEON)->name, "neon");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_linear_is_the_matrix_product),
        cmocka_unit_test(test_packing_is_a_permutation),
        cmocka_unit_test(test_sine_is_within_2e_7_up_to_1000_radians),
        cmocka_unit_test(test_tanh_is_within_2e_7),
        cmocka_unit_test(test_relu_identity_and_turn_are_exact_in_all_tables),
        cmocka_unit_test(test_extreme_inputs_stay_in_range),
        cmocka_unit_test(test_networks_agree_with_plain_c),
        cmocka_unit_test(test_choice_follows_the_mask),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
