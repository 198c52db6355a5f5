/* Forward pass against the decoder and against the definition in double; gradients against finite differences. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "fit_network.h"
#include "fit_samples.h"
#include "make_file.h"
#include "quantise_model.h"

enum { FRAMES = 9, LAYERS = 3, WIDTH = 9, MAX_SETS = 3 };
static const nsdf_loss_params mae = {NSDF_LOSS_MAE, 0.02f, 0.01f, 200.0f, 1.0f};

static int list_sets(const nsdf_fit_kernels *sets[MAX_SETS]) {
    const nsdf_fit_kernels *best = nsdf_fit_kernels_exact();
    int count = 0;
    sets[count++] = nsdf_fit_kernels_generic();
    if (nsdf_fit_kernels_avx2() && best != sets[0]) /* what runs the best runs those before it */
        sets[count++] = nsdf_fit_kernels_avx2();
    if (best == nsdf_fit_kernels_avx512())
        sets[count++] = best;
    return count;
}

/* A model with its parameters, and points: everything that a pass needs. */
typedef struct fixture {
    nsdf_model model;
    float *parameters, *composed;
    nsdf_fit_scratch *scratch;
    float *xyz, *d;
    nsdf_fit_points points;
    double u;
} fixture;

static fixture make_wide_fixture(int kind, uint32_t width, size_t count, double u) {
    const nsdf_encoder_options o = sample_model_options(kind, LAYERS, width);
    fixture f;
    memset(&f, 0, sizeof f);
    nsdf_model_describe(&f.model, &o, FRAMES);
    f.model.desc.time_scale = 0.8f;
    f.model.desc.value_scale = 0.3f;
    f.model.desc.value_offset = 0.05f;
    f.parameters = random_parameters(&f.model, (uint64_t)kind);
    f.composed = random_floats(f.model.composed_size, 1.0f, 1);
    nsdf_model_compose(&f.model, f.parameters, u, f.composed);
    f.scratch = nsdf_fit_scratch_create(&f.model);
    f.xyz = random_floats(3 * count, 0.45f, (uint64_t)kind + 50);
    f.d = random_floats(count, 0.1f, (uint64_t)kind + 51);
    assert_non_null(f.scratch);
    f.points = (nsdf_fit_points){f.xyz, f.xyz + count, f.xyz + 2 * count, f.d, count, (float)(0.8 * u)};
    f.u = u;
    return f;
}

static fixture make_fixture(int kind, size_t count, double u) {
    return make_wide_fixture(kind, WIDTH, count, u);
}

static void free_fixture(fixture *f) {
    free(f->parameters);
    free(f->composed);
    free(f->xyz);
    free(f->d);
    nsdf_fit_scratch_free(f->scratch);
}

static double reference_at(const fixture *f, const float *parameters, size_t i) {
    const double p[3] = {(double)f->points.x[i], (double)f->points.y[i], (double)f->points.z[i]};
    return reference_value(&f->model.desc, parameters, f->u, p);
}

/* ---- Forward -------------------------------------------------------------------------------------------- */

static void test_forward_follows_the_definition_for_any_number_of_points(void **state) {
    static const size_t counts[] = {1, 31, 32, 33, 511, 512, 513, 1100};
    const nsdf_fit_kernels *sets[MAX_SETS];
    const int set_count = list_sets(sets);
    (void)state;
    for (int kind = 0; kind < SAMPLE_MODELS; kind++) {
        const size_t count = counts[kind % 8];
        fixture f = make_fixture(kind, count, 0.37);
        float *value = malloc((count + 1) * sizeof *value);
        assert_non_null(value);
        for (int s = 0; s < set_count; s++) {
            value[count] = 77.0f;
            nsdf_fit_forward(&f.model, sets[s], f.scratch, f.composed, &f.points, value);
            for (size_t i = 0; i < count; i++)
                assert_true(fabs((double)value[i] - reference_at(&f, f.parameters, i)) <= 5e-6);
            assert_true(value[count] == 77.0f);
        }
        free(value);
        free_fixture(&f);
    }
}

