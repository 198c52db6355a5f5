/* Fitting kernels of every instruction set against sums and functions in double. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>

#include "cpu.h"
#include "fit_kernels.h"
#include "nsdf/decoder.h"
#include "random.h"

enum { GUARD = 32, LINE = 16 /* floats in 64 bytes */, MAX_SETS = 3 + NSDF_FIT_SHORT_SETS };
static const float guard_value = -12345.5f;
static const double rounding = 0x1p-23;         /* twice the error of one operation */
static const double short_rounding = 0x1.01p-7; /* of a product of two factors rounded to bf16 */

/* The sets that this machine can run. */
static int list_sets(const nsdf_fit_kernels *sets[MAX_SETS]) {
    const uint32_t features = nsdf_cpu_features();
    int count = 0;
    sets[count++] = nsdf_fit_kernels_generic();
    if (features & NSDF_CPU_AVX2 && nsdf_fit_kernels_avx2())
        sets[count++] = nsdf_fit_kernels_avx2();
    if (features & NSDF_CPU_AVX512 && nsdf_fit_kernels_avx512())
        sets[count++] = nsdf_fit_kernels_avx512();
    return count + (int)nsdf_fit_kernels_list_short(sets + count);
}

/* `count` floats at a multiple of 64 bytes, all of them and those around them guards. */
typedef struct guarded {
    float *block, *data;
    size_t count;
} guarded;

static guarded guarded_new(size_t count) {
    const size_t rounded = (count + LINE - 1) / LINE * LINE;
    guarded g = {aligned_alloc(64, (rounded + 2 * GUARD) * sizeof(float)), NULL, count};
    assert_non_null(g.block);
    g.data = g.block + GUARD;
    for (size_t i = 0; i < rounded + 2 * GUARD; i++)
        g.block[i] = guard_value;
    return g;
}

static void guarded_free(guarded *g) {
    for (size_t i = 0; i < GUARD; i++) {
        assert_true(g->block[i] == guard_value);
        assert_true(g->data[g->count + i] == guard_value);
    }
    free(g->block);
}

static float draw(nsdf_random *random, float range) {
    return range * (2.0f * nsdf_random_unit(random) - 1.0f);
}

/* Fills `rows` rows of every panel, and leaves the guards between the panels. */
static void fill_panels(guarded *g, size_t rows, size_t panel, uint32_t panels, nsdf_random *random) {
    for (size_t k = 0; k < panels; k++)
        for (size_t i = 0; i < rows * NSDF_PANEL; i++)
            g->data[k * panel + i] = draw(random, 1.0f);
}

/* Fills a matrix of rows `stride` apart. */
static void fill_matrix(guarded *g, size_t rows, size_t cols, size_t stride, nsdf_random *random) {
    for (size_t r = 0; r < rows; r++)
        for (size_t c = 0; c < cols; c++)
            g->data[r * stride + c] = draw(random, 1.0f);
}

typedef struct shape {
    uint32_t rows, cols, panels;
    size_t stride, x_panel, y_panel;
} shape;

static shape random_shape(nsdf_random *random, uint32_t rows, uint32_t cols, uint32_t panels) {
    shape s = {rows, cols, panels, cols + nsdf_random_below(random, 4), 0, 0};
    s.x_panel = (size_t)cols * NSDF_PANEL + LINE * (size_t)nsdf_random_below(random, 3);
    s.y_panel = (size_t)rows * NSDF_PANEL + LINE * (size_t)nsdf_random_below(random, 3);
    return s;
}

