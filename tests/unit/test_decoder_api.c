/* The public functions on good files: arguments, sources, values, times, threads. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <stdio.h>
#include <unistd.h>

#include "make_file.h"
#include "nsdf/decoder.h"

enum { POINTS = 257 };

static void make_points(float *xyz, size_t count, double reach) {
    uint64_t random = 3;
    for (size_t i = 0; i < 3 * count; i++)
        xyz[i] = (float)(1.0 + (double)(i % 3) + reach * make_uniform(&random));
}

static nsdf_decoder *open_made(const made_file *file, const nsdf_decoder_options *options) {
    nsdf_decoder *decoder = NULL;
    nsdf_error error;
    const nsdf_status status = nsdf_open_memory(&decoder, file->data, file->size, options, &error);
    if (status != NSDF_OK)
        fail_msg("open: %d, %s at %llu: %s", (int)status, error.chunk, (unsigned long long)error.offset, error.message);
    return decoder;
}

static void test_version_is_that_of_the_header(void **state) {
    char text[32];
    (void)state;
    snprintf(text, sizeof text, "%d.%d.%d", NSDF_VERSION_MAJOR, NSDF_VERSION_MINOR, NSDF_VERSION_PATCH);
    assert_string_equal(nsdf_version_string(), text);
    assert_int_equal(nsdf_version(), NSDF_VERSION_MAJOR << 16 | NSDF_VERSION_MINOR << 8 | NSDF_VERSION_PATCH);
}

static void test_every_status_has_a_text_of_its_own(void **state) {
    const int known[] = {0, 10, 20, 21, 30, 40, 41, 42, 50, 51, 52, 60, 70, 90};
    (void)state;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        const char *text = nsdf_status_string((nsdf_status)known[i]);
        assert_string_not_equal(text, nsdf_status_string((nsdf_status)12345));
        assert_int_not_equal(text[strlen(text) - 1], '.');
        for (size_t k = 0; k < i; k++)
            assert_string_not_equal(text, nsdf_status_string((nsdf_status)known[k]));
    }
}

static void test_null_arguments_are_refused(void **state) {
    made_file file;
    nsdf_decoder *decoder = NULL;
    nsdf_mesh *mesh = NULL;
    nsdf_error error;
    const nsdf_io io = {NULL, NULL, 100};
    float f[3] = {0};
    double t;
    const char *key, *value;
    (void)state;
    make_file(&file, 1, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    assert_int_equal(nsdf_open_memory(NULL, file.data, file.size, NULL, &error), NSDF_INVALID_ARGUMENT);
    assert_int_equal(error.status, NSDF_INVALID_ARGUMENT);
    assert_true(error.message[0] != '\0');
    assert_int_equal(nsdf_open_memory(&decoder, NULL, 5, NULL, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_open_file(&decoder, NULL, NULL, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_open_callbacks(&decoder, NULL, NULL, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_open_callbacks(&decoder, &io, NULL, NULL), NSDF_INVALID_ARGUMENT);
    assert_null(decoder);
    decoder = open_made(&file, NULL);
    assert_int_equal(nsdf_get_info(decoder, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_get_info(NULL, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_evaluate(NULL, 0.0, f, 1, f, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_evaluate(decoder, 0.0, NULL, 1, f, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_evaluate(decoder, 0.0, f, 1, NULL, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_evaluate(decoder, 0.0, NULL, 0, NULL, NULL), NSDF_OK);
    assert_int_equal(nsdf_evaluate(decoder, (double)NAN, f, 1, f, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_get_error(decoder, &error), NSDF_OK);
    assert_int_equal(error.status, NSDF_INVALID_ARGUMENT);
    assert_true(error.message[0] != '\0');
    assert_int_equal(nsdf_prepare(NULL, 0.0), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_prepare(decoder, (double)NAN), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_verify(NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_frame_time(decoder, 5, &t), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_frame_time(decoder, 0, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_get_metadata(decoder, 2, &key, &value), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_get_segment_info(decoder, 0, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_extract_mesh(NULL, 0.0, NULL, &mesh), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_extract_mesh(decoder, 0.0, NULL, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_extract_mesh_into(decoder, 0.0, NULL, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_mesh_get_view(NULL, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_metadata_count(NULL), 0);
    nsdf_mesh_free(&mesh);
    nsdf_mesh_free(NULL);
    nsdf_close(&decoder);
    assert_null(decoder);
    nsdf_close(&decoder);
    nsdf_close(NULL);
    free_file(&file);
}

static void test_options_of_any_known_size_are_accepted(void **state) {
    made_file file;
    nsdf_decoder *decoder = NULL;
    nsdf_decoder_options options;
    (void)state;
    make_file(&file, 1, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    nsdf_decoder_options_init(&options);
    options.cpu_mask = 0;
    const size_t full = options.struct_size;
    assert_int_equal(full, sizeof options);
    options.struct_size = offsetof(nsdf_decoder_options, max_memory);
    options.max_memory = 1; /* behind the size given: must not be looked at */
    decoder = open_made(&file, &options);
    assert_string_equal(nsdf_kernel_name(decoder), "c");
    nsdf_close(&decoder);
    const size_t bad[] = {0, 1, full + 1, SIZE_MAX};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        options.struct_size = bad[i];
        assert_int_equal(nsdf_open_memory(&decoder, file.data, file.size, &options, NULL), NSDF_INVALID_ARGUMENT);
    }
    nsdf_decoder_options_init(&options);
    options.threads = 257;
    assert_int_equal(nsdf_open_memory(&decoder, file.data, file.size, &options, NULL), NSDF_INVALID_ARGUMENT);
    assert_null(decoder);
    free_file(&file);
}

