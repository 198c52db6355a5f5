/* Files that are cut and joined: what was in them stays, at its time. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "mux_file.h"
#include "mux_samples.h"

enum { POINTS = 32 };

static int refuse(void *user, const void *data, size_t size) {
    (void)user;
    (void)data;
    (void)size;
    return 1;
}

static nsdf_decoder *decode(const nsdf_mux *mux, nsdf_buffer *bytes) {
    nsdf_decoder *decoder = NULL;
    nsdf_encoder_error error;
    nsdf_error found;
    bytes->size = 0;
    assert_int_equal(nsdf_mux_write(mux, append, bytes, &error), NSDF_OK);
    if (nsdf_open_memory(&decoder, bytes->data, bytes->size, NULL, &found) != NSDF_OK)
        fail_msg("%s", found.message);
    assert_int_equal(nsdf_verify(decoder), NSDF_OK);
    return decoder;
}

static void evaluate_at(nsdf_decoder *decoder, double frame, float *values) {
    nsdf_info info;
    uint64_t random = 7;
    float xyz[3 * POINTS];
    assert_int_equal(nsdf_get_info(decoder, &info), NSDF_OK);
    for (int i = 0; i < 3 * POINTS; i++) {
        const double middle = 0.5 * (info.domain_min[i % 3] + info.domain_max[i % 3]);
        xyz[i] = (float)(middle + 0.4 * (info.domain_max[i % 3] - info.domain_min[i % 3]) * make_uniform(&random));
    }
    assert_int_equal(nsdf_evaluate(decoder, frame * info.rate_den / info.rate_num, xyz, POINTS, values, NULL), NSDF_OK);
}

/* Whether two files have the same surface at two frames. */
static void assert_same_at(nsdf_decoder *a, double frame_a, nsdf_decoder *b, double frame_b) {
    float values[2][POINTS];
    evaluate_at(a, frame_a, values[0]);
    evaluate_at(b, frame_b, values[1]);
    for (int i = 0; i < POINTS; i++)
        if (fabsf(values[0][i] - values[1][i]) > 1e-5f)
            fail_msg("frame %g has %.9g, frame %g of the other %.9g", frame_a, (double)values[0][i], frame_b,
                     (double)values[1][i]);
}

/* The same from the first to the last frame, in steps of a part of one. */
static void assert_same_until(const nsdf_mux *a, const nsdf_mux *b, double last, double step) {
    nsdf_buffer bytes[2] = {{NULL, 0, 0, 0}, {NULL, 0, 0, 0}};
    nsdf_decoder *x = decode(a, &bytes[0]), *y = decode(b, &bytes[1]);
    for (double f = 0.0; f <= last; f += step)
        assert_same_at(x, f, y, f);
    nsdf_close(&x);
    nsdf_close(&y);
    for (int i = 0; i < 2; i++)
        nsdf_buffer_free(&bytes[i]);
}