/* `factors` is what rounding them may cost, relative to a product. */
static void check_product(nsdf_fit_multiply *multiply, double factors, const shape *s, nsdf_random *random) {
    guarded a = guarded_new(s->rows * s->stride), x = guarded_new(s->panels * s->x_panel);
    guarded y = guarded_new(s->panels * s->y_panel);
    fill_matrix(&a, s->rows, s->cols, s->stride, random);
    fill_panels(&x, s->cols, s->x_panel, s->panels, random);
    multiply(a.data, s->stride, s->rows, s->cols, x.data, s->x_panel, y.data, s->y_panel, s->panels);
    for (size_t k = 0; k < s->panels; k++) {
        for (size_t o = 0; o < s->rows; o++)
            for (size_t p = 0; p < NSDF_PANEL; p++) {
                double sum = 0.0, magnitude = 0.0;
                for (size_t i = 0; i < s->cols; i++) {
                    const double w = (double)a.data[o * s->stride + i];
                    const double v = (double)x.data[k * s->x_panel + i * NSDF_PANEL + p];
                    sum += w * v;
                    magnitude += fabs(w * v);
                }
                const double got = (double)y.data[k * s->y_panel + o * NSDF_PANEL + p];
                assert_true(fabs(got - sum) <= (factors + rounding * (s->cols + 1.0)) * magnitude);
            }
        for (size_t i = (size_t)s->rows * NSDF_PANEL; i < s->y_panel; i++)
            assert_true(y.data[k * s->y_panel + i] == guard_value);
    }
    guarded_free(&a);
    guarded_free(&x);
    guarded_free(&y);
}

static void check_multiply(const nsdf_fit_kernels *set, const shape *s, nsdf_random *random) {
    check_product(set->multiply, 0.0, s, random);
}

static void check_multiply_short(const nsdf_fit_kernels *set, const shape *s, nsdf_random *random) {
    check_product(set->multiply_short, set->multiply_short == set->multiply ? 0.0 : short_rounding, s, random);
}

static void check_sums(nsdf_fit_outer *outer, double factors, const shape *s, nsdf_random *random) {
    guarded x = guarded_new(s->panels * s->x_panel), dz = guarded_new(s->panels * s->y_panel);
    guarded g = guarded_new(s->rows * s->stride), before = guarded_new(s->rows * s->stride);
    fill_panels(&x, s->cols, s->x_panel, s->panels, random);
    fill_panels(&dz, s->rows, s->y_panel, s->panels, random);
    fill_matrix(&before, s->rows, s->cols, s->stride, random);
    for (size_t i = 0; i < g.count; i++)
        g.data[i] = before.data[i];
    outer(dz.data, s->y_panel, s->rows, x.data, s->x_panel, s->cols, g.data, s->stride, s->panels);
    for (size_t o = 0; o < s->rows; o++) {
        for (size_t i = 0; i < s->cols; i++) {
            double sum = (double)before.data[o * s->stride + i], magnitude = fabs(sum);
            for (size_t k = 0; k < s->panels; k++)
                for (size_t p = 0; p < NSDF_PANEL; p++) {
                    const double term = (double)dz.data[k * s->y_panel + o * NSDF_PANEL + p] *
                                        (double)x.data[k * s->x_panel + i * NSDF_PANEL + p];
                    sum += term;
                    magnitude += fabs(term);
                }
            const double error = fabs((double)g.data[o * s->stride + i] - sum);
            assert_true(error <= (factors + rounding * (NSDF_PANEL * s->panels + 2.0)) * magnitude);
        }
        for (size_t i = s->cols; i < s->stride; i++)
            assert_true(g.data[o * s->stride + i] == guard_value);
    }
    guarded_free(&x);
    guarded_free(&dz);
    guarded_free(&g);
    guarded_free(&before);
}

static void check_outer(const nsdf_fit_kernels *set, const shape *s, nsdf_random *random) {
    check_sums(set->outer, 0.0, s, random);
}

static void check_outer_short(const nsdf_fit_kernels *set, const shape *s, nsdf_random *random) {
    check_sums(set->outer_short, set->outer_short == set->outer ? 0.0 : short_rounding, s, random);
}