static void test_info_repeats_the_header(void **state) {
    made_file file;
    nsdf_info info;
    nsdf_segment_info segment;
    const char *key, *value;
    (void)state;
    make_file(&file, 3, MAKE_SPLINE, NSDF_ENTROPY_NONE, 1);
    nsdf_decoder *decoder = open_made(&file, NULL);
    assert_int_equal(nsdf_get_info(decoder, &info), NSDF_OK);
    assert_int_equal(info.file_size, file.size);
    assert_int_equal(info.frame_count, 13);
    assert_int_equal(info.segment_count, 3);
    assert_true(info.duration == 12.0 * 1001.0 / 24000.0);
    assert_true(info.diagonal == 20.0 && info.box_min[1] == -3.0 && info.box_max[2] == 8.0);
    assert_true(info.domain_min[0] == 1.0 - 7.5 && info.domain_max[2] == 3.0 + 5.0);
    assert_int_equal(info.default_resolution, 12);
    assert_true(info.extraction_bound == 100.0);
    assert_true(info.quality.mean_to_decoded == 1e-4 && info.quality.max_to_input == 6e-4);
    assert_int_equal(info.quality.resolution, 128);
    assert_int_equal(info.parameter_count, 0);
    uint64_t parameters = 0;
    for (uint32_t i = 0; i < 3; i++) {
        assert_int_equal(nsdf_get_segment_info(decoder, i, &segment), NSDF_OK);
        assert_int_equal(segment.parameter_count, nsdf_parameter_count(&file.desc[i].list));
        assert_int_equal(segment.offset, file.entries[i].offset);
        assert_true(segment.start == 4.0 * i * 1001.0 / 24000.0);
        assert_int_equal(segment.layers, 3);
        assert_int_equal(segment.width, 12);
        assert_string_equal(segment.entropy, nsdf_entropy_name((nsdf_entropy_kind)file.desc[i].list.entropy));
        parameters += segment.parameter_count;
    }
    assert_int_equal(nsdf_get_segment_info(decoder, 3, &segment), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_get_info(decoder, &info), NSDF_OK);
    assert_int_equal(info.parameter_count, parameters);
    assert_int_equal(nsdf_metadata_count(decoder), 2);
    assert_int_equal(nsdf_get_metadata(decoder, 0, &key, &value), NSDF_OK);
    assert_string_equal(key, "title");
    assert_string_equal(value, "small");
    assert_int_equal(nsdf_get_metadata(decoder, 1, &key, &value), NSDF_OK);
    assert_string_equal(value, "");
    assert_int_equal(nsdf_verify(decoder), NSDF_OK);
    nsdf_close(&decoder);
    free_file(&file);
}

