/* Muon: singular values, steps, and what is left to Adam. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>

#include "muon.h"
#include "optimiser.h"
#include "random.h"

enum { MOST = 80 };

/* M becomes (1 - 2 v v^T) M: other singular vectors, the same values. */
static void reflect(float *m, uint32_t n, nsdf_random *random) {
    float v[MOST], square = 0.0f;
    for (uint32_t i = 0; i < n; i++) {
        v[i] = nsdf_random_normal(random);
        square += v[i] * v[i];
    }
    for (uint32_t c = 0; c < n; c++) {
        float dot = 0.0f;
        for (uint32_t r = 0; r < n; r++)
            dot += v[r] * m[r * n + c];
        for (uint32_t r = 0; r < n; r++)
            m[r * n + c] -= 2.0f * dot / square * v[r];
    }
}

static float *aligned(size_t count) {
    float *p = aligned_alloc(64, (count * sizeof(float) + 63) / 64 * 64);
    assert_non_null(p);
    return p;
}

/* A diagonal from 1 down to 1/20 between reflections of either side, whose results are reflections of the diagonal's:
 * the product of the result's transpose and itself has singular values squared on its eigenvectors. */
static void check_set(const nsdf_fit_kernels *kernels, uint32_t n) {
    nsdf_random random = nsdf_random_start(n, 1);
    float *m = aligned((size_t)n * n), *scratch = aligned(nsdf_muon_scratch(n));
    double trace = 0.0;
    for (uint32_t i = 0; i < n * n; i++)
        m[i] = i / n == i % n ? 1.0f - 0.95f * (float)(i / n) / (float)n : 0.0f;
    reflect(m, n, &random);
    nsdf_muon_orthogonalise(kernels, n, m, scratch);
    /* Columns stay orthogonal under a reflection from the left, and their lengths are the singular values. */
    for (uint32_t a = 0; a < n; a++)
        for (uint32_t b = 0; b < n; b++) {
            double dot = 0.0;
            for (uint32_t r = 0; r < n; r++)
                dot += (double)m[r * n + a] * (double)m[r * n + b];
            if (a == b)
                assert_true(dot > 0.4 && dot < 1.6);
            else
                assert_true(fabs(dot) < 1e-4);
            trace += a == b ? dot : 0.0;
        }
    assert_true(trace > 0.6 * n && trace < 1.4 * n);
    free(m);
    free(scratch);
}

static void test_singular_values_come_near_1(void **state) {
    const nsdf_fit_kernels *sets[] = {nsdf_fit_kernels_generic(), nsdf_fit_kernels_select()};
    const uint32_t sizes[] = {2, 16, 33, 64, 80};
    (void)state;
    for (int t = 0; t < 2; t++)
        for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
            check_set(sets[t], sizes[i]);
}

static void test_nothing_stays_nothing(void **state) {
    float m[16] = {0.0f}, *scratch = aligned(nsdf_muon_scratch(4));
    (void)state;
    nsdf_muon_orthogonalise(nsdf_fit_kernels_generic(), 4, m, scratch);
    for (int i = 0; i < 16; i++)
        assert_true(m[i] == 0.0f);
    free(scratch);
}

static void test_hidden_matrices_are_moved_and_nothing_else(void **state) {
    nsdf_model model;
    nsdf_encoder_options options;
    nsdf_muon muon;
    nsdf_adam adam;
    nsdf_random random = nsdf_random_start(1, 1);
    nsdf_workers *workers = nsdf_workers_create(2);
    (void)state;
    nsdf_encoder_options_init(&options, NSDF_PRESET_FAST);
    options.layers = 3;
    options.width = 24;
    nsdf_model_describe(&model, &options, 20);
    const size_t count = (size_t)model.parameter_count;
    float *before = calloc(count, sizeof *before), *after = calloc(count, sizeof *after);
    float *gradient = calloc(count, sizeof *gradient);
    assert_true(before && after && gradient && workers);
    for (size_t i = 0; i < count; i++)
        gradient[i] = nsdf_random_normal(&random);
    assert_int_equal(nsdf_muon_create(&muon, &model, nsdf_fit_kernels_select()), 0);
    assert_int_equal(nsdf_adam_create(&adam, count), 0);
    assert_int_equal(muon.count, 2);
    nsdf_muon_step(&muon, workers, after, gradient, 0.01);
    size_t moved = 0;
    for (uint32_t k = 0; k < muon.count; k++) {
        double square = 0.0;
        for (size_t i = 0; i < 24 * 24; i++) {
            const size_t at = muon.matrices[k].offset + i;
            square += (double)after[at] * (double)after[at];
            assert_true(gradient[at] == 0.0f);
            before[at] = after[at];
            moved += after[at] != 0.0f;
        }
        assert_true(sqrt(square / (24 * 24)) > 0.007 && sqrt(square / (24 * 24)) < 0.013);
    }
    assert_memory_equal(before, after, count * sizeof *after);
    assert_int_equal(moved, 2 * 24 * 24);
    nsdf_adam_step(&adam, after, gradient, 0.01);
    for (uint32_t k = 0; k < muon.count; k++)
        assert_memory_equal(before + muon.matrices[k].offset, after + muon.matrices[k].offset, 24 * 24 * sizeof(float));
    assert_true(after[0] != 0.0f);
    nsdf_adam_free(&adam);
    nsdf_muon_free(&muon);
    nsdf_workers_free(workers);
    free(before);
    free(after);
    free(gradient);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_singular_values_come_near_1),
        cmocka_unit_test(test_nothing_stays_nothing),
        cmocka_unit_test(test_hidden_matrices_are_moved_and_nothing_else),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