/* All sets, on every size near a block's and on random ones. */
static void for_shapes(void (*check)(const nsdf_fit_kernels *, const shape *, nsdf_random *)) {
    static const uint32_t corners[][3] = {{1, 1, 1}, {1, 70, 5},   {70, 1, 5},   {70, 70, 2},   {16, 16, 1},
                                          {4, 4, 3}, {97, 96, 16}, {40, 49, 19}, {160, 160, 1}, {161, 170, 1}};
    const nsdf_fit_kernels *sets[MAX_SETS];
    const int count = list_sets(sets);
    for (int t = 0; t < count; t++) {
        nsdf_random random = nsdf_random_start(11, 0);
        for (size_t i = 0; i < sizeof corners / sizeof *corners; i++) {
            const shape s = random_shape(&random, corners[i][0], corners[i][1], corners[i][2]);
            check(sets[t], &s, &random);
        }
        for (uint32_t rows = 1; rows <= 70; rows++) {
            const uint32_t cols = 1 + nsdf_random_below(&random, 70), panels = 1 + nsdf_random_below(&random, 5);
            const shape s = random_shape(&random, rows, cols, panels);
            check(sets[t], &s, &random);
        }
    }
}

static void test_multiply_is_the_matrix_product_and_writes_nothing_else(void **state) {
    (void)state;
    for_shapes(check_multiply);
}

static void test_outer_adds_the_sum_over_points_and_writes_nothing_else(void **state) {
    (void)state;
    for_shapes(check_outer);
}

static void test_short_products_lose_no_more_than_bf16_does(void **state) {
    (void)state;
    for_shapes(check_multiply_short);
    for_shapes(check_outer_short);
}

enum { ANGLES = 64 * 1024 };

/* Random angles below 1000, then the floats around multiples of pi / 2, then small ones and zero. */
static void fill_angles(float *x) {
    nsdf_random random = nsdf_random_start(12, 0);
    for (int i = 0; i < ANGLES; i++)
        x[i] = draw(&random, 999.99f);
    for (int i = 0; i < 1200; i++)
        x[i] = nextafterf((float)(1.5707963267948966 * (i / 2)), i % 2 ? 2000.0f : -2000.0f);
    for (int i = 1200; i < 1300; i++)
        x[i] = ldexpf(i % 2 ? 1.0f : -1.0f, -(i - 1200));
    x[1300] = 0.0f;
    x[1301] = -0.0f;
}

/* `slack` is what rounding omega z itself may cost, per unit of omega z. */
static void check_sine(const nsdf_fit_kernels *set, float omega, double slack) {
    guarded z = guarded_new(ANGLES), slope = guarded_new(ANGLES), angle = guarded_new(ANGLES);
    fill_angles(angle.data);
    for (size_t i = 0; i < ANGLES; i++)
        z.data[i] = angle.data[i] = angle.data[i] / omega;
    set->sine(z.data, slope.data, ANGLES, omega);
    for (size_t i = 0; i < ANGLES; i++) {
        const double x = (double)angle.data[i] * (double)omega, allowed = 3e-7 + slack * fabs(x);
        assert_true(fabs((double)z.data[i] - sin(x)) <= allowed);
        assert_true(fabs((double)slope.data[i] / (double)omega - cos(x)) <= allowed + slack);
    }
    guarded_free(&z);
    guarded_free(&slope);
    guarded_free(&angle);
}

static void test_sine_and_cosine_keep_their_bound_below_a_thousand(void **state) {
    const nsdf_fit_kernels *sets[MAX_SETS];
    const int count = list_sets(sets);
    (void)state;
    for (int t = 0; t < count; t++) {
        check_sine(sets[t], 1.0f, 0.0);
        check_sine(sets[t], 64.0f, 0.0); /* products with it are exact */
        check_sine(sets[t], 30.0f, 0x1p-24);
        check_sine(sets[t], 6.28318530718f, 0x1p-24);
    }
}

