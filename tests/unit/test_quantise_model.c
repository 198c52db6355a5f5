/* Quantisers of a model: step rules, rounding, and integers that come back from the file as the rounded parameters. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "fit_samples.h"
#include "network_write.h"
#include "quantise_model.h"

static nsdf_model describe(int kind) {
    const nsdf_encoder_options o = sample_model_options(kind, 2, 12);
    nsdf_model model;
    nsdf_model_describe(&model, &o, 9);
    return model;
}

/* Calls `check` for every array of every kind of model with its values. */
static void for_arrays(const nsdf_quantise_params *params,
                       void (*check)(const nsdf_array_desc *, const float *, const nsdf_quantise_params *)) {
    for (int kind = 0; kind < SAMPLE_MODELS; kind++) {
        nsdf_model m = describe(kind);
        float *values = random_parameters(&m, (uint64_t)kind);
        nsdf_choose_quantisers(&m, params, values);
        for (uint32_t t = 0; t < m.desc.list.count; t++)
            for (uint32_t a = 0; a < m.desc.list.tensors[t].array_count; a++)
                check(&m.desc.list.tensors[t].arrays[a], values + m.array_offset[t][a], params);
        free(values);
    }
}

static void check_rms_step(const nsdf_array_desc *a, const float *values, const nsdf_quantise_params *params) {
    const uint64_t count = nsdf_array_size(a);
    double squares = 0.0;
    for (uint64_t i = 0; i < count; i++)
        squares += (double)values[i] * (double)values[i];
    const double step = 6.0 * sqrt(squares / (double)count) / exp2(params->bits);
    assert_int_equal(a->quantiser, NSDF_QUANT_UNIFORM);
    assert_true(fabs((double)a->step - step) <= 1e-6 * step);
    assert_true(a->offset == 0.0f);
}

static void test_steps_follow_the_root_mean_square(void **state) {
    (void)state;
    for (double bits = 4.0; bits <= 16.0; bits += 1.5) {
        const nsdf_quantise_params params = {bits, 0};
        for_arrays(&params, check_rms_step);
    }
}

static void check_minmax(const nsdf_array_desc *a, const float *values, const nsdf_quantise_params *params) {
    const size_t count = (size_t)nsdf_array_size(a);
    int32_t *q = malloc(count * sizeof *q);
    assert_non_null(q);
    assert_int_equal(nsdf_quantise(values, count, a->step, a->offset, q), 0);
    int32_t low = q[0], high = q[0];
    for (size_t i = 0; i < count; i++) {
        low = q[i] < low ? q[i] : low;
        high = q[i] > high ? q[i] : high;
        const double error = fabs((double)nsdf_dequantise(q[i], a->step, a->offset) - (double)values[i]);
        assert_true(error <= 0.5001 * (double)a->step + 1e-6);
    }
    assert_int_equal(high - low, count == 1 ? 0 : (1 << (int)params->bits) - 1);
    free(q);
}

static void test_minmax_uses_all_levels_between_the_extremes(void **state) {
    (void)state;
    for (int bits = 4; bits <= 16; bits++) {
        const nsdf_quantise_params params = {bits, 1};
        for_arrays(&params, check_minmax);
    }
}

static void test_raw_arrays_keep_every_bit(void **state) {
    const nsdf_quantise_params raw = {32.0, 0};
    (void)state;
    for (int kind = 0; kind < SAMPLE_MODELS; kind++) {
        nsdf_model m = describe(kind);
        const size_t count = (size_t)m.parameter_count;
        float *values = random_parameters(&m, (uint64_t)kind), *rounded = random_floats(count, 1.0f, 1);
        int32_t *q = malloc(count * sizeof *q);
        assert_non_null(q);
        nsdf_choose_quantisers(&m, &raw, values);
        nsdf_round_parameters(&m, values, rounded);
        assert_memory_equal(rounded, values, count * sizeof *values);
        assert_int_equal(nsdf_quantise_parameters(&m, values, q), 0);
        assert_memory_equal(q, values, count * sizeof *values);
        free(values);
        free(rounded);
        free(q);
    }
}

