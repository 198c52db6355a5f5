/* Block parts in bytes: written and read back, cut short, and bent field by field. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "block_samples.h"
#include "nsdf/decoder.h"

/* The part alone, as a heap block of exactly its size. */
static uint8_t *part_of(sample_blocks *s, size_t *size) {
    nsdf_buffer payload = {0};
    nsdf_part_ref parts[NSDF_MAX_PARTS];
    uint32_t count = 0;
    int32_t *q = sample_quantised(s);
    nsdf_write_segment_start(&payload, 1);
    assert_int_equal(nsdf_write_blocks_part(&payload, &s->desc, q), 0);
    assert_int_equal(nsdf_read_parts(payload.data, payload.size, parts, &count, NULL), NSDF_PARSE_OK);
    assert_true(count == 1 && parts[0].kind == NSDF_PART_BLOCKS);
    uint8_t *part = malloc(parts[0].size);
    assert_non_null(part);
    memcpy(part, parts[0].data, parts[0].size);
    *size = parts[0].size;
    nsdf_buffer_free(&payload);
    free(q);
    return part;
}

/* Description, parameters and their check; s->values is allocated on success. */
static nsdf_parse decode(const uint8_t *part, size_t size, sample_blocks *s, nsdf_fault *fault) {
    size_t coded = 0;
    s->values = NULL;
    nsdf_parse status = nsdf_read_blocks_desc(part, size, &s->desc, &coded, fault);
    if (status != NSDF_PARSE_OK)
        return status;
    if (nsdf_parameter_count(&s->desc.list) > 1u << 22)
        return NSDF_PARSE_NO_MEMORY;
    const size_t scratch_size = nsdf_parameter_scratch_size(&s->desc.list);
    void *scratch = malloc(scratch_size ? scratch_size : 1);
    s->values = malloc((size_t)nsdf_parameter_count(&s->desc.list) * sizeof *s->values);
    assert_true(scratch && s->values);
    status = nsdf_read_parameters(part, size, coded, &s->desc.list, scratch, NULL, s->values, fault);
    if (status == NSDF_PARSE_OK)
        status = nsdf_check_blocks(&s->desc, s->values, fault);
    free(scratch);
    if (status != NSDF_PARSE_OK) {
        free(s->values);
        s->values = NULL;
    }
    return status;
}

static const sample_shape shapes[] = {{1, 1, 1, 0, 0}, {5, 2, 2, 1, 4}, {30, 3, 4, 2, 7}, {12, 9, 8, 3, 0}};
enum { SHAPES = sizeof shapes / sizeof *shapes };

/* ---- Good parts ------------------------------------------------------------------------------------------ */

static void assert_same_blocks(const sample_blocks *a, const sample_blocks *b) {
    assert_true(a->desc.block_count == b->desc.block_count && a->desc.bone_count == b->desc.bone_count);
    assert_true(a->desc.influences == b->desc.influences && a->desc.degree == b->desc.degree);
    assert_true(a->desc.fade == b->desc.fade && a->desc.list.entropy == b->desc.list.entropy);
    assert_int_equal(a->desc.list.count, b->desc.list.count);
    for (uint32_t t = 0; t < a->desc.list.count; t++) {
        const nsdf_tensor_desc *p = &a->desc.list.tensors[t], *q = &b->desc.list.tensors[t];
        assert_true(p->kind == q->kind && p->rows == q->rows && p->cols == q->cols && p->knots == q->knots);
        assert_int_equal(p->arrays[0].quantiser, q->arrays[0].quantiser);
    }
    assert_memory_equal(a->values, b->values, (size_t)nsdf_parameter_count(&a->desc.list) * sizeof *a->values);
}