static nsdf_decoder *decoder_for(fixture *f, nsdf_buffer *file) {
    const nsdf_quantise_params raw = {32.0, 0};
    const nsdf_file_header header = unit_header(FRAMES);
    nsdf_coded_segment segment = {{NULL, 0, 0, 0}, 0};
    nsdf_decoder *decoder = NULL;
    nsdf_choose_quantisers(&f->model, &raw, f->parameters);
    assert_int_equal(nsdf_code_segment(&f->model, f->parameters, &segment), 0);
    assert_int_equal(nsdf_assemble_file(&header, &(nsdf_index_entry){0}, &segment, NULL, file), 0);
    nsdf_buffer_free(&segment.payload);
    assert_int_equal(nsdf_open_memory(&decoder, file->data, file->size, NULL, NULL), NSDF_OK);
    return decoder;
}

static void test_forward_equals_the_decoder(void **state) {
    enum { COUNT = 700 };
    (void)state;
    for (int kind = 0; kind < SAMPLE_MODELS; kind++)
        for (int step = 0; step <= 4; step++) {
            const double u = 0.25 * step;
            fixture f = make_fixture(kind, COUNT, u);
            nsdf_buffer file = {NULL, 0, 0, 0};
            nsdf_decoder *decoder = decoder_for(&f, &file);
            float packed[3 * COUNT], fitted[COUNT], decoded[COUNT];
            for (size_t i = 0; i < 3 * COUNT; i++)
                packed[i] = f.xyz[(i % 3) * COUNT + i / 3];
            nsdf_fit_forward(&f.model, nsdf_fit_kernels_exact(), f.scratch, f.composed, &f.points, fitted);
            assert_int_equal(nsdf_evaluate(decoder, u * (FRAMES - 1), packed, COUNT, decoded, NULL), NSDF_OK);
            for (size_t i = 0; i < COUNT; i++)
                assert_true(fabsf(fitted[i] - decoded[i]) <= 5e-6f);
            nsdf_close(&decoder);
            nsdf_buffer_free(&file);
            free_fixture(&f);
        }
}

/* ---- Gradients ------------------------------------------------------------------------------------------ */

/* Where parameter i of an all-constant model stands in the composed vector. */
static size_t composed_index(const nsdf_model *m, uint64_t i) {
    for (uint32_t t = 0; t < m->desc.list.count; t++) {
        const uint64_t at = m->array_offset[t][0], cols = m->desc.list.tensors[t].cols;
        if (i >= at + nsdf_array_size(&m->desc.list.tensors[t].arrays[0]))
            continue;
        const uint32_t first = nsdf_weight_index(&m->desc, 0), l = (t - first) / 2;
        if (t < first)
            return m->fourier_offset + (size_t)i;
        const size_t in = nsdf_layer_inputs(m, l), base = m->layer_offset[l];
        if ((t - first) % 2)
            return base + (size_t)(i - at) * (in + 1) + in;
        return base + (size_t)((i - at) / cols) * (in + 1) + (size_t)((i - at) % cols);
    }
    fail_msg("parameter %llu is in no tensor", (unsigned long long)i);
    return 0;
}

static double reference_sum(const fixture *f, const nsdf_loss_params *loss) {
    double sum = 0.0;
    for (size_t i = 0; i < f->points.count; i++) {
        const double error = fabs(reference_at(f, f->parameters, i) - (double)f->d[i]);
        const double weight = 1.0 / (1.0 + fabs((double)f->d[i]) / (double)loss->d0);
        sum += loss->kind == NSDF_LOSS_MAE ? error : weight * error;
    }
    return sum;
}

/* Central difference of the sum of losses in double; the step is what the float parameter really moves by. */
static double difference(fixture *f, const nsdf_loss_params *loss, uint64_t i) {
    const float kept = f->parameters[i], h = 0x1p-13f;
    f->parameters[i] = kept + h;
    const double up = reference_sum(f, loss), high = (double)f->parameters[i];
    f->parameters[i] = kept - h;
    const double down = reference_sum(f, loss), low = (double)f->parameters[i];
    f->parameters[i] = kept;
    return (up - down) / (high - low);
}

/* Distances well off the predictions, on the same side of zero, so that the losses are smooth there. */
static void move_distances(fixture *f) {
    for (size_t i = 0; i < f->points.count; i++) {
        const double value = reference_at(f, f->parameters, i);
        f->d[i] = (float)(value + (value < 0.0 ? -0.3 : 0.3));
    }
}