/* ---- Rounding ------------------------------------------------------------------------------------------- */

/* What the integers stand for. */
static float *dequantised(const nsdf_model *m, const float *values) {
    const size_t count = (size_t)m->parameter_count;
    int32_t *q = malloc(count * sizeof *q);
    float *out = malloc(count * sizeof *out);
    assert_true(q && out);
    assert_int_equal(nsdf_quantise_parameters(m, values, q), 0);
    for (uint32_t t = 0; t < m->desc.list.count; t++)
        for (uint32_t k = 0; k < m->desc.list.tensors[t].array_count; k++) {
            const nsdf_array_desc *a = &m->desc.list.tensors[t].arrays[k];
            for (uint64_t i = 0, at = m->array_offset[t][k]; i < nsdf_array_size(a); i++, at++)
                out[at] = nsdf_dequantise(q[at], a->step, a->offset);
        }
    free(q);
    return out;
}

static void test_rounding_is_idempotent_and_agrees_with_the_integers(void **state) {
    (void)state;
    for (int kind = 0; kind < SAMPLE_MODELS; kind++)
        for (int bits = 4; bits <= 16; bits += 3)
            for (int minmax = 0; minmax < 2; minmax++) {
                const nsdf_quantise_params params = {bits, minmax};
                nsdf_model m = describe(kind);
                const size_t bytes = (size_t)m.parameter_count * sizeof(float);
                float *values = random_parameters(&m, (uint64_t)kind), *once = malloc(bytes), *twice = malloc(bytes);
                assert_true(once && twice);
                nsdf_choose_quantisers(&m, &params, values);
                float *integers = dequantised(&m, values);
                nsdf_round_parameters(&m, values, once);
                nsdf_round_parameters(&m, once, twice);
                assert_memory_equal(once, twice, bytes);
                assert_memory_equal(once, integers, bytes);
                free(values);
                free(once);
                free(twice);
                free(integers);
            }
}

/* Values half way between levels: any other arithmetic than the quantiser's would round some of them the other way,
 * and the hash in the file would not be that of its parameters. */
static void test_rounding_agrees_with_the_integers_at_ties(void **state) {
    nsdf_model m = describe(0);
    const size_t count = (size_t)m.parameter_count;
    float *values = random_floats(count, 0.0f, 0), *rounded = random_floats(count, 0.0f, 0);
    nsdf_random random = nsdf_random_start(9, 0);
    (void)state;
    for (int round = 0; round < 200; round++) {
        /* few bits, so that step * (q + 1/2) + offset is exact in a float */
        const float step = ldexpf((float)(2 * nsdf_random_below(&random, 2048) + 1), -14);
        const float offset = (float)nsdf_random_below(&random, 3) - 1.0f;
        for (uint32_t t = 0; t < m.desc.list.count; t++) {
            nsdf_array_desc *a = &m.desc.list.tensors[t].arrays[0];
            a->quantiser = NSDF_QUANT_UNIFORM;
            a->step = step;
            a->offset = offset;
        }
        for (size_t i = 0; i < count; i++)
            values[i] = step * ((float)nsdf_random_below(&random, 255) - 127.0f + 0.5f) + offset;
        float *integers = dequantised(&m, values);
        nsdf_round_parameters(&m, values, rounded);
        assert_memory_equal(rounded, integers, count * sizeof *rounded);
        free(integers);
    }
    free(values);
    free(rounded);
}

static void test_zero_arrays_stay_zero(void **state) {
    (void)state;
    for (int minmax = 0; minmax < 2; minmax++) {
        const nsdf_quantise_params params = {8.0, minmax};
        nsdf_model m = describe(2);
        float *values = random_floats((size_t)m.parameter_count, 0.0f, 0);
        float *rounded = random_floats((size_t)m.parameter_count, 1.0f, 1);
        nsdf_choose_quantisers(&m, &params, values);
        nsdf_round_parameters(&m, values, rounded);
        for (uint64_t i = 0; i < m.parameter_count; i++)
            assert_true(rounded[i] == 0.0f);
        free(values);
        free(rounded);
    }
}