static void test_every_back_end_gives_back_every_shape(void **state) {
    (void)state;
    for (int i = 0; i < SHAPES * NSDF_ENTROPY_COUNT * 2; i++) {
        const nsdf_entropy_kind entropy = (nsdf_entropy_kind)(i % NSDF_ENTROPY_COUNT);
        sample_blocks s = sample_random(shapes[i / NSDF_ENTROPY_COUNT % SHAPES], (uint64_t)i + 1), back;
        nsdf_fault fault = {0, ""};
        size_t size = 0;
        s.desc.list.entropy = (uint8_t)entropy;
        for (uint32_t t = 0; i >= SHAPES * NSDF_ENTROPY_COUNT && t < s.desc.list.count; t += 2)
            s.desc.list.tensors[t].arrays[0].quantiser = NSDF_QUANT_RAW;
        if (nsdf_entropy_available(entropy)) {
            uint8_t *part = part_of(&s, &size);
            assert_int_equal(decode(part, size, &back, &fault), NSDF_PARSE_OK);
            assert_same_blocks(&s, &back);
            free(part);
            sample_free(&back);
        }
        sample_free(&s);
    }
}

static void test_tensors_have_the_rows_and_columns_of_the_specification(void **state) {
    static const uint32_t expected[][3] = {{1, 30, 3}, {1, 30, 1}, {1, 30, 2}, {1, 30, 4}, {1, 30, 4}, {1, 3, 4},
                                           {7, 3, 12}, {1, 30, 1}, {1, 30, 3}, {1, 30, 6}, {1, 30, 10}};
    sample_blocks s = sample_empty((sample_shape){30, 3, 4, 3, 7});
    size_t at = 0;
    (void)state;
    assert_int_equal(s.desc.list.count, 11);
    for (uint32_t t = 0; t < 11; t++) {
        const nsdf_array_desc *a = &s.desc.list.tensors[t].arrays[0];
        assert_true(a->planes == expected[t][0] && a->rows == expected[t][1] && a->cols == expected[t][2]);
        assert_int_equal(nsdf_block_offset(&s.desc, t), at);
        at += a->planes * a->rows * a->cols;
    }
    assert_int_equal(nsdf_parameter_count(&s.desc.list), at);
    sample_free(&s);
}

/* ---- Bad parts ------------------------------------------------------------------------------------------- */

static void test_every_prefix_and_every_longer_part_is_refused(void **state) {
    (void)state;
    for (int i = 0; i < SHAPES * NSDF_ENTROPY_COUNT; i++) {
        sample_blocks s = sample_random(shapes[i / NSDF_ENTROPY_COUNT], (uint64_t)i + 1), back;
        s.desc.list.entropy = (uint8_t)(i % NSDF_ENTROPY_COUNT);
        size_t size = 0;
        if (nsdf_entropy_available((nsdf_entropy_kind)s.desc.list.entropy)) {
            uint8_t *part = part_of(&s, &size);
            for (size_t n = 0; n <= size + 1; n++) {
                uint8_t *copy = calloc(n ? n : 1, 1);
                nsdf_fault fault = {UINT64_MAX, ""};
                memcpy(copy, part, n < size ? n : size);
                const nsdf_parse status = decode(copy, n, &back, &fault);
                assert_int_equal(status, n < size   ? NSDF_PARSE_TRUNCATED
                                         : n > size ? NSDF_PARSE_CORRUPT
                                                    : NSDF_PARSE_OK);
                assert_true(status == NSDF_PARSE_OK || (fault.offset <= n && fault.what[0]));
                free(back.values);
                free(copy);
            }
            free(part);
        }
        sample_free(&s);
    }
}

static void test_flipped_bytes_never_do_more_than_fail(void **state) {
    (void)state;
    uint64_t random = 5;
    int refused = 0;
    for (int round = 0; round < 3000; round++) {
        sample_blocks s = sample_random(shapes[round % SHAPES], (uint64_t)round), back;
        nsdf_fault fault = {0, ""};
        size_t size = 0;
        uint8_t *part = part_of(&s, &size);
        for (uint64_t i = 0; i < 1 + make_random(&random) % 3; i++)
            part[make_random(&random) % (round % 2 && size > 150 ? 150 : size)] ^=
                (uint8_t)(1 + make_random(&random) % 255);
        const nsdf_parse status = decode(part, size, &back, &fault);
        refused += status != NSDF_PARSE_OK;
        assert_true(status == NSDF_PARSE_OK || status == NSDF_PARSE_NO_MEMORY || fault.what[0]);
        free(back.values);
        free(part);
        sample_free(&s);
    }
    assert_true(refused > 300);
}

/* Where fields are in a part with uniform tensors: 13 bytes in front, 15 for each constant tensor. */
enum { FRONT = 13, TENSOR = 15 };