static void check_gradient(int kind, const nsdf_fit_kernels *kernels, const nsdf_loss_params *loss) {
    const float scale = 0.5f;
    fixture f = make_fixture(kind, 45, 0.6);
    float *gradient = calloc(f.model.composed_size, sizeof *gradient);
    nsdf_fit_sums sums = {0, 0, 0};
    double largest = 0.0;
    assert_non_null(gradient);
    move_distances(&f);
    nsdf_fit_backward(&f.model, kernels, f.scratch, f.composed, &f.points, loss, scale, gradient, NULL, &sums);
    assert_true(fabs(sums.loss - reference_sum(&f, loss)) <= 1e-5 * sums.loss);
    for (size_t i = 0; i < f.model.composed_size; i++)
        largest = fmax(largest, fabs((double)gradient[i]));
    assert_true(largest > 0.01);
    for (uint64_t i = 0; i < f.model.parameter_count; i++) {
        const size_t at = composed_index(&f.model, i);
        assert_true(fabs((double)gradient[at] - (double)scale * difference(&f, loss, i)) <= 2e-3 * largest);
        gradient[at] = 0.0f;
    }
    for (size_t i = 0; i < f.model.composed_size; i++) /* a B from the seed is no parameter */
        assert_true(gradient[i] == 0.0f);
    free(gradient);
    free_fixture(&f);
}

static void test_gradients_match_finite_differences(void **state) {
    const nsdf_loss_params weighted = {NSDF_LOSS_WEIGHTED_MAE, 0.2f, 0.01f, 200.0f, 3.0f};
    const nsdf_fit_kernels *sets[MAX_SETS];
    const int set_count = list_sets(sets);
    static const int constant_kinds[] = {0, 1, 6, 7, 8, 9, 10, 11};
    (void)state;
    for (size_t i = 0; i < sizeof constant_kinds / sizeof *constant_kinds; i++) {
        check_gradient(constant_kinds[i], sets[(int)i % set_count], &mae);
        check_gradient(constant_kinds[i], sets[((int)i + 1) % set_count], &weighted);
    }
}

/* Points are independent: one call for all adds what calls for stretches of them add. */
static void test_gradients_add_up_over_points_and_calls(void **state) {
    const nsdf_fit_kernels *sets[MAX_SETS];
    const int set_count = list_sets(sets);
    (void)state;
    for (int kind = 0; kind < SAMPLE_MODELS; kind++) {
        fixture f = make_fixture(kind, 777, 0.2);
        const size_t size = f.model.composed_size;
        float *whole = random_floats(size, 0.0f, 0), *parts = random_floats(size, 0.0f, 0);
        nsdf_fit_sums all = {0, 0, 0}, sum = {0, 0, 0};
        nsdf_fit_backward(&f.model, sets[kind % set_count], f.scratch, f.composed, &f.points, &mae, 1.0f, whole, NULL,
                          &all);
        for (size_t from = 0, count = 1; from < 777; from += count, count = 3 * count + 1) {
            const size_t n = count < 777 - from ? count : 777 - from;
            const nsdf_fit_points p = {f.points.x + from, f.points.y + from, f.points.z + from, f.points.d + from, n,
                                       f.points.time};
            nsdf_fit_backward(&f.model, sets[0], f.scratch, f.composed, &p, &mae, 1.0f, parts, NULL, &sum);
        }
        double largest = 0.0;
        for (size_t i = 0; i < size; i++)
            largest = fmax(largest, fabs((double)whole[i]));
        for (size_t i = 0; i < size; i++)
            assert_true(fabs((double)whole[i] - (double)parts[i]) <= 1e-4 * largest);
        assert_true(fabs(all.loss - sum.loss) <= 1e-5 * all.loss);
        assert_true(all.near_count == sum.near_count);
        free(whole);
        free(parts);
        free_fixture(&f);
    }
}