static void test_frame_times_are_rounded_once(void **state) {
    made_file file;
    (void)state;
    make_file(&file, 2, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    nsdf_decoder *decoder = open_made(&file, NULL);
    for (uint32_t i = 0; i < 9; i++) {
        double t;
        assert_int_equal(nsdf_frame_time(decoder, i, &t), NSDF_OK);
        assert_true(t == (double)i * 1001.0 / 24000.0);
    }
    nsdf_close(&decoder);
    free_file(&file);
}

/* Normalised position inside the domain -> reference in world units. */
static double reference_world(const made_file *file, uint32_t segment, double u, const float *xyz) {
    double x[3];
    for (int axis = 0; axis < 3; axis++)
        x[axis] = ((double)xyz[axis] - file->header.centre[axis]) / file->header.scale;
    return reference_value(&file->desc[segment], file->values[segment], u, x) * file->header.scale;
}

/* Every shape and back end, every segment, and the frame that two segments share: it belongs to the second. */
static void test_values_match_the_definition_at_any_time(void **state) {
    made_file file;
    float xyz[3 * 20], distance[20];
    (void)state;
    make_points(xyz, 20, 5.0);
    make_file(&file, 5, MAKE_SPLINE, NSDF_ENTROPY_NONE, 2);
    nsdf_decoder *decoder = open_made(&file, NULL);
    for (int quarter = -1; quarter <= 20 * 4 + 1; quarter++) {
        const double frame = quarter / 4.0, inside = frame < 0.0 ? 0.0 : frame > 20.0 ? 20.0 : frame;
        const uint32_t segment = inside >= 20.0 ? 4 : (uint32_t)(inside / 4.0);
        assert_int_equal(nsdf_evaluate(decoder, frame * 1001.0 / 24000.0, xyz, 20, distance, NULL), NSDF_OK);
        for (int i = 0; i < 20; i++) {
            const double expected = reference_world(&file, segment, inside / 4.0 - segment, xyz + 3 * i);
            assert_true(fabs((double)distance[i] - expected) < 1e-4);
        }
    }
    assert_int_equal(nsdf_evaluate(decoder, (double)INFINITY, xyz, 20, distance, NULL), NSDF_OK);
    assert_true(fabs((double)distance[0] - reference_world(&file, 4, 1.0, xyz)) < 1e-4);
    nsdf_close(&decoder);
    free_file(&file);
}

static void test_gradients_are_slopes_of_the_values(void **state) {
    made_file file;
    float xyz[3 * 50], distance[50], gradient[3 * 50];
    (void)state;
    make_points(xyz, 50, 4.0);
    make_file(&file, 1, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 4);
    nsdf_decoder *decoder = open_made(&file, NULL);
    assert_int_equal(nsdf_evaluate(decoder, 0.05, xyz, 50, distance, gradient), NSDF_OK);
    const double u = 0.05 * 24000.0 / 1001.0 / 4.0;
    for (int i = 0; i < 50; i++) {
        for (int axis = 0; axis < 3; axis++) {
            float up[3], down[3];
            memcpy(up, xyz + 3 * i, sizeof up);
            memcpy(down, xyz + 3 * i, sizeof down);
            up[axis] += 0.001f;
            down[axis] -= 0.001f;
            const double slope = (reference_world(&file, 0, u, up) - reference_world(&file, 0, u, down)) /
                                 ((double)up[axis] - (double)down[axis]);
            assert_true(fabs((double)gradient[3 * i + axis] - slope) < 1e-4);
        }
    }
    nsdf_close(&decoder);
    free_file(&file);
}

/* The header's rule, spelled out from two calls inside the domain. */
static void test_outside_the_domain_distances_grow(void **state) {
    made_file file;
    (void)state;
    make_file(&file, 1, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 4);
    nsdf_decoder *decoder = open_made(&file, NULL);
    const float edge[3] = {1.0f + 7.5f, 2.0f, 3.0f - 7.5f}, out[3] = {edge[0] + 3.0f, 2.0f, edge[2] - 4.0f};
    float at_edge, far, slope_edge[3], slope[3];
    assert_int_equal(nsdf_evaluate(decoder, 0.1, edge, 1, &at_edge, slope_edge), NSDF_OK);
    assert_int_equal(nsdf_evaluate(decoder, 0.1, out, 1, &far, slope), NSDF_OK);
    assert_true(fabsf(far - (5.0f + fmaxf(0.0f, at_edge))) < 1e-5f);
    assert_true(fabsf(slope[0] - 0.6f) < 1e-6f && fabsf(slope[2] + 0.8f) < 1e-6f);
    assert_true(fabsf(slope[1] - (at_edge > 0.0f ? slope_edge[1] : 0.0f)) < 1e-6f);
    const float bad[6] = {NAN, 0.0f, 0.0f, INFINITY, 0.0f, 0.0f};
    float results[2];
    assert_int_equal(nsdf_evaluate(decoder, 0.1, bad, 2, results, NULL), NSDF_OK);
    assert_true(isnan(results[0]) && isinf(results[1]));
    nsdf_close(&decoder);
    free_file(&file);
}

static void test_a_result_depends_on_its_point_only(void **state) {
    made_file file;
    static float xyz[3 * POINTS + 1], all[POINTS], one[POINTS + 2], slopes[3 * POINTS], slope[3];
    const uint32_t masks[] = {0, NSDF_CPU_AVX2, NSDF_CPU_ALL};
    (void)state;
    make_points(xyz + 1, POINTS, 8.0);
    for (int m = 0; m < 3; m++) {
        nsdf_decoder_options options;
        nsdf_decoder_options_init(&options);
        options.cpu_mask = masks[m];
        make_file(&file, 1, m, NSDF_ENTROPY_RANGE, 4);
        nsdf_decoder *decoder = open_made(&file, &options);
        assert_int_equal(nsdf_evaluate(decoder, 0.1, xyz + 1, POINTS, all, slopes), NSDF_OK);
        for (size_t count = 1; count <= POINTS; count += 16) {
            const size_t first = POINTS - count;
            one[0] = one[count + 1] = -77.0f;
            assert_int_equal(nsdf_evaluate(decoder, 0.1, xyz + 1 + 3 * first, count, one + 1, NULL), NSDF_OK);
            assert_memory_equal(one + 1, all + first, count * sizeof *all);
            assert_true(one[0] == -77.0f && one[count + 1] == -77.0f);
            assert_int_equal(nsdf_evaluate(decoder, 0.1, xyz + 1 + 3 * first, 1, one, slope), NSDF_OK);
            assert_memory_equal(slope, slopes + 3 * first, sizeof slope);
        }
        nsdf_close(&decoder);
        free_file(&file);
    }
}

typedef struct callback_source {
    const made_file *file;
    int calls, fail_at;
} callback_source;

static int read_made(void *user, uint64_t offset, void *dst, size_t size) {
    callback_source *source = user;
    if (++source->calls == source->fail_at || offset + size > source->file->size)
        return -1;
    memcpy(dst, source->file->data + offset, size);
    return 0;
}

static void evaluate_all(nsdf_decoder *decoder, const float *xyz, float *out) {
    for (int i = 0; i < 4; i++)
        assert_int_equal(nsdf_evaluate(decoder, 0.1 * i, xyz, POINTS, out + i * POINTS, NULL), NSDF_OK);
}

static void write_whole(const char *path, const made_file *file) {
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(file->data, 1, file->size, f), file->size);
    assert_int_equal(fclose(f), 0);
}