/* Writes `bytes` over a good part at `offset` and expects CORRUPT there. */
static void expect_corrupt(size_t offset, const char *bytes, size_t count, const char *what) {
    sample_blocks s = sample_random((sample_shape){5, 2, 2, 1, 4}, 3), back;
    nsdf_fault fault = {UINT64_MAX, ""};
    size_t size = 0;
    uint8_t *part = part_of(&s, &size);
    memcpy(part + offset, bytes, count);
    assert_int_equal(decode(part, size, &back, &fault), NSDF_PARSE_CORRUPT);
    assert_string_equal(fault.what, what);
    assert_int_equal(fault.offset, offset);
    free(part);
    sample_free(&s);
}

static void test_forbidden_fields_are_named_with_their_offset(void **state) {
    const char *const bones = "number of bones outside 1 to 1024", *const blocks =
                                                                       "number of blocks outside 1 to 65536";
    const char *const fade = "fade outside 0 to 1", *const influences = "influences outside 1 to 8";
    (void)state;
    expect_corrupt(0, "\4", 1, "entropy back end above 3");
    expect_corrupt(1, "\4", 1, "degree above 3");
    expect_corrupt(2, "\0", 1, influences);
    expect_corrupt(2, "\11", 1, influences);
    expect_corrupt(3, "\0\0", 2, bones);
    expect_corrupt(3, "\1\4", 2, bones);
    expect_corrupt(5, "\0\0\0\0", 4, blocks);
    expect_corrupt(5, "\1\0\1\0", 4, blocks);
    expect_corrupt(9, "\0\0\200\277", 4, fade); /* -1 */
    expect_corrupt(9, "\1\0\200\77", 4, fade);  /* a little above 1 */
    expect_corrupt(9, "\0\0\300\177", 4, fade); /* NaN */
}

static void test_places_and_influences_must_be_constant(void **state) {
    (void)state;
    for (size_t t = 0; t < NSDF_BLOCK_POSES; t++) {
        expect_corrupt(FRONT + TENSOR * t, "\1\4\0", 3, "tensor that must be constant and is not");
        expect_corrupt(FRONT + TENSOR * t, "\2\4\0", 3, "tensor that must be constant and is not");
        expect_corrupt(FRONT + TENSOR * t, "\3", 1, "tensor kind above 2");
    }
    expect_corrupt(FRONT + TENSOR * NSDF_BLOCK_COEFFICIENTS + 2, "\3", 1, "tensor kind above 2");
}

/* A low-rank tensor that is whole in itself, in the place of one that may move. */
static void expect_no_low_rank(uint32_t tensor, const char *what) {
    sample_blocks s = sample_empty((sample_shape){3, 2, 1, 0, 4});
    nsdf_tensor_desc *t = &s.desc.list.tensors[tensor];
    nsdf_buffer part = {0}, payload = {0};
    nsdf_blocks_desc back;
    nsdf_fault fault = {0, ""};
    size_t coded = 0;
    t->kind = NSDF_TENSOR_LOW_RANK;
    t->knots = 4;
    t->rank = 1;
    nsdf_tensor_layout(t);
    t->arrays[1].quantiser = t->arrays[2].quantiser = NSDF_QUANT_RAW;
    int32_t *q = calloc((size_t)nsdf_parameter_count(&s.desc.list), sizeof *q);
    assert_int_equal(nsdf_write_blocks_part(&payload, &s.desc, q), -1); /* the writer reads back what it wrote */
    const uint8_t front[9] = {0, 0, 1, 2, 0, 3, 0, 0, 0};
    nsdf_buffer_append(&part, front, sizeof front);
    nsdf_buffer_f32(&part, 0.0f);
    for (uint32_t i = 0; i < s.desc.list.count; i++)
        nsdf_write_tensor_desc(&part, &s.desc.list.tensors[i]);
    assert_int_equal(nsdf_read_blocks_desc(part.data, part.size, &back, &coded, &fault), NSDF_PARSE_CORRUPT);
    assert_string_equal(fault.what, what);
    assert_int_equal(fault.offset, FRONT + TENSOR * tensor + (tensor > NSDF_BLOCK_POSES ? 2 : 0));
    nsdf_buffer_free(&part);
    nsdf_buffer_free(&payload);
    free(q);
    sample_free(&s);
}