static void test_a_file_comes_out_as_it_went_in(void **state) {
    made_file file;
    nsdf_buffer bytes = {NULL, 0, 0, 0};
    nsdf_encoder_error error;
    (void)state;
    make_file(&file, 3, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    nsdf_mux *mux = open_mux(file.data, file.size);
    assert_int_equal(nsdf_mux_frame_count(mux), 13);
    assert_int_equal(nsdf_mux_segment_count(mux), 3);
    assert_int_equal(nsdf_mux_write(mux, append, &bytes, &error), NSDF_OK);
    assert_int_equal(bytes.size, file.size);
    assert_memory_equal(bytes.data, file.data, file.size);
    assert_int_equal(nsdf_mux_write(mux, refuse, NULL, &error), NSDF_IO);
    nsdf_mux_close(&mux);
    nsdf_buffer_free(&bytes);
    free_file(&file);
}

static void test_damage_is_refused_and_named(void **state) {
    made_file file;
    nsdf_mux *mux = NULL;
    nsdf_encoder_error error;
    (void)state;
    make_file(&file, 2, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    file.data[file.entries[1].offset + 40] ^= 1;
    assert_int_equal(nsdf_mux_open(&mux, file.data, file.size, &error), NSDF_CHECKSUM);
    assert_non_null(strstr(error.message, "SEGM"));
    assert_int_equal(nsdf_mux_open(&mux, file.data, 100, &error), NSDF_TRUNCATED);
    assert_int_equal(nsdf_mux_open(&mux, "text", 4, &error), NSDF_NOT_NSDF);
    assert_null(mux);
    free_file(&file);
}

static void test_a_cut_keeps_the_surface_at_its_time(void **state) {
    const uint32_t cuts[][2] = {{0, 12}, {0, 4}, {4, 8}, {3, 9}, {5, 7}, {6, 6}, {12, 12}, {0, 0}, {11, 12}};
    made_file file;
    nsdf_buffer bytes = {NULL, 0, 0, 0};
    nsdf_encoder_error error;
    nsdf_decoder *whole = NULL;
    (void)state;
    make_file(&file, 3, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    assert_int_equal(nsdf_open_memory(&whole, file.data, file.size, NULL, NULL), NSDF_OK);
    for (size_t i = 0; i < sizeof cuts / sizeof *cuts; i++) {
        nsdf_mux *mux = open_mux(file.data, file.size);
        assert_int_equal(nsdf_mux_cut(mux, cuts[i][0], cuts[i][1], &error), NSDF_OK);
        assert_int_equal(nsdf_mux_frame_count(mux), cuts[i][1] - cuts[i][0] + 1);
        nsdf_decoder *part = decode(mux, &bytes);
        /* The last frame may begin the next segment, which is left out; up to it all is equal. */
        for (double f = cuts[i][0]; f < cuts[i][1]; f += 0.25)
            assert_same_at(whole, f, part, f - cuts[i][0]);
        if (cuts[i][1] % 4 || cuts[i][1] == 12 || cuts[i][0] == cuts[i][1])
            assert_same_at(whole, cuts[i][1], part, cuts[i][1] - cuts[i][0]);
        nsdf_close(&part);
        nsdf_mux_close(&mux);
    }
    nsdf_mux *mux = open_mux(file.data, file.size);
    assert_int_equal(nsdf_mux_cut(mux, 3, 2, &error), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_mux_cut(mux, 0, 13, &error), NSDF_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "0 to 12"));
    nsdf_mux_close(&mux);
    nsdf_close(&whole);
    nsdf_buffer_free(&bytes);
    free_file(&file);
}

static void test_what_was_cut_in_two_joins_to_the_same_bytes(void **state) {
    made_file file;
    nsdf_buffer bytes = {NULL, 0, 0, 0};
    nsdf_encoder_error error;
    (void)state;
    make_file(&file, 3, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    nsdf_mux *whole = open_mux(file.data, file.size);
    nsdf_mux *head = open_part(&file, 0, 8), *tail = open_part(&file, 8, 12);
    assert_int_equal(nsdf_mux_segment_count(head), 2);
    assert_int_equal(nsdf_mux_append(head, tail, 0, &error), NSDF_OK);
    assert_int_equal(nsdf_mux_write(head, append, &bytes, &error), NSDF_OK);
    /* But for the measured errors, which are those of all frames. */
    assert_int_equal(bytes.size, file.size - 56 - NSDF_CHUNK_OVERHEAD);
    assert_same_until(whole, head, 12.0, 0.5);
    nsdf_mux_close(&whole);
    nsdf_mux_close(&head);
    nsdf_mux_close(&tail);
    nsdf_buffer_free(&bytes);
    free_file(&file);
}

/* Cut inside a segment, the models reach over the cut, and a cross-fade between equal models changes nothing. */
static void test_equal_models_cross_fade_unseen(void **state) {
    made_file file;
    nsdf_encoder_error error;
    (void)state;
    make_file(&file, 2, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 3);
    nsdf_mux *whole = open_mux(file.data, file.size);
    nsdf_mux *head = open_part(&file, 0, 2), *tail = open_part(&file, 2, 8);
    assert_int_equal(nsdf_mux_append(head, tail, 3, &error), NSDF_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "cross-fade of 3 frames"));
    assert_int_equal(nsdf_mux_append(head, tail, 2, &error), NSDF_OK);
    assert_int_equal(nsdf_mux_segment_count(head), 3);
    assert_same_until(whole, head, 8.0, 0.125);
    nsdf_mux_close(&whole);
    nsdf_mux_close(&head);
    nsdf_mux_close(&tail);
    free_file(&file);
}

static void test_a_held_frame_stands_still_and_loses_none(void **state) {
    made_file files[2];
    nsdf_buffer bytes[3] = {{NULL, 0, 0, 0}, {NULL, 0, 0, 0}, {NULL, 0, 0, 0}};
    nsdf_decoder *decoders[3];
    nsdf_mux *mux[2];
    nsdf_encoder_error error;
    (void)state;
    for (uint64_t i = 0; i < 2; i++) {
        make_file(&files[i], 2, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 5 + i);
        mux[i] = open_mux(files[i].data, files[i].size);
        decoders[i] = decode(mux[i], &bytes[i]);
    }
    assert_int_equal(nsdf_mux_hold(mux[0], 1, &error), NSDF_OK);
    assert_int_equal(nsdf_mux_append(mux[0], mux[1], 0, &error), NSDF_OK);
    assert_int_equal(nsdf_mux_frame_count(mux[0]), 18);
    decoders[2] = decode(mux[0], &bytes[2]);
    for (int i = 0; i <= 8; i++) {
        assert_same_at(decoders[2], i, decoders[0], i);
        assert_same_at(decoders[2], 9 + i, decoders[1], i);
    }
    assert_same_at(decoders[2], 8.75, decoders[0], 8);
    for (int i = 0; i < 3; i++) {
        nsdf_close(&decoders[i]);
        nsdf_buffer_free(&bytes[i]);
    }
    for (int i = 0; i < 2; i++) {
        nsdf_mux_close(&mux[i]);
        free_file(&files[i]);
    }
}

static void set_quality(nsdf_mux *mux, double error, uint32_t frames, uint32_t resolution) {
    mux->has_quality = 1;
    mux->quality =
        (nsdf_quality_record){{error, 2 * error}, {error, 2 * error}, {3 * error, 4 * error}, resolution, frames};
}

/* Joins files of 5 and 9 measured frames after holding the first one's last frame. */
static nsdf_mux *join_measured(uint32_t held, uint32_t resolution) {
    made_file file;
    nsdf_encoder_error error;
    make_file(&file, 1, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    nsdf_mux *a = open_mux(file.data, file.size), *b = open_mux(file.data, file.size);
    set_quality(a, 1.0, 5, 64);
    set_quality(b, 3.0, 9, resolution);
    assert_int_equal(nsdf_mux_hold(a, held, &error), NSDF_OK);
    assert_int_equal(nsdf_mux_append(a, b, 0, &error), NSDF_OK);
    nsdf_mux_close(&b);
    free_file(&file);
    return a;
}

static void test_measured_errors_are_joined_by_frames(void **state) {
    nsdf_quality q;
    nsdf_encoder_error error;
    (void)state;
    nsdf_mux *mux = join_measured(0, 64); /* 5 frames of 1, and 8 of 3: one is shared */
    assert_int_equal(nsdf_mux_get_quality(mux, &q), NSDF_OK);
    assert_int_equal(q.frames, 13);
    assert_int_equal(q.resolution, 64);
    assert_true(fabs(q.mean_to_decoded - 29.0 / 13.0) < 1e-12);
    assert_true(fabs(q.mean_to_input - 58.0 / 13.0) < 1e-12);
    assert_true(fabs(q.rms_to_decoded - sqrt(77.0 / 13.0)) < 1e-12);
    assert_true(fabs(q.max_to_input - 12.0) < 1e-12);
    assert_int_equal(nsdf_mux_cut(mux, 0, nsdf_mux_frame_count(mux) - 1, &error), NSDF_OK);
    assert_int_equal(nsdf_mux_get_quality(mux, &q), NSDF_OK);
    assert_int_equal(nsdf_mux_cut(mux, 1, 3, &error), NSDF_OK);
    assert_int_equal(nsdf_mux_get_quality(mux, &q), NSDF_INVALID_ARGUMENT);
    nsdf_mux_close(&mux);
    mux = join_measured(1, 64); /* none is shared */
    assert_int_equal(nsdf_mux_get_quality(mux, &q), NSDF_OK);
    assert_int_equal(q.frames, 14);
    assert_true(fabs(q.mean_to_decoded - 32.0 / 14.0) < 1e-12);
    nsdf_mux_close(&mux);
    mux = join_measured(0, 65);
    assert_int_equal(nsdf_mux_get_quality(mux, &q), NSDF_INVALID_ARGUMENT);
    nsdf_mux_close(&mux);
}

static void test_files_of_other_boxes_are_refused(void **state) {
    made_file file;
    nsdf_encoder_error error;
    (void)state;
    make_file(&file, 1, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    nsdf_mux *a = open_mux(file.data, file.size), *b = open_mux(file.data, file.size);
    nsdf_file_header header = file.header;
    nsdf_buffer payload = {NULL, 0, 0, 0}, bytes = {NULL, 0, 0, 0};
    header.scale = 21.0;
    nsdf_write_header(&payload, &header);
    nsdf_write_preamble(&bytes);
    nsdf_write_chunk(&bytes, NSDF_CHUNK_HEAD, NSDF_CHUNK_CRITICAL, payload.data, payload.size);
    nsdf_buffer_append(&bytes, file.data + bytes.size, file.size - bytes.size);
    nsdf_mux *c = open_mux(bytes.data, bytes.size);
    assert_int_equal(nsdf_mux_append(a, c, 0, &error), NSDF_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "boxes differ"));
    assert_int_equal(nsdf_mux_append(a, a, 0, &error), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_mux_append(a, b, 0, &error), NSDF_OK);
    nsdf_mux_close(&a);
    nsdf_mux_close(&b);
    nsdf_mux_close(&c);
    nsdf_buffer_free(&payload);
    nsdf_buffer_free(&bytes);
    free_file(&file);
}

/* Chunks "aAAA", "bBBB", ... in front of segments 0, 1 and behind the last. */
static void test_unknown_chunks_stay_with_their_segments(void **state) {
    made_file file;
    nsdf_buffer payloads[2] = {{NULL, 0, 0, 0}, {NULL, 0, 0, 0}}, bytes = {NULL, 0, 0, 0};
    nsdf_loose_chunk others[3];
    nsdf_encoder_error error;
    (void)state;
    make_file(&file, 2, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    for (uint32_t i = 0; i < 3; i++) {
        others[i] = (nsdf_loose_chunk){NSDF_CHUNK('a' + i, 'X', 'X', 'X'), 2, i, {NULL, 0, 0, 0}};
        nsdf_buffer_append(&others[i].payload, "payload", i);
    }
    for (int i = 0; i < 2; i++)
        nsdf_buffer_append(&payloads[i], file.data + file.entries[i].offset + NSDF_CHUNK_HEADER_SIZE,
                           (size_t)file.entries[i].size - NSDF_CHUNK_OVERHEAD);
    nsdf_file_parts parts = {file.header, payloads, file.entries, NULL, NULL, others, 3};
    assert_int_equal(nsdf_write_file(&bytes, &parts), 0);
    nsdf_mux *mux = open_mux(bytes.data, bytes.size);
    nsdf_buffer out = {NULL, 0, 0, 0};
    assert_int_equal(nsdf_mux_write(mux, append, &out, &error), NSDF_OK);
    assert_int_equal(out.size, bytes.size);
    assert_memory_equal(out.data, bytes.data, bytes.size);
    assert_int_equal(nsdf_mux_cut(mux, 4, 8, &error), NSDF_OK);
    nsdf_decoder *decoder = decode(mux, &out);
    nsdf_close(&decoder);
    const char *const kept[3] = {"aXXX", "bXXX", "cXXX"};
    for (int i = 0; i < 3; i++) {
        int found = 0;
        for (size_t at = 0; at + 4 <= out.size; at++)
            found |= memcmp(out.data + at, kept[i], 4) == 0;
        assert_int_equal(found, i > 0);
    }
    nsdf_mux_close(&mux);
    for (int i = 0; i < 3; i++)
        nsdf_buffer_free(&others[i].payload);
    for (int i = 0; i < 2; i++)
        nsdf_buffer_free(&payloads[i]);
    nsdf_buffer_free(&bytes);
    nsdf_buffer_free(&out);
    free_file(&file);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_file_comes_out_as_it_went_in),
        cmocka_unit_test(test_damage_is_refused_and_named),
        cmocka_unit_test(test_a_cut_keeps_the_surface_at_its_time),
        cmocka_unit_test(test_what_was_cut_in_two_joins_to_the_same_bytes),
        cmocka_unit_test(test_equal_models_cross_fade_unseen),
        cmocka_unit_test(test_a_held_frame_stands_still_and_loses_none),
        cmocka_unit_test(test_measured_errors_are_joined_by_frames),
        cmocka_unit_test(test_files_of_other_boxes_are_refused),
        cmocka_unit_test(test_unknown_chunks_stay_with_their_segments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