static void test_memory_file_and_callbacks_give_the_same(void **state) {
    made_file file;
    nsdf_decoder *decoder = NULL;
    nsdf_decoder_options options;
    nsdf_error error;
    static float xyz[3 * POINTS], expected[4 * POINTS], got[4 * POINTS];
    char path[64];
    (void)state;
    make_points(xyz, POINTS, 5.0);
    make_file(&file, 3, MAKE_SPLINE, NSDF_ENTROPY_NONE, 2);
    nsdf_decoder_options_init(&options);
    options.check_all = 1;
    decoder = open_made(&file, &options);
    evaluate_all(decoder, xyz, expected);
    nsdf_close(&decoder);
    snprintf(path, sizeof path, "test_decoder_api_%ld.nsdf", (long)getpid());
    write_whole(path, &file);
    assert_int_equal(nsdf_open_file(&decoder, path, &options, &error), NSDF_OK);
    assert_int_equal(remove(path), 0);
    evaluate_all(decoder, xyz, got);
    assert_memory_equal(got, expected, sizeof got);
    nsdf_close(&decoder);
    callback_source source = {&file, 0, 0};
    const nsdf_io io = {&source, read_made, file.size};
    assert_int_equal(nsdf_open_callbacks(&decoder, &io, &options, &error), NSDF_OK);
    evaluate_all(decoder, xyz, got);
    assert_memory_equal(got, expected, sizeof got);
    nsdf_close(&decoder);
    assert_int_equal(nsdf_open_file(&decoder, path, NULL, &error), NSDF_IO);
    assert_non_null(strstr(error.message, "no such file"));
    assert_int_equal(nsdf_open_file(&decoder, "/", NULL, &error), NSDF_IO);
    assert_null(decoder);
    free_file(&file);
}