static void test_low_rank_tensors_are_refused(void **state) {
    (void)state;
    expect_no_low_rank(NSDF_BLOCK_POSES, "poses that are a low-rank tensor");
    expect_no_low_rank(NSDF_BLOCK_COEFFICIENTS, "coefficients that are a low-rank tensor");
}

static void test_too_many_parameters_are_refused(void **state) {
    sample_blocks s = sample_empty((sample_shape){3, 1024, 1, 0, 4});
    nsdf_buffer part = {0};
    nsdf_blocks_desc back;
    nsdf_fault fault = {0, ""};
    size_t coded = 0;
    const uint8_t front[9] = {0, 0, 1, 0, 4, 3, 0, 0, 0};
    (void)state;
    s.desc.list.tensors[NSDF_BLOCK_POSES].knots = 65535;
    nsdf_buffer_append(&part, front, sizeof front);
    nsdf_buffer_f32(&part, 0.0f);
    for (uint32_t t = 0; t < s.desc.list.count; t++)
        nsdf_write_tensor_desc(&part, &s.desc.list.tensors[t]);
    assert_int_equal(nsdf_read_blocks_desc(part.data, part.size, &back, &coded, &fault), NSDF_PARSE_CORRUPT);
    assert_string_equal(fault.what, "more than 2^28 parameters");
    nsdf_buffer_free(&part);
    sample_free(&s);
}

/* ---- Bad values ------------------------------------------------------------------------------------------ */

/* One value set, in an else good part. */
static void expect_bad_value(uint32_t tensor, size_t index, float value, const char *what) {
    sample_blocks s = sample_random((sample_shape){5, 2, 2, 1, 4}, 3), back;
    nsdf_fault fault = {UINT64_MAX, ""};
    size_t size = 0;
    s.desc.list.tensors[tensor].arrays[0].quantiser = NSDF_QUANT_RAW;
    sample_tensor_values(&s, tensor)[index] = value;
    uint8_t *part = part_of(&s, &size);
    assert_int_equal(decode(part, size, &back, &fault), what ? NSDF_PARSE_CORRUPT : NSDF_PARSE_OK);
    if (what)
        assert_string_equal(fault.what, what);
    free(back.values);
    free(part);
    sample_free(&s);
}

static void test_radii_bones_and_extents_are_checked(void **state) {
    const char *const radius = "a block with a radius of 0 or below";
    const char *const bone = "a block on a bone that there is not";
    const char *const extent = "a bone with an extent of 0 or below";
    (void)state;
    expect_bad_value(NSDF_BLOCK_RADII, 4, 0.0f, radius);
    expect_bad_value(NSDF_BLOCK_RADII, 0, -0.1f, radius);
    expect_bad_value(NSDF_BLOCK_RADII, 0, 1e-45f, NULL);
    expect_bad_value(NSDF_BLOCK_BONES, 9, 2.0f, bone);
    expect_bad_value(NSDF_BLOCK_BONES, 0, -1.0f, bone);
    expect_bad_value(NSDF_BLOCK_BONES, 0, 0.5f, bone);
    expect_bad_value(NSDF_BLOCK_BONES, 0, 1e30f, bone);
    expect_bad_value(NSDF_BLOCK_BONES, 0, -0.0f, NULL);
    expect_bad_value(NSDF_BLOCK_ANCHORS, 7, 0.0f, extent);
    expect_bad_value(NSDF_BLOCK_ANCHORS, 3, -1.0f, extent);
    expect_bad_value(NSDF_BLOCK_ANCHORS, 2, -1.0f, NULL);
    expect_bad_value(NSDF_BLOCK_RADII, 1, NAN, "a raw parameter that is not finite");
}

static void test_the_writer_refuses_what_a_reader_would(void **state) {
    (void)state;
    for (int i = 0; i < 6; i++) {
        sample_blocks s = sample_random((sample_shape){5, 2, 2, 1, 4}, 3);
        nsdf_buffer payload = {0};
        int32_t *q = sample_quantised(&s);
        s.desc.fade = i == 0 ? 1.5f : i == 1 ? NAN : 0.0f;
        s.desc.influences = i == 2 ? 9 : 2;
        s.desc.block_count = i == 3 ? 0 : 5;
        s.desc.bone_count = i == 4 ? 3 : 2; /* the tensors have two */
        assert_int_equal(nsdf_write_blocks_part(&payload, &s.desc, q), i < 5 ? -1 : 0);
        nsdf_buffer_free(&payload);
        free(q);
        sample_free(&s);
    }
}

