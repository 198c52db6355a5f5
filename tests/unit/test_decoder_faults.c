/* Damaged files, failing sources, failing allocators and limits: a status with a message, nothing leaked. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "make_file.h"
#include "nsdf/decoder.h"

/* An allocator that counts what it holds and may fail at one call, or remember the most it held. */
typedef struct counting {
    uint64_t calls, fail_at, blocks;
} counting;

static void *counting_allocate(void *user, size_t size) {
    counting *c = user;
    if (++c->calls == c->fail_at)
        return NULL;
    void *block = malloc(size);
    c->blocks += block != NULL;
    return block;
}

static void counting_release(void *user, void *pointer) {
    counting *c = user;
    c->blocks -= pointer != NULL;
    free(pointer);
}

static void options_with(nsdf_decoder_options *options, counting *c) {
    nsdf_decoder_options_init(options);
    options->check_all = 1;
    options->threads = 2;
    options->allocator = (nsdf_allocator){c, counting_allocate, counting_release};
}

/* Opens a copy that ends exactly at a heap block's end; asserts failure with a message and no leak. */
static nsdf_status open_damaged(const uint8_t *data, size_t size, nsdf_error *error) {
    counting c = {0, 0, 0};
    nsdf_decoder_options options;
    nsdf_decoder *decoder = NULL;
    uint8_t *copy = malloc(size ? size : 1);
    assert_non_null(copy);
    memcpy(copy, data, size);
    memset(error, 0, sizeof *error);
    options_with(&options, &c);
    const nsdf_status status = nsdf_open_memory(&decoder, copy, size, &options, error);
    if (status != NSDF_OK) {
        assert_null(decoder);
        assert_int_equal(error->status, status);
        assert_true(error->message[0] != '\0');
        assert_true(error->offset <= size);
    }
    nsdf_close(&decoder);
    assert_int_equal(c.blocks, 0);
    free(copy);
    return status;
}