static void test_values_that_cannot_be_stored_are_refused(void **state) {
    static const float bad[] = {NAN, INFINITY, 1e30f};
    const nsdf_quantise_params params = {16.0, 0};
    nsdf_model m = describe(0);
    float *values = random_parameters(&m, 1);
    int32_t *q = malloc((size_t)m.parameter_count * sizeof *q);
    (void)state;
    assert_non_null(q);
    nsdf_choose_quantisers(&m, &params, values);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const float kept = values[5];
        values[5] = bad[i];
        assert_int_equal(nsdf_quantise_parameters(&m, values, q), -1);
        values[5] = kept;
        assert_int_equal(nsdf_quantise_parameters(&m, values, q), 0);
    }
    free(values);
    free(q);
}

/* ---- Through the file ----------------------------------------------------------------------------------- */

static void check_file(int kind, const nsdf_quantise_params *params, nsdf_entropy_kind entropy) {
    nsdf_model m = describe(kind);
    const size_t count = (size_t)m.parameter_count;
    float *values = random_parameters(&m, (uint64_t)kind), *rounded = random_floats(count, 1.0f, 1);
    const nsdf_file_header header = unit_header(9);
    nsdf_coded_segment segment = {{NULL, 0, 0, 0}, 0};
    nsdf_buffer file = {NULL, 0, 0, 0};
    nsdf_decoder *decoder = NULL;
    nsdf_segment_info info;
    nsdf_info whole;
    m.desc.list.entropy = (uint8_t)entropy;
    nsdf_choose_quantisers(&m, params, values);
    nsdf_round_parameters(&m, values, rounded);
    assert_int_equal(nsdf_code_segment(&m, values, &segment), 0);
    assert_true(segment.hash == nsdf_hash_floats(NSDF_HASH_START, rounded, count));
    assert_int_equal(nsdf_assemble_file(&header, &(nsdf_index_entry){0}, &segment, NULL, &file), 0);
    assert_int_equal(nsdf_open_memory(&decoder, file.data, file.size, NULL, NULL), NSDF_OK);
    assert_int_equal(nsdf_verify(decoder), NSDF_OK); /* compares the stored hash with that of what it decodes */
    assert_int_equal(nsdf_get_segment_info(decoder, 0, &info), NSDF_OK);
    assert_int_equal(nsdf_get_info(decoder, &whole), NSDF_OK);
    assert_true(info.parameter_count == count && whole.frame_count == 9);
    assert_string_equal(info.entropy, nsdf_entropy_name(entropy));
    nsdf_close(&decoder);
    nsdf_buffer_free(&file);
    nsdf_buffer_free(&segment.payload);
    free(values);
    free(rounded);
}

static void test_decoders_get_the_rounded_parameters(void **state) {
    (void)state;
    for (int kind = 0; kind < SAMPLE_MODELS; kind++)
        for (int entropy = 0; entropy < NSDF_ENTROPY_COUNT; entropy++) {
            if (!nsdf_entropy_available((nsdf_entropy_kind)entropy))
                continue;
            check_file(kind, &(nsdf_quantise_params){4.0 + kind, 0}, (nsdf_entropy_kind)entropy);
            check_file(kind, &(nsdf_quantise_params){16.0 - kind, 1}, (nsdf_entropy_kind)entropy);
            check_file(kind, &(nsdf_quantise_params){32.0, 0}, (nsdf_entropy_kind)entropy);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_steps_follow_the_root_mean_square),
        cmocka_unit_test(test_minmax_uses_all_levels_between_the_extremes),
        cmocka_unit_test(test_raw_arrays_keep_every_bit),
        cmocka_unit_test(test_rounding_is_idempotent_and_agrees_with_the_integers),
        cmocka_unit_test(test_rounding_agrees_with_the_integers_at_ties),
        cmocka_unit_test(test_zero_arrays_stay_zero),
        cmocka_unit_test(test_values_that_cannot_be_stored_are_refused),
        cmocka_unit_test(test_decoders_get_the_rounded_parameters),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