static void run_backwards(void *user, uint32_t count, void (*task)(void *data, uint32_t index), void *data) {
    ++*(int *)user;
    for (uint32_t i = count; i-- > 0;)
        task(data, i);
}

static void test_threads_and_runners_change_nothing(void **state) {
    enum { MANY = 9999 };
    made_file file;
    static float xyz[3 * MANY], expected[MANY], got[MANY], slopes[3 * MANY], got_slopes[3 * MANY];
    int calls = 0;
    (void)state;
    make_points(xyz, MANY, 8.0);
    make_file(&file, 1, MAKE_FOURIER_STORED, NSDF_ENTROPY_RANGE, 4);
    for (uint32_t threads = 1; threads <= 5; threads++) {
        nsdf_decoder_options options;
        nsdf_decoder_options_init(&options);
        options.threads = threads;
        if (threads == 5)
            options.runner = (nsdf_task_runner){&calls, run_backwards};
        nsdf_decoder *decoder = open_made(&file, &options);
        assert_int_equal(
            nsdf_evaluate(decoder, 0.07, xyz, MANY, threads == 1 ? expected : got, threads == 1 ? slopes : got_slopes),
            NSDF_OK);
        nsdf_close(&decoder);
        if (threads > 1) {
            assert_memory_equal(got, expected, sizeof got);
            assert_memory_equal(got_slopes, slopes, sizeof slopes);
        }
    }
    assert_int_equal(calls, 1);
    free_file(&file);
}

static void test_what_was_decoded_before_changes_nothing(void **state) {
    made_file file;
    static float xyz[3 * POINTS], expected[POINTS], got[POINTS];
    (void)state;
    make_points(xyz, POINTS, 5.0);
    make_file(&file, 7, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 2);
    nsdf_decoder *decoder = open_made(&file, NULL);
    for (int i = 0; i < 14; i++) {
        const double t = 0.083 * i;
        nsdf_decoder *fresh = open_made(&file, NULL);
        assert_int_equal(nsdf_evaluate(fresh, t, xyz, POINTS, expected, NULL), NSDF_OK);
        nsdf_close(&fresh);
        for (int k = 0; k < 3; k++)
            assert_int_equal(nsdf_prepare(decoder, 0.31 * ((i * 5 + k) % 4)), NSDF_OK);
        assert_int_equal(nsdf_evaluate(decoder, t, xyz, POINTS, got, NULL), NSDF_OK);
        assert_memory_equal(got, expected, sizeof got);
    }
    nsdf_close(&decoder);
    free_file(&file);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_version_is_that_of_the_header),
        cmocka_unit_test(test_every_status_has_a_text_of_its_own),
        cmocka_unit_test(test_null_arguments_are_refused),
        cmocka_unit_test(test_options_of_any_known_size_are_accepted),
        cmocka_unit_test(test_info_repeats_the_header),
        cmocka_unit_test(test_frame_times_are_rounded_once),
        cmocka_unit_test(test_values_match_the_definition_at_any_time),
        cmocka_unit_test(test_gradients_are_slopes_of_the_values),
        cmocka_unit_test(test_outside_the_domain_distances_grow),
        cmocka_unit_test(test_a_result_depends_on_its_point_only),
        cmocka_unit_test(test_memory_file_and_callbacks_give_the_same),
        cmocka_unit_test(test_threads_and_runners_change_nothing),
        cmocka_unit_test(test_what_was_decoded_before_changes_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