static void test_near_error_counts_points_near_the_surface_only(void **state) {
    fixture f = make_fixture(2, 300, 0.4);
    float *gradient = random_floats(f.model.composed_size, 0.0f, 0);
    nsdf_fit_sums sums = {10.0, 20.0, 30};
    double near = 20.0;
    uint64_t count = 30;
    (void)state;
    for (size_t i = 0; i < 300; i++) {
        f.d[i] *= 0.1f;
        if (fabsf(f.d[i]) >= NSDF_NEAR_LIMIT)
            continue;
        near += fabs(reference_at(&f, f.parameters, i) - (double)f.d[i]);
        count++;
    }
    nsdf_fit_backward(&f.model, nsdf_fit_kernels_exact(), f.scratch, f.composed, &f.points, &mae, 1.0f, gradient, NULL,
                      &sums);
    assert_true(count > 100 && count < 250);
    assert_true(sums.near_count == count);
    assert_true(fabs(sums.near_error - near) <= 1e-4);
    assert_true(fabs(sums.loss - 10.0 - reference_sum(&f, &mae)) <= 1e-3);
    free(gradient);
    free_fixture(&f);
}

/* Factors between hidden layers are then rounded to eight bits: the gradient keeps its direction. */
static void test_short_products_hardly_turn_the_gradient(void **state) {
    (void)state;
    for (int kind = 0; kind < SAMPLE_MODELS; kind++) {
        fixture f = make_wide_fixture(kind, 52, 700, 0.3);
        const size_t size = f.model.composed_size;
        float *exact = random_floats(size, 0.0f, 0), *rounded = random_floats(size, 0.0f, 0);
        nsdf_fit_sums sums = {0, 0, 0}, other = {0, 0, 0};
        double square = 0.0, difference_square = 0.0;
        move_distances(&f);
        nsdf_fit_backward(&f.model, nsdf_fit_kernels_exact(), f.scratch, f.composed, &f.points, &mae, 1.0f, exact, NULL,
                          &sums);
        nsdf_fit_backward(&f.model, nsdf_fit_kernels_select(), f.scratch, f.composed, &f.points, &mae, 1.0f, rounded,
                          NULL, &other);
        for (size_t i = 0; i < size; i++) {
            const double d = (double)rounded[i] - (double)exact[i];
            square += (double)exact[i] * (double)exact[i];
            difference_square += d * d;
        }
        assert_true(square > 0.0 && difference_square <= 4e-4 * square);
        assert_true(fabs(other.loss - sums.loss) <= 1e-2 * sums.loss);
        free(exact);
        free(rounded);
        free_fixture(&f);
    }
}

/* More points than the network is evaluated for at once, and not a multiple of it. */
static void test_the_loss_of_every_point_is_given(void **state) {
    enum { COUNT = 1100 };
    const nsdf_loss_params weighted = {NSDF_LOSS_WEIGHTED_MAE, 0.2f, 0.01f, 200.0f, 3.0f};
    const nsdf_fit_kernels *sets[MAX_SETS];
    const int set_count = list_sets(sets);
    (void)state;
    for (int s = 0; s < set_count; s++) {
        fixture f = make_fixture(s, COUNT, 0.8);
        float *gradient = random_floats(f.model.composed_size, 0.0f, 0), losses[COUNT + 1];
        nsdf_fit_sums sums = {0, 0, 0};
        double sum = 0.0;
        losses[COUNT] = 77.0f;
        nsdf_fit_backward(&f.model, sets[s], f.scratch, f.composed, &f.points, &weighted, 0.5f, gradient, losses,
                          &sums);
        for (size_t i = 0; i < COUNT; i++) {
            float slope;
            const float value = (float)reference_at(&f, f.parameters, i);
            const float expected = nsdf_loss_value(&weighted, value, f.d[i], &slope);
            assert_true(fabsf(value) < 1e-4f || fabsf(losses[i] - expected) <= 1e-5f);
            sum += (double)losses[i];
        }
        assert_true(losses[COUNT] == 77.0f);
        assert_true(fabs(sums.loss - sum) <= 1e-6 * sum);
        free(gradient);
        free_fixture(&f);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_forward_follows_the_definition_for_any_number_of_points),
        cmocka_unit_test(test_forward_equals_the_decoder),
        cmocka_unit_test(test_gradients_match_finite_differences),
        cmocka_unit_test(test_gradients_add_up_over_points_and_calls),
        cmocka_unit_test(test_short_products_hardly_turn_the_gradient),
        cmocka_unit_test(test_the_loss_of_every_point_is_given),
        cmocka_unit_test(test_near_error_counts_points_near_the_surface_only),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