static void test_tanh_and_its_slope(void **state) {
    const nsdf_fit_kernels *sets[MAX_SETS];
    const int count = list_sets(sets);
    (void)state;
    for (int t = 0; t < count; t++) {
        nsdf_random random = nsdf_random_start(13, 0);
        guarded z = guarded_new(8192), slope = guarded_new(8192), x = guarded_new(8192);
        for (size_t i = 0; i < x.count; i++)
            x.data[i] = draw(&random, i % 2 ? 12.0f : 1.0f);
        static const float special[] = {0.0f, INFINITY, -INFINITY, 1e30f, -1e30f, 10.0f, -10.0f, 1e-20f};
        for (size_t i = 0; i < sizeof special / sizeof *special; i++)
            x.data[i] = special[i];
        for (size_t i = 0; i < x.count; i++)
            z.data[i] = x.data[i];
        sets[t]->tanh(z.data, slope.data, z.count);
        for (size_t i = 0; i < z.count; i++) {
            const double y = tanh((double)x.data[i]);
            assert_true(fabs((double)z.data[i] - y) <= 3e-7);
            assert_true(fabs((double)slope.data[i] - (1.0 - y * y)) <= 6e-7);
        }
        guarded_free(&z);
        guarded_free(&slope);
        guarded_free(&x);
    }
}

static void test_relu_and_scale_are_exact(void **state) {
    const nsdf_fit_kernels *sets[MAX_SETS];
    const int count = list_sets(sets);
    (void)state;
    for (int t = 0; t < count; t++) {
        nsdf_random random = nsdf_random_start(14, 0);
        guarded x = guarded_new(3 * NSDF_PANEL), z = guarded_new(3 * NSDF_PANEL), slope = guarded_new(3 * NSDF_PANEL);
        for (size_t i = 0; i < x.count; i++)
            z.data[i] = x.data[i] = i < 4 ? (i % 2 ? -0.0f : 0.0f) : draw(&random, 5.0f);
        sets[t]->relu(z.data, slope.data, z.count);
        for (size_t i = 0; i < x.count; i++) {
            assert_true(z.data[i] == (x.data[i] > 0.0f ? x.data[i] : 0.0f));
            assert_true(slope.data[i] == (x.data[i] > 0.0f ? 1.0f : 0.0f));
        }
        for (size_t i = 0; i < x.count; i++)
            z.data[i] = draw(&random, 5.0f);
        guarded product = guarded_new(3 * NSDF_PANEL);
        for (size_t i = 0; i < x.count; i++)
            product.data[i] = z.data[i];
        sets[t]->scale(product.data, x.data, product.count);
        for (size_t i = 0; i < x.count; i++)
            assert_true(product.data[i] == z.data[i] * x.data[i]);
        guarded_free(&product);
        guarded_free(&x);
        guarded_free(&z);
        guarded_free(&slope);
    }
}

/* Short products are faster on some of the processors that have them. */
static void test_the_selected_set_is_the_best_that_runs_here(void **state) {
    const nsdf_fit_kernels *sets[MAX_SETS], *selected = nsdf_fit_kernels_select(), *shorts[NSDF_FIT_SHORT_SETS];
    const int all = list_sets(sets), count = all - (int)nsdf_fit_kernels_list_short(shorts);
    (void)state;
    assert_ptr_equal(nsdf_fit_kernels_exact(), sets[count - 1]);
    assert_true(selected == sets[count - 1] || selected == sets[all - 1]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_multiply_is_the_matrix_product_and_writes_nothing_else),
        cmocka_unit_test(test_outer_adds_the_sum_over_points_and_writes_nothing_else),
        cmocka_unit_test(test_short_products_lose_no_more_than_bf16_does),
        cmocka_unit_test(test_sine_and_cosine_keep_their_bound_below_a_thousand),
        cmocka_unit_test(test_tanh_and_its_slope),
        cmocka_unit_test(test_relu_and_scale_are_exact),
        cmocka_unit_test(test_the_selected_set_is_the_best_that_runs_here),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
