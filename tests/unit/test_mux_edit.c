/* Files whose segments, rate and metadata are changed; pieces that become one again. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "mux_samples.h"

/* What is written is sound, too. */
static nsdf_buffer bytes_of(const nsdf_mux *mux) {
    nsdf_buffer bytes = {NULL, 0, 0, 0};
    nsdf_encoder_error error;
    nsdf_decoder *decoder = NULL;
    assert_int_equal(nsdf_mux_write(mux, append, &bytes, &error), NSDF_OK);
    assert_int_equal(nsdf_open_memory(&decoder, bytes.data, bytes.size, NULL, NULL), NSDF_OK);
    assert_int_equal(nsdf_verify(decoder), NSDF_OK);
    nsdf_close(&decoder);
    return bytes;
}

static void assert_same(const nsdf_mux *a, const nsdf_mux *b) {
    nsdf_buffer x = bytes_of(a), y = bytes_of(b);
    assert_int_equal(x.size, y.size);
    assert_memory_equal(x.data, y.data, x.size);
    nsdf_buffer_free(&x);
    nsdf_buffer_free(&y);
}

/* The file without its measured errors, which a cut takes away. */
static nsdf_mux *open_unmeasured(const made_file *file) {
    nsdf_encoder_error error;
    nsdf_mux *mux = open_mux(file->data, file->size);
    const uint32_t last = nsdf_mux_frame_count(mux) - 1;
    assert_int_equal(nsdf_mux_hold(mux, 1, &error), NSDF_OK);
    assert_int_equal(nsdf_mux_cut(mux, 0, last, &error), NSDF_OK);
    return mux;
}

