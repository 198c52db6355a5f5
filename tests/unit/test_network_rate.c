/* The rate of a network's parameters against its definition. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fit_samples.h"
#include "network_rate.h"
#include "quantise_model.h"

enum { FRAMES = 9 };

/* The definition in network_rate.h, in double. */
static double bits(const nsdf_model *m, const float *parameters) {
    double sum = 0.0;
    for (uint32_t t = 0; t < m->desc.list.count; t++)
        for (uint32_t k = 0; k < m->desc.list.tensors[t].array_count; k++) {
            const nsdf_array_desc *a = &m->desc.list.tensors[t].arrays[k];
            const size_t plane = (size_t)a->rows * a->cols, at = (size_t)m->array_offset[t][k];
            const int differences = m->desc.list.tensors[t].kind == NSDF_TENSOR_SPLINE;
            for (size_t i = differences ? plane : 0; i < a->planes * plane; i++) {
                const double before = differences ? (double)parameters[at + i - plane] : 0.0;
                const double steps = ((double)parameters[at + i] - before) / (double)a->step;
                sum += 0.5 * log2(1.0 + steps * steps);
            }
        }
    return sum / (double)m->parameter_count;
}

static nsdf_model make_model(int kind, float **parameters) {
    const nsdf_encoder_options o = sample_model_options(kind, 2, 7);
    const nsdf_quantise_params quantise = {8.0, 0};
    nsdf_model m;
    memset(&m, 0, sizeof m);
    nsdf_model_describe(&m, &o, FRAMES);
    *parameters = random_parameters(&m, (uint64_t)kind);
    nsdf_choose_quantisers(&m, &quantise, *parameters);
    return m;
}

static void test_the_gradient_is_that_of_the_mean_bits(void **state) {
    (void)state;
    for (int kind = 0; kind < SAMPLE_MODELS; kind++) {
        float *parameters;
        const nsdf_model m = make_model(kind, &parameters);
        float *gradient = random_floats(m.parameter_count, 0.0f, 0);
        const double weight = 100.0;
        double largest = 0.0;
        nsdf_network_add_rate(&m, parameters, weight, gradient);
        for (uint64_t i = 0; i < m.parameter_count; i++)
            largest = fmax(largest, fabs((double)gradient[i]));
        assert_true(largest > 0.0);
        for (uint64_t i = 0; i < m.parameter_count; i += 3) {
            const float kept = parameters[i], h = 0x1p-14f;
            parameters[i] = kept + h;
            const double up = bits(&m, parameters), high = (double)parameters[i];
            parameters[i] = kept - h;
            const double down = bits(&m, parameters), low = (double)parameters[i];
            parameters[i] = kept;
            assert_true(fabs((double)gradient[i] - weight * (up - down) / (high - low)) <= 2e-3 * largest);
        }
        free(gradient);
        free(parameters);
    }
}

static void test_values_without_a_step_have_no_rate(void **state) {
    const nsdf_quantise_params raw = {32.0, 0};
    float *parameters;
    (void)state;
    nsdf_model m = make_model(2, &parameters);
    float *gradient = random_floats(m.parameter_count, 0.0f, 0);
    nsdf_choose_quantisers(&m, &raw, parameters);
    nsdf_network_add_rate(&m, parameters, 1.0, gradient);
    for (uint64_t i = 0; i < m.parameter_count; i++)
        assert_true(gradient[i] == 0.0f);
    free(gradient);
    free(parameters);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_gradient_is_that_of_the_mean_bits),
        cmocka_unit_test(test_values_without_a_step_have_no_rate),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