/* ---- Whole files ----------------------------------------------------------------------------------------- */

/* A file with one segment that holds the blocks. */
static void block_file(made_file *file, sample_blocks *s) {
    nsdf_buffer payload = {0};
    int32_t *q = sample_quantised(s);
    memset(file, 0, sizeof *file);
    nsdf_write_segment_start(&payload, 1);
    assert_int_equal(nsdf_write_blocks_part(&payload, &s->desc, q), 0);
    file->entries[0].parameter_hash =
        nsdf_hash_floats(NSDF_HASH_START, s->values, (size_t)nsdf_parameter_count(&s->desc.list));
    file->entries[0].last_frame = 4;
    make_container(file, 1, &payload);
    free(q);
}

static void test_files_with_blocks_decode(void **state) {
    sample_blocks s = sample_random((sample_shape){40, 3, 2, 2, 5}, 9);
    made_file file;
    nsdf_decoder *decoder = NULL;
    uint64_t random = 4;
    int safe = 0;
    (void)state;
    block_file(&file, &s);
    assert_int_equal(nsdf_open_memory(&decoder, file.data, file.size, NULL, NULL), NSDF_OK);
    for (int i = 0; i < 200; i++) {
        const double u = 0.25 * (i % 5), seconds = u * 4.0 * 1001.0 / 24000.0;
        double x[3];
        float world[3], value;
        int delicate, inside;
        for (int k = 0; k < 3; k++) {
            x[k] = 0.24 * make_uniform(&random);
            world[k] = (float)(x[k] * file.header.scale + file.header.centre[k]);
            x[k] = ((double)world[k] - file.header.centre[k]) / file.header.scale;
        }
        const double expected = reference_blocks(&s, u, x, &delicate, &inside);
        assert_int_equal(nsdf_evaluate(decoder, seconds, world, 1, &value, NULL), NSDF_OK);
        assert_true(delicate || fabs((double)value / file.header.scale - expected) < 1e-5);
        safe += !delicate;
    }
    assert_true(safe > 100);
    nsdf_close(&decoder);
    free_file(&file);
    sample_free(&s);
}

static void test_files_with_bad_values_are_corrupt(void **state) {
    sample_blocks s = sample_random((sample_shape){5, 2, 2, 1, 4}, 3);
    made_file file;
    nsdf_decoder *decoder = NULL;
    nsdf_error error;
    (void)state;
    sample_tensor_values(&s, NSDF_BLOCK_BONES)[3] = 2.0f;
    block_file(&file, &s);
    assert_int_equal(nsdf_open_memory(&decoder, file.data, file.size, NULL, NULL), NSDF_OK);
    assert_int_equal(nsdf_prepare(decoder, 0.0), NSDF_CORRUPT);
    assert_int_equal(nsdf_get_error(decoder, &error), NSDF_OK);
    assert_non_null(strstr(error.message, "a block on a bone that there is not"));
    nsdf_close(&decoder);
    free_file(&file);
    sample_free(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_back_end_gives_back_every_shape),
        cmocka_unit_test(test_tensors_have_the_rows_and_columns_of_the_specification),
        cmocka_unit_test(test_every_prefix_and_every_longer_part_is_refused),
        cmocka_unit_test(test_flipped_bytes_never_do_more_than_fail),
        cmocka_unit_test(test_forbidden_fields_are_named_with_their_offset),
        cmocka_unit_test(test_places_and_influences_must_be_constant),
        cmocka_unit_test(test_low_rank_tensors_are_refused),
        cmocka_unit_test(test_too_many_parameters_are_refused),
        cmocka_unit_test(test_radii_bones_and_extents_are_checked),
        cmocka_unit_test(test_the_writer_refuses_what_a_reader_would),
        cmocka_unit_test(test_files_with_blocks_decode),
        cmocka_unit_test(test_files_with_bad_values_are_corrupt),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