static void pieces_of_a_segment_become_one(void **state) {
    made_file file;
    nsdf_encoder_error error;
    (void)state;
    make_file(&file, 3, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    nsdf_mux *whole = open_unmeasured(&file);
    for (uint32_t at = 1; at < 12; at++) {
        nsdf_mux *head = open_part(&file, 0, at), *tail = open_part(&file, at, 12);
        assert_int_equal(nsdf_mux_append(head, tail, at % 2 ? 0 : NSDF_MUX_FADE_AUTO, &error), NSDF_OK);
        assert_same(head, whole);
        nsdf_mux_close(&head);
        nsdf_mux_close(&tail);
    }
    nsdf_mux_close(&whole);
    free_file(&file);
}

/* One frame later, or another part of the model: that is another segment. */
static void other_pieces_stay_apart(void **state) {
    made_file file;
    nsdf_encoder_error error;
    (void)state;
    make_file(&file, 1, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    nsdf_mux *head = open_part(&file, 0, 2), *tail = open_part(&file, 1, 4);
    assert_int_equal(nsdf_mux_append(head, tail, NSDF_MUX_FADE_AUTO, &error), NSDF_OK);
    assert_int_equal(nsdf_mux_segment_count(head), 2);
    nsdf_mux_segment s;
    assert_int_equal(nsdf_mux_get_segment(head, 1, &s), NSDF_OK);
    assert_int_equal(s.first_frame, 2);
    assert_int_equal(s.last_frame, 5);
    assert_int_equal(s.lead, 1);
    assert_int_equal(s.trail, 0);
    assert_int_equal(s.fade, 1); /* as far as `lead` reaches */
    assert_int_equal(nsdf_mux_get_segment(head, 2, &s), NSDF_INVALID_ARGUMENT);
    nsdf_mux_close(&head);
    nsdf_mux_close(&tail);
    free_file(&file);
}

static void segments_are_replaced(void **state) {
    made_file file, other;
    nsdf_encoder_error error;
    (void)state;
    make_file(&file, 3, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    make_file(&other, 3, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 9);
    nsdf_mux *whole = open_unmeasured(&file);
    for (uint32_t first = 0; first < 3; first++)
        for (uint32_t last = first; last < 3; last++) {
            nsdf_mux *mux = open_mux(file.data, file.size);
            nsdf_mux *mine = open_part(&file, 4 * first, 4 * last + 4);
            nsdf_mux *theirs = open_part(&other, 4 * first, 4 * last + 4);
            assert_int_equal(nsdf_mux_replace(mux, first, last, theirs, &error), NSDF_OK);
            for (uint32_t i = 0; i < 3; i++) {
                nsdf_mux_segment s;
                const int replaced = i >= first && i <= last;
                assert_int_equal(nsdf_mux_get_segment(mux, i, &s), NSDF_OK);
                assert_int_equal(s.first_frame, 4 * i);
                assert_true(s.parameter_hash == (replaced ? &other : &file)->entries[i].parameter_hash);
            }
            assert_int_equal(nsdf_mux_replace(mux, first, last, mine, &error), NSDF_OK);
            assert_same(mux, whole);
            nsdf_mux_close(&mux);
            nsdf_mux_close(&mine);
            nsdf_mux_close(&theirs);
        }
    nsdf_mux_close(&whole);
    free_file(&file);
    free_file(&other);
}

static void what_does_not_fit_replaces_nothing(void **state) {
    made_file file;
    nsdf_encoder_error error;
    (void)state;
    make_file(&file, 3, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    nsdf_mux *mux = open_unmeasured(&file), *whole = open_unmeasured(&file), *part = open_part(&file, 4, 9);
    assert_int_equal(nsdf_mux_replace(mux, 1, 1, part, &error), NSDF_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "the segments have 5 frames, and the other file has 6"));
    assert_int_equal(nsdf_mux_replace(mux, 1, 3, part, &error), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_mux_replace(mux, 2, 1, part, &error), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_mux_cut(part, 0, 4, &error), NSDF_OK);
    assert_int_equal(nsdf_mux_set_rate(part, 25, 1, &error), NSDF_OK);
    assert_int_equal(nsdf_mux_replace(mux, 1, 1, part, &error), NSDF_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "frame rates differ"));
    assert_same(mux, whole);
    nsdf_mux_close(&mux);
    nsdf_mux_close(&whole);
    nsdf_mux_close(&part);
    free_file(&file);
}

static void a_cross_fade_is_as_long_as_a_replacement_reaches(void **state) {
    made_file file;
    nsdf_encoder_error error;
    nsdf_mux_segment s;
    (void)state;
    make_file(&file, 2, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 3);
    /* Frames 0 to 3 and 3 to 8, with a cross-fade of 2; the first model reaches a frame beyond, the second three. */
    nsdf_mux *mux = open_part(&file, 0, 2), *tail = open_part(&file, 2, 8);
    assert_int_equal(nsdf_mux_append(mux, tail, 2, &error), NSDF_OK);
    nsdf_mux *part = open_part(&file, 1, 3);
    assert_int_equal(nsdf_mux_replace(mux, 0, 0, part, &error), NSDF_OK);
    assert_int_equal(nsdf_mux_get_segment(mux, 1, &s), NSDF_OK);
    assert_int_equal(s.fade, 1);
    nsdf_buffer bytes = bytes_of(mux);
    nsdf_buffer_free(&bytes);
    nsdf_mux_close(&mux);
    nsdf_mux_close(&tail);
    nsdf_mux_close(&part);
    free_file(&file);
}

static void a_rate_changes_times_only(void **state) {
    made_file file;
    nsdf_encoder_error error;
    uint32_t num = 0, den = 0;
    (void)state;
    make_file(&file, 2, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    nsdf_mux *mux = open_mux(file.data, file.size);
    assert_int_equal(nsdf_mux_set_rate(mux, 0, 1, &error), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_mux_set_rate(mux, 1, 0, &error), NSDF_INVALID_ARGUMENT);
    nsdf_mux_get_rate(mux, &num, &den);
    assert_int_equal(num, 24000);
    assert_int_equal(den, 1001);
    assert_int_equal(nsdf_mux_set_rate(mux, 50, 1, &error), NSDF_OK);
    nsdf_buffer bytes = bytes_of(mux);
    assert_int_equal(bytes.size, file.size);
    uint32_t changed = 0;
    for (size_t i = 0; i < bytes.size; i++)
        changed += bytes.data[i] != file.data[i];
    assert_in_range(changed, 3, 12); /* two numbers and a CRC-32 */
    nsdf_buffer_free(&bytes);
    nsdf_mux_close(&mux);
    free_file(&file);
}

static void assert_pair(const nsdf_mux *mux, uint32_t index, const char *key, const char *value) {
    const char *k, *v;
    assert_int_equal(nsdf_mux_get_metadata(mux, index, &k, &v), NSDF_OK);
    assert_string_equal(k, key);
    assert_string_equal(v, value);
}

static void metadata_are_set_and_removed(void **state) {
    made_file file;
    nsdf_encoder_error error;
    const char *k, *v;
    (void)state;
    make_file(&file, 1, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    nsdf_mux *mux = open_mux(file.data, file.size);
    assert_int_equal(nsdf_mux_metadata_count(mux), 2);
    assert_int_equal(nsdf_mux_set_metadata(mux, "who", "\xc3\xa4", &error), NSDF_OK);
    assert_int_equal(nsdf_mux_set_metadata(mux, "title", "large", &error), NSDF_OK);
    assert_int_equal(nsdf_mux_metadata_count(mux), 3);
    assert_pair(mux, 0, "title", "large");
    assert_pair(mux, 1, "empty", "");
    assert_pair(mux, 2, "who", "\xc3\xa4");
    assert_int_equal(nsdf_mux_get_metadata(mux, 3, &k, &v), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_mux_set_metadata(mux, "", "x", &error), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_mux_set_metadata(mux, "x", "\xff", &error), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_mux_set_metadata(mux, "\xc0\x80", "x", &error), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_mux_metadata_count(mux), 3);
    nsdf_buffer bytes = bytes_of(mux);
    nsdf_mux *again = open_mux(bytes.data, bytes.size);
    assert_pair(again, 2, "who", "\xc3\xa4");
    nsdf_mux_close(&again);
    nsdf_buffer_free(&bytes);
    static const char *const keys[] = {"none", "title", "who", "empty"};
    for (int i = 0; i < 4; i++)
        assert_int_equal(nsdf_mux_set_metadata(mux, keys[i], NULL, &error), NSDF_OK);
    assert_int_equal(nsdf_mux_metadata_count(mux), 0);
    bytes = bytes_of(mux);
    nsdf_buffer_free(&bytes);
    nsdf_mux_close(&mux);
    free_file(&file);
}

/* A chunk in front of a segment, and one behind the last, when the segment was cut in two and is one again. */
static void unknown_chunks_do_not_multiply(void **state) {
    made_file file;
    nsdf_buffer payload = {NULL, 0, 0, 0}, bytes = {NULL, 0, 0, 0};
    nsdf_loose_chunk others[3];
    nsdf_encoder_error error;
    nsdf_mux_chunk chunk;
    (void)state;
    make_file(&file, 1, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    for (uint32_t i = 0; i < 3; i++) {
        others[i] = (nsdf_loose_chunk){NSDF_CHUNK('a' + i, 'X', 'X', 'X'), 2, i / 2, {NULL, 0, 0, 0}};
        nsdf_buffer_append(&others[i].payload, "payload", i);
    }
    nsdf_buffer_append(&payload, file.data + file.entries[0].offset + NSDF_CHUNK_HEADER_SIZE,
                       (size_t)file.entries[0].size - NSDF_CHUNK_OVERHEAD);
    nsdf_file_parts parts = {file.header, &payload, file.entries, NULL, NULL, others, 3};
    assert_int_equal(nsdf_write_file(&bytes, &parts), 0);
    nsdf_mux *whole = open_mux(bytes.data, bytes.size);
    nsdf_mux *head = open_mux(bytes.data, bytes.size), *tail = open_mux(bytes.data, bytes.size);
    assert_int_equal(nsdf_mux_chunk_count(whole), 3);
    assert_int_equal(nsdf_mux_get_chunk(whole, 2, &chunk), NSDF_OK);
    assert_string_equal(chunk.type, "cXXX");
    assert_int_equal(chunk.before, 1);
    assert_int_equal(chunk.size, 2);
    assert_int_equal(nsdf_mux_get_chunk(whole, 3, &chunk), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_mux_cut(head, 0, 2, &error), NSDF_OK);
    assert_int_equal(nsdf_mux_cut(tail, 2, 4, &error), NSDF_OK);
    assert_int_equal(nsdf_mux_append(head, tail, 0, &error), NSDF_OK);
    assert_same(head, whole);
    nsdf_mux_close(&whole);
    nsdf_mux_close(&head);
    nsdf_mux_close(&tail);
    for (int i = 0; i < 3; i++)
        nsdf_buffer_free(&others[i].payload);
    nsdf_buffer_free(&payload);
    nsdf_buffer_free(&bytes);
    free_file(&file);
}

static uint32_t below(uint64_t *random, uint32_t limit) {
    return (uint32_t)(make_random(random) % limit);
}

/* One segment replaced by a part of `file` that has as many frames, if there is one. */
static nsdf_status replace_somehow(nsdf_mux *mux, const made_file *file, uint64_t *random, nsdf_encoder_error *error) {
    const uint32_t index = below(random, nsdf_mux_segment_count(mux));
    nsdf_mux_segment s;
    assert_int_equal(nsdf_mux_get_segment(mux, index, &s), NSDF_OK);
    const uint32_t steps = s.last_frame - s.first_frame < 12 ? s.last_frame - s.first_frame : 12;
    const uint32_t first = below(random, 13 - steps);
    nsdf_mux *part = open_part(file, first, first + steps);
    const nsdf_status status = nsdf_mux_replace(mux, index, index, part, error);
    nsdf_mux_close(&part);
    return status;
}

static nsdf_status append_somehow(nsdf_mux *mux, const made_file *file, uint64_t *random, nsdf_encoder_error *error) {
    const uint32_t first = below(random, 12), fade = below(random, 5);
    nsdf_mux *part = open_part(file, first, first + below(random, 13 - first));
    const nsdf_status status = nsdf_mux_append(mux, part, fade < 4 ? fade : NSDF_MUX_FADE_AUTO, error);
    nsdf_mux_close(&part);
    return status;
}

/* Any edit, of which some are refused. */
static nsdf_status edit_somehow(nsdf_mux *mux, const made_file *file, uint64_t *random, nsdf_encoder_error *error) {
    const uint32_t frames = nsdf_mux_frame_count(mux), from = below(random, frames), kind = below(random, 8);
    if (kind < 1)
        return nsdf_mux_cut(mux, from, from + below(random, frames - from), error);
    if (kind < 2)
        return nsdf_mux_hold(mux, below(random, 4), error);
    return kind < 5 ? replace_somehow(mux, file, random, error) : append_somehow(mux, file, random, error);
}

/* Edits, one after the other, leave files that are sound: bytes_of decodes them. */
static void random_edits_leave_sound_files(void **state) {
    made_file file;
    uint64_t random = 21;
    int done = 0;
    (void)state;
    make_file(&file, 3, MAKE_SPLINE, NSDF_ENTROPY_NONE, 1);
    for (int round = 0; round < 300; round++) {
        nsdf_mux *mux = open_mux(file.data, file.size);
        for (int step = 0; step < 6; step++) {
            nsdf_encoder_error error;
            const nsdf_status status = edit_somehow(mux, &file, &random, &error);
            if (status != NSDF_OK && status != NSDF_INVALID_ARGUMENT)
                fail_msg("%s", error.message);
            done += status == NSDF_OK;
            nsdf_buffer bytes = bytes_of(mux);
            nsdf_buffer_free(&bytes);
        }
        nsdf_mux_close(&mux);
    }
    assert_in_range(done, 900, 1800);
    free_file(&file);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pieces_of_a_segment_become_one),
        cmocka_unit_test(other_pieces_stay_apart),
        cmocka_unit_test(segments_are_replaced),
        cmocka_unit_test(what_does_not_fit_replaces_nothing),
        cmocka_unit_test(a_cross_fade_is_as_long_as_a_replacement_reaches),
        cmocka_unit_test(a_rate_changes_times_only),
        cmocka_unit_test(metadata_are_set_and_removed),
        cmocka_unit_test(unknown_chunks_do_not_multiply),
        cmocka_unit_test(random_edits_leave_sound_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