static void test_every_prefix_is_refused(void **state) {
    made_file file;
    nsdf_error error;
    (void)state;
    make_file(&file, 2, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    for (size_t size = 0; size < file.size; size++) {
        assert_int_equal(open_damaged(file.data, size, &error), NSDF_TRUNCATED);
        assert_int_equal(error.offset, size);
    }
    assert_non_null(strstr(error.message, "file ends at byte"));
    assert_int_equal(open_damaged(file.data, file.size, &error), NSDF_OK);
    free_file(&file);
}

static void test_bytes_after_the_end_are_refused(void **state) {
    made_file file;
    nsdf_error error;
    (void)state;
    make_file(&file, 1, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    uint8_t *longer = malloc(file.size + 3);
    assert_non_null(longer);
    memcpy(longer, file.data, file.size);
    memset(longer + file.size, 0, 3);
    assert_int_equal(open_damaged(longer, file.size + 3, &error), NSDF_CORRUPT);
    assert_int_equal(error.offset, file.size);
    assert_non_null(strstr(error.message, "3 bytes after the end"));
    free(longer);
    free_file(&file);
}

static void test_every_flipped_bit_is_found(void **state) {
    made_file file;
    nsdf_error error;
    (void)state;
    make_sized_file(&file, 2, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 2, 3, 1);
    for (size_t i = 0; i < file.size; i++) {
        for (int bit = 0; bit < 8; bit++) {
            file.data[i] ^= (uint8_t)(1 << bit);
            if (open_damaged(file.data, file.size, &error) == NSDF_OK)
                fail_msg("bit %d of byte %llu", bit, (unsigned long long)i);
            file.data[i] ^= (uint8_t)(1 << bit);
        }
    }
    free_file(&file);
}

/* Bytes that are damaged in a way that a CRC would show, with the CRC made right again. */
static void mend_crc(made_file *file, size_t chunk) {
    uint64_t length = 0;
    for (int i = 0; i < 8; i++)
        length |= (uint64_t)file->data[chunk + 8 + (size_t)i] << 8 * i;
    const size_t end = chunk + NSDF_CHUNK_HEADER_SIZE + (size_t)length;
    const uint32_t crc = nsdf_crc32(0, file->data + chunk, end - chunk);
    for (int i = 0; i < 4; i++)
        file->data[end + (size_t)i] = (uint8_t)(crc >> 8 * i);
}

static void test_a_wrong_parameter_hash_is_found_when_the_segment_is_loaded(void **state) {
    made_file file;
    nsdf_decoder *decoder = NULL;
    nsdf_error error;
    const size_t index = NSDF_PREAMBLE_SIZE + NSDF_HEADER_PAYLOAD_SIZE + NSDF_CHUNK_OVERHEAD;
    (void)state;
    make_file(&file, 2, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    /* the hash ends an index entry; this is the second one's */
    file.data[index + NSDF_CHUNK_HEADER_SIZE + 8 + 2 * NSDF_INDEX_ENTRY_SIZE - 1] ^= 1;
    mend_crc(&file, index);
    assert_int_equal(nsdf_open_memory(&decoder, file.data, file.size, NULL, NULL), NSDF_OK);
    assert_int_equal(nsdf_prepare(decoder, 0.0), NSDF_OK);
    assert_int_equal(nsdf_prepare(decoder, 100.0), NSDF_CHECKSUM);
    assert_int_equal(nsdf_get_error(decoder, &error), NSDF_OK);
    assert_string_equal(error.chunk, "SEGM");
    assert_int_equal(error.offset, file.entries[1].offset);
    assert_int_equal(nsdf_verify(decoder), NSDF_CHECKSUM);
    assert_int_equal(nsdf_prepare(decoder, 0.0), NSDF_OK);
    nsdf_close(&decoder);
    free_file(&file);
}

static void test_a_damaged_segment_is_found_when_it_is_loaded(void **state) {
    made_file file;
    nsdf_decoder *decoder = NULL;
    (void)state;
    make_file(&file, 2, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    assert_int_equal(nsdf_open_memory(&decoder, file.data, file.size, NULL, NULL), NSDF_OK);
    file.data[file.entries[1].offset + 40] ^= 1;
    assert_int_equal(nsdf_prepare(decoder, 0.0), NSDF_OK);
    assert_int_equal(nsdf_prepare(decoder, 100.0), NSDF_CHECKSUM);
    assert_int_equal(nsdf_verify(decoder), NSDF_CHECKSUM);
    nsdf_close(&decoder);
    free_file(&file);
}

/* The file with a chunk put in front of the first segment, and index and file size moved along. */
static void insert_chunk(made_file *file, uint32_t type, uint32_t flags) {
    const size_t at = (size_t)file->entries[0].offset;
    const size_t index = NSDF_PREAMBLE_SIZE + NSDF_HEADER_PAYLOAD_SIZE + NSDF_CHUNK_OVERHEAD;
    nsdf_buffer chunk = {NULL, 0, 0, 0}, payload = {NULL, 0, 0, 0}, whole = {NULL, 0, 0, 0};
    nsdf_write_chunk(&chunk, type, flags, "hello", 5);
    nsdf_buffer_append(&whole, file->data, at);
    nsdf_buffer_append(&whole, chunk.data, chunk.size);
    nsdf_buffer_append(&whole, file->data + at, file->size - at);
    nsdf_buffer_u64(&payload, whole.size);
    for (uint32_t i = 0; i < file->header.segment_count; i++) {
        file->entries[i].offset += chunk.size;
        nsdf_buffer_u32(&payload, file->entries[i].first_frame);
        nsdf_buffer_u32(&payload, file->entries[i].last_frame);
        nsdf_buffer_u32(&payload, (uint32_t)file->entries[i].lead);
        nsdf_buffer_u32(&payload, (uint32_t)file->entries[i].trail);
        nsdf_buffer_u32(&payload, file->entries[i].fade);
        nsdf_buffer_f32(&payload, file->entries[i].smallest_piece);
        nsdf_buffer_u64(&payload, file->entries[i].offset);
        nsdf_buffer_u64(&payload, file->entries[i].size);
        nsdf_buffer_u64(&payload, file->entries[i].parameter_hash);
    }
    memcpy(whole.data + index + NSDF_CHUNK_HEADER_SIZE, payload.data, payload.size);
    free(file->data);
    file->data = malloc(whole.size);
    assert_non_null(file->data);
    memcpy(file->data, whole.data, whole.size);
    file->size = whole.size;
    mend_crc(file, index);
    nsdf_buffer_free(&chunk);
    nsdf_buffer_free(&payload);
    nsdf_buffer_free(&whole);
}

static void test_unknown_chunks_are_skipped_or_refused_by_their_flag(void **state) {
    made_file file;
    nsdf_error error;
    (void)state;
    make_file(&file, 2, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    insert_chunk(&file, NSDF_CHUNK('x', 'T', 'R', '1'), 0);
    assert_int_equal(open_damaged(file.data, file.size, &error), NSDF_OK);
    insert_chunk(&file, NSDF_CHUNK('x', 'T', 'R', '2'), NSDF_CHUNK_CRITICAL);
    assert_int_equal(open_damaged(file.data, file.size, &error), NSDF_UNSUPPORTED_FEATURE);
    assert_string_equal(error.chunk, "xTR2");
    free_file(&file);
}

static void test_known_chunks_are_refused_in_the_wrong_place(void **state) {
    const uint32_t types[] = {NSDF_CHUNK_HEAD, NSDF_CHUNK_INDX, NSDF_CHUNK_SEGM,
                              NSDF_CHUNK_ENDF, NSDF_CHUNK_QUAL, NSDF_CHUNK_META};
    (void)state;
    for (size_t i = 0; i < sizeof types / sizeof *types; i++) {
        made_file file;
        nsdf_error error;
        make_file(&file, 1, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
        insert_chunk(&file, types[i], NSDF_CHUNK_CRITICAL);
        assert_int_equal(open_damaged(file.data, file.size, &error), NSDF_CORRUPT);
        free_file(&file);
    }
}

static void test_a_huge_length_allocates_nothing(void **state) {
    made_file file;
    (void)state;
    for (size_t byte = 0; byte < 8; byte++) {
        nsdf_error error;
        make_file(&file, 1, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
        file.data[file.entries[0].offset + 8 + byte] ^= 0x40;
        assert_int_not_equal(open_damaged(file.data, file.size, &error), NSDF_OK);
        free_file(&file);
    }
}

typedef struct flaky {
    const made_file *file;
    uint64_t calls, fail_at;
} flaky;

static int flaky_read(void *user, uint64_t offset, void *dst, size_t size) {
    flaky *f = user;
    assert_true(offset <= f->file->size && size <= f->file->size - offset);
    if (++f->calls == f->fail_at)
        return 5;
    memcpy(dst, f->file->data + offset, size);
    return 0;
}

static const uint64_t most_calls = 2000;

static void test_a_read_that_fails_is_an_io_status(void **state) {
    made_file file;
    nsdf_status status = NSDF_IO;
    (void)state;
    make_file(&file, 2, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    for (uint64_t k = 1; status != NSDF_OK; k++) {
        counting c = {0, 0, 0};
        flaky f = {&file, 0, k};
        const nsdf_io io = {&f, flaky_read, file.size};
        nsdf_decoder_options options;
        nsdf_decoder *decoder = NULL;
        nsdf_error error;
        options_with(&options, &c);
        assert_true(k < most_calls);
        status = nsdf_open_callbacks(&decoder, &io, &options, &error);
        if (status == NSDF_OK) {
            status = nsdf_verify(decoder);
            assert_int_equal(nsdf_get_error(decoder, &error), NSDF_OK);
        }
        assert_true(status == NSDF_OK || (status == NSDF_IO && error.status == NSDF_IO && error.message[0]));
        nsdf_close(&decoder);
        assert_int_equal(c.blocks, 0);
    }
    free_file(&file);
}

/* Everything that allocates; the last failing status. */
static nsdf_status use_everything(const made_file *file, const nsdf_decoder_options *options, int from_callbacks,
                                  nsdf_mesh **mesh) {
    flaky f = {file, 0, 0};
    const nsdf_io io = {&f, flaky_read, file->size};
    const float point[3] = {1.0f, 2.0f, 3.0f};
    float distance, buffer[3];
    uint32_t corners[3];
    nsdf_mesh_buffers buffers = {buffer, NULL, corners, 1, 1, 0, 0};
    nsdf_decoder *decoder = NULL;
    nsdf_error error;
    nsdf_status status = from_callbacks ? nsdf_open_callbacks(&decoder, &io, options, &error)
                                        : nsdf_open_memory(&decoder, file->data, file->size, options, &error);
    if (status != NSDF_OK)
        assert_true(error.status == status && error.message[0] != '\0');
    for (int i = 0; status == NSDF_OK && i < 3; i++)
        status = nsdf_evaluate(decoder, 0.2 * i, point, 1, &distance, NULL);
    if (status == NSDF_OK)
        status = nsdf_extract_mesh(decoder, 0.1, NULL, mesh);
    if (status == NSDF_OK) {
        status = nsdf_extract_mesh_into(decoder, 0.1, NULL, &buffers);
        if (status == NSDF_BUFFER_TOO_SMALL)
            status = NSDF_OK;
    }
    nsdf_close(&decoder);
    return status;
}

static void test_failing_allocations_are_a_status_and_leak_nothing(void **state) {
    made_file file;
    (void)state;
    make_file(&file, 4, MAKE_SPLINE, NSDF_ENTROPY_NONE, 1);
    for (int from_callbacks = 0; from_callbacks < 2; from_callbacks++) {
        nsdf_status status = NSDF_NO_MEMORY;
        for (uint64_t k = 1; status != NSDF_OK; k++) {
            counting c = {0, k, 0};
            nsdf_decoder_options options;
            nsdf_mesh *mesh = NULL;
            options_with(&options, &c);
            assert_true(k < most_calls);
            status = use_everything(&file, &options, from_callbacks, &mesh);
            assert_true(status == NSDF_NO_MEMORY || (status == NSDF_OK && c.calls < k));
            nsdf_mesh_free(&mesh);
            assert_int_equal(c.blocks, 0);
        }
    }
    free_file(&file);
}

/* An allocator that knows the largest sum it held. */
typedef struct metered {
    uint64_t held, most;
} metered;

static void *metered_allocate(void *user, size_t size) {
    metered *m = user;
    size_t *block = malloc(size + 64);
    if (!block)
        return NULL;
    *block = size;
    m->held += size;
    m->most = m->held > m->most ? m->held : m->most;
    return (char *)block + 64;
}

static void metered_release(void *user, void *pointer) {
    metered *m = user;
    if (!pointer)
        return;
    size_t *block = (size_t *)(void *)((char *)pointer - 64);
    m->held -= *block;
    free(block);
}

static void test_max_memory_is_never_exceeded(void **state) {
    made_file file;
    int succeeded = 0, refused = 0;
    (void)state;
    make_file(&file, 4, MAKE_SPLINE, NSDF_ENTROPY_NONE, 1);
    for (uint64_t limit = 0; limit < 16u << 20; limit = limit * 5 / 4 + 1000) {
        metered m = {0, 0};
        nsdf_decoder_options options;
        nsdf_mesh *mesh = NULL;
        nsdf_decoder_options_init(&options);
        options.threads = 1;
        options.max_memory = limit;
        options.allocator = (nsdf_allocator){&m, metered_allocate, metered_release};
        const nsdf_status status = use_everything(&file, &options, 1, &mesh);
        assert_true(status == NSDF_OK || status == NSDF_LIMIT);
        assert_true(m.most <= limit);
        succeeded += status == NSDF_OK;
        refused += status == NSDF_LIMIT;
        nsdf_mesh_free(&mesh);
        assert_int_equal(m.held, 0);
    }
    assert_true(succeeded > 0 && refused > 5);
    free_file(&file);
}

/* The least memory that serves each time alone also serves any sequence of times. */
/* 530,000 parameters that are all alike: hardly any bytes. */
static void make_empty_network(made_file *file) {
    nsdf_buffer payload = {NULL, 0, 0, 0};
    nsdf_network_desc *desc = &file->desc[0];
    memset(file, 0, sizeof *file);
    make_network(desc, MAKE_FOURIER_SEED, 4, 512, NSDF_ENTROPY_RANGE);
    const size_t count = (size_t)nsdf_parameter_count(&desc->list);
    int32_t *q = calloc(count, sizeof *q);
    assert_true(q && count > 500000);
    file->values[0] = malloc(count * sizeof(float));
    assert_non_null(file->values[0]);
    float *value = file->values[0];
    for (uint32_t t = 0; t < desc->list.count; t++) {
        const nsdf_array_desc *a = &desc->list.tensors[t].arrays[0];
        for (uint64_t i = 0; i < nsdf_array_size(a); i++)
            *value++ = a->quantiser == NSDF_QUANT_RAW ? 0.0f : nsdf_dequantise(0, a->step, a->offset);
    }
    nsdf_write_segment_start(&payload, 1);
    assert_int_equal(nsdf_write_network_part(&payload, desc, q), 0);
    free(q);
    file->entries[0].parameter_hash = nsdf_hash_floats(NSDF_HASH_START, file->values[0], count);
    file->entries[0].last_frame = 4;
    make_container(file, 1, &payload);
}

static void test_a_small_file_may_not_ask_for_all_memory(void **state) {
    static const uint64_t limits[2] = {(uint64_t)16 << 20, (uint64_t)1 << 30};
    made_file file;
    (void)state;
    make_empty_network(&file);
    assert_true(file.size < 2000);
    for (int i = 0; i < 2; i++) {
        nsdf_decoder_options options;
        nsdf_decoder *decoder = NULL;
        nsdf_error error;
        nsdf_decoder_options_init(&options);
        options.threads = 1;
        options.max_memory = limits[i];
        assert_int_equal(nsdf_open_memory(&decoder, file.data, file.size, &options, NULL), NSDF_OK);
        assert_int_equal(nsdf_verify(decoder), i == 0 ? NSDF_LIMIT : NSDF_OK);
        assert_int_equal(nsdf_get_error(decoder, &error), NSDF_OK);
        assert_true(i == 1 || strstr(error.message, "max_memory / 64"));
        nsdf_close(&decoder);
    }
    free_file(&file);
}

static void test_what_is_cached_never_causes_a_limit(void **state) {
    made_file file;
    uint64_t enough = 0;
    (void)state;
    make_file(&file, 5, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 1);
    for (int i = 0; i < 5; i++) {
        nsdf_decoder_options options;
        nsdf_decoder *decoder = NULL;
        nsdf_decoder_options_init(&options);
        options.threads = 1;
        for (options.max_memory = 10000;; options.max_memory += 2000) {
            assert_int_equal(nsdf_open_memory(&decoder, file.data, file.size, &options, NULL), NSDF_OK);
            const nsdf_status status = nsdf_prepare(decoder, (4 * i + 1) * 1001.0 / 24000.0);
            nsdf_close(&decoder);
            if (status == NSDF_OK)
                break;
            assert_int_equal(status, NSDF_LIMIT);
        }
        enough = options.max_memory > enough ? options.max_memory : enough;
    }
    nsdf_decoder_options options;
    nsdf_decoder *decoder = NULL;
    nsdf_decoder_options_init(&options);
    options.threads = 1;
    options.max_memory = enough;
    assert_int_equal(nsdf_open_memory(&decoder, file.data, file.size, &options, NULL), NSDF_OK);
    for (int i = 0; i < 25; i++)
        assert_int_equal(nsdf_prepare(decoder, (4 * (i * 3 % 5) + 1) * 1001.0 / 24000.0), NSDF_OK);
    nsdf_close(&decoder);
    free_file(&file);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_prefix_is_refused),
        cmocka_unit_test(test_bytes_after_the_end_are_refused),
        cmocka_unit_test(test_every_flipped_bit_is_found),
        cmocka_unit_test(test_a_wrong_parameter_hash_is_found_when_the_segment_is_loaded),
        cmocka_unit_test(test_a_damaged_segment_is_found_when_it_is_loaded),
        cmocka_unit_test(test_unknown_chunks_are_skipped_or_refused_by_their_flag),
        cmocka_unit_test(test_known_chunks_are_refused_in_the_wrong_place),
        cmocka_unit_test(test_a_huge_length_allocates_nothing),
        cmocka_unit_test(test_a_read_that_fails_is_an_io_status),
        cmocka_unit_test(test_failing_allocations_are_a_status_and_leak_nothing),
        cmocka_unit_test(test_max_memory_is_never_exceeded),
        cmocka_unit_test(test_a_small_file_may_not_ask_for_all_memory),
        cmocka_unit_test(test_what_is_cached_never_causes_a_limit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
