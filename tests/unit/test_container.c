#include "format_samples.h"

#include "bytes.h"

static nsdf_file_header example_header(void) {
    nsdf_file_header h = {.rate_num = 25, .rate_den = 1, .frame_count = 1, .segment_count = 1, .scale = 2.0};
    for (int i = 0; i < 3; i++) {
        h.box_min[i] = -1.0;
        h.box_max[i] = 1.0;
        h.domain_min[i] = -0.5f;
        h.domain_max[i] = 0.5f;
    }
    h.default_resolution = 64;
    h.extraction_bound = 1.25f;
    return h;
}

/* |x| - 1/4 as a 3-2-1 network: relu(x), relu(-x), their sum less a raw bias. */
static void example_network(nsdf_network_desc *d) {
    memset(d, 0, sizeof *d);
    d->time_scale = d->value_scale = 1.0f;
    d->layer_count = 2;
    d->list.count = 4;
    for (uint32_t i = 0; i < 2; i++) {
        d->layers[i].width = 2 - i;
        d->layers[i].activation = i ? NSDF_ACT_IDENTITY : NSDF_ACT_RELU;
        for (uint32_t k = 0; k < 2; k++) {
            nsdf_tensor_desc *t = &d->list.tensors[2 * i + k];
            t->rows = 2 - i;
            t->cols = k ? 1 : 3 - i;
            nsdf_tensor_layout(t);
            t->arrays[0].quantiser = NSDF_QUANT_UNIFORM;
            t->arrays[0].step = 0.25f;
        }
    }
    d->list.tensors[3].arrays[0].quantiser = NSDF_QUANT_RAW;
    d->list.tensors[3].arrays[0].step = 0.0f;
}

static void make_example(nsdf_buffer *file) {
    const float bias = -0.25f;
    int32_t q[11] = {4, 0, 0, -4, 0, 0, 0, 0, 4, 4, 0};
    nsdf_network_desc d;
    nsdf_buffer segment = {0};
    memcpy(&q[10], &bias, sizeof bias);
    example_network(&d);
    nsdf_write_segment_start(&segment, 1);
    assert_int_equal(nsdf_write_network_part(&segment, &d, q), 0);
    float *values = sample_expected(&d, q);
    nsdf_index_entry entry = {.smallest_piece = 0.125f,
                              .parameter_hash = nsdf_hash_floats(NSDF_HASH_START, values, 11)};
    nsdf_file_parts parts = {.header = example_header(), .segments = &segment, .entries = &entry};
    assert_int_equal(nsdf_write_file(file, &parts), 0);
    free(values);
    nsdf_buffer_free(&segment);
}

/* Bytes of the lines "0010: 48 45 41 44  text" of the specification's example; each line's offset must be right. */
static size_t read_example_from_specification(uint8_t *bytes, size_t capacity) {
    char path[4096], line[512];
    snprintf(path, sizeof path, "%s", __FILE__);
    char *slash = strrchr(path, '/');
    assert_non_null(slash);
    snprintf(slash, sizeof path - (size_t)(slash - path), "/../../spec/nsdf-bitstream.md");
    FILE *f = fopen(path, "r");
    size_t count = 0;
    assert_non_null(f);
    while (fgets(line, sizeof line, f)) {
        unsigned offset, byte;
        int used = 0;
        if (sscanf(line, "%4x:%n", &offset, &used) != 1 || used != 5)
            continue;
        assert_int_equal(offset, count);
        for (const char *p = line + 5; p[0] == ' ' && sscanf(p, " %2x", &byte) == 1 && p[1] != ' '; p += 3) {
            assert_true(count < capacity);
            bytes[count++] = (uint8_t)byte;
        }
    }
    fclose(f);
    return count;
}

static void the_specification_shows_the_bytes_that_are_written(void **state) {
    (void)state;
    uint8_t shown[1024];
    nsdf_buffer file = {0};
    make_example(&file);
    size_t count = read_example_from_specification(shown, sizeof shown);
    assert_int_equal(count, file.size);
    assert_memory_equal(shown, file.data, count);
    nsdf_buffer_free(&file);
}

static void preamble_checks_come_in_order(void **state) {
    (void)state;
    nsdf_buffer b = {0};
    nsdf_version_fields v = {9, 9};
    nsdf_fault fault = {0, ""};
    nsdf_write_preamble(&b);
    assert_int_equal(b.size, NSDF_PREAMBLE_SIZE);
    assert_int_equal(nsdf_read_preamble(b.data, b.size, &v, &fault), NSDF_PARSE_OK);
    assert_true(v.major == NSDF_FORMAT_MAJOR && v.minor == NSDF_FORMAT_MINOR);
    for (size_t n = 0; n < b.size; n++)
        assert_int_equal(nsdf_read_preamble(b.data, n, &v, NULL), NSDF_PARSE_TRUNCATED);
    b.data[11] = 1;
    assert_int_equal(nsdf_read_preamble(b.data, b.size, &v, &fault), NSDF_PARSE_CHECKSUM);
    b.data[10] = 3;
    assert_int_equal(nsdf_read_preamble(b.data, b.size, &v, &fault), NSDF_PARSE_CHECKSUM);
    b.data[9] = 1;
    assert_int_equal(nsdf_read_preamble(b.data, b.size, &v, &fault), NSDF_PARSE_VERSION);
    assert_true(v.major == 1 && v.minor == 3 && fault.offset == 9);
    for (size_t i = 0; i < 9; i++) {
        b.data[i] ^= 0x80;
        assert_int_equal(nsdf_read_preamble(b.data, i + 1, &v, &fault), NSDF_PARSE_NOT_NSDF);
        assert_int_equal(fault.offset, i);
        b.data[i] ^= 0x80;
    }
    nsdf_buffer_free(&b);
}

static void other_minor_versions_are_refused_while_major_is_zero(void **state) {
    (void)state;
    nsdf_buffer b = {0};
    nsdf_version_fields v;
    nsdf_write_preamble(&b);
    for (int minor = 0; minor <= NSDF_FORMAT_MINOR + 1; minor++) {
        b.data[10] = (uint8_t)minor;
        b.data[11] = 77; /* reserved: ignored */
        b.size = 12;
        nsdf_buffer_u32(&b, nsdf_crc32(0, b.data, 12));
        assert_int_equal(nsdf_read_preamble(b.data, b.size, &v, NULL),
                         minor == NSDF_FORMAT_MINOR ? NSDF_PARSE_OK : NSDF_PARSE_VERSION);
        assert_int_equal(v.minor, minor);
    }
    nsdf_buffer_free(&b);
}

static void chunks_are_checked(void **state) {
    (void)state;
    nsdf_buffer b = {0};
    nsdf_chunk_header h;
    nsdf_fault fault = {0, ""};
    nsdf_write_chunk(&b, NSDF_CHUNK('a', 'B', '9', 'Z'), 6, "hello", 5);
    assert_int_equal(b.size, 5 + NSDF_CHUNK_OVERHEAD);
    assert_int_equal(nsdf_read_chunk_header(b.data, 15, &h, &fault), NSDF_PARSE_TRUNCATED);
    assert_int_equal(nsdf_read_chunk_header(b.data, 16, &h, &fault), NSDF_PARSE_OK);
    assert_true(h.type == NSDF_CHUNK('a', 'B', '9', 'Z') && h.flags == 6 && h.length == 5);
    assert_int_equal(nsdf_check_chunk(b.data, &h, &fault), NSDF_PARSE_OK);
    for (size_t i = 0; i < b.size; i++) {
        b.data[i] ^= 1;
        assert_int_equal(nsdf_check_chunk(b.data, &h, &fault), NSDF_PARSE_CHECKSUM);
        b.data[i] ^= 1;
    }
    b.data[2] = '-';
    assert_int_equal(nsdf_read_chunk_header(b.data, 16, &h, &fault), NSDF_PARSE_CORRUPT);
    assert_int_equal(fault.offset, 2);
    b.data[2] = 'x';
    b.data[15] = 0x80;
    assert_int_equal(nsdf_read_chunk_header(b.data, 16, &h, &fault), NSDF_PARSE_CORRUPT);
    assert_int_equal(fault.offset, 8);
    nsdf_buffer_free(&b);
}

static void checksums_match_published_values(void **state) {
    (void)state;
    const float floats[2] = {1.0f, -2.0f};
    assert_true(nsdf_crc32(0, "123456789", 9) == 0xcbf43926u);
    assert_true(nsdf_crc32(nsdf_crc32(0, "1234", 4), "56789", 5) == 0xcbf43926u);
    assert_true(nsdf_hash64(NSDF_HASH_START, "", 0) == NSDF_HASH_START);
    assert_true(nsdf_hash64(NSDF_HASH_START, "foobar", 6) == UINT64_C(0x85944171f73967e8));
    assert_true(nsdf_hash_floats(NSDF_HASH_START, floats, 2) ==
                nsdf_hash64(NSDF_HASH_START, "\0\0\200\77\0\0\0\300", 8));
}

static void headers_come_back_unchanged(void **state) {
    (void)state;
    nsdf_buffer b = {0};
    nsdf_file_header h = example_header(), back;
    h.rate_num = 30000;
    h.rate_den = 1001;
    h.frame_count = 40;
    h.segment_count = 7;
    h.centre[1] = 0.125;
    memset(&back, 0, sizeof back);
    nsdf_write_header(&b, &h);
    assert_int_equal(b.size, NSDF_HEADER_PAYLOAD_SIZE);
    for (size_t n = 0; n < b.size; n++)
        assert_int_equal(nsdf_read_header(b.data, n, &back, NULL), NSDF_PARSE_TRUNCATED);
    nsdf_buffer_u64(&b, 1234); /* a longer payload is allowed */
    assert_int_equal(nsdf_read_header(b.data, b.size, &back, NULL), NSDF_PARSE_OK);
    assert_memory_equal(&back, &h, sizeof h);
    nsdf_buffer_free(&b);
}

static void expect_bad_header(const nsdf_file_header *h, uint64_t offset) {
    nsdf_buffer b = {0};
    nsdf_file_header back;
    nsdf_fault fault = {UINT64_MAX, ""};
    nsdf_write_header(&b, h);
    assert_int_equal(nsdf_read_header(b.data, b.size, &back, &fault), NSDF_PARSE_CORRUPT);
    assert_int_equal(fault.offset, offset);
    nsdf_buffer_free(&b);
}

#define EXPECT_BAD(field, value, offset)                                                                               \
    do {                                                                                                               \
        nsdf_file_header bad = example_header();                                                                       \
        bad.field = value;                                                                                             \
        expect_bad_header(&bad, offset);                                                                               \
    } while (0)

static void every_header_field_is_validated(void **state) {
    (void)state;
    EXPECT_BAD(rate_num, 0, 0);
    EXPECT_BAD(rate_den, 0, 4);
    EXPECT_BAD(frame_count, 0, 8);
    EXPECT_BAD(segment_count, 0, 12);
    EXPECT_BAD(segment_count, NSDF_MAX_SEGMENTS + 1, 12);
    EXPECT_BAD(segment_count, 2, 12); /* more than steps between frames */
    EXPECT_BAD(box_min[0], (double)NAN, 16);
    EXPECT_BAD(box_min[2], 1.5, 56); /* above box_max[2], where it is found */
    EXPECT_BAD(box_max[1], (double)INFINITY, 48);
    EXPECT_BAD(centre[0], -2e30, 64);
    EXPECT_BAD(scale, 0.0, 88);
    EXPECT_BAD(scale, -1.0, 88);
    EXPECT_BAD(scale, (double)NAN, 88);
    EXPECT_BAD(domain_min[0], -17.0f, 96);
    EXPECT_BAD(domain_min[1], NAN, 100);
    EXPECT_BAD(domain_max[2], -0.5f, 116);
    EXPECT_BAD(default_resolution, 1, 120);
    EXPECT_BAD(default_resolution, NSDF_MAX_RESOLUTION + 1, 120);
    EXPECT_BAD(extraction_bound, 0.0f, 124);
    EXPECT_BAD(extraction_bound, NAN, 124);
    EXPECT_BAD(extraction_bound, 2e6f, 124);
}

enum {
    INDEX_SEGMENTS = 3,
    INDEX_START = 16 + 148 + 20 + 8 + 3 * 48,
    ENTRY = 8,
    SECOND = ENTRY + 48,
    THIRD = SECOND + 48
};

/* An index of three segments over nine frames, as INDX's payload, after `change` was made to it. */
static nsdf_parse read_changed_index(size_t offset, uint64_t value, size_t size, nsdf_fault *fault) {
    nsdf_file_header h = example_header();
    nsdf_index_entry entries[INDEX_SEGMENTS];
    nsdf_buffer b = {0};
    uint64_t file_size = 0;
    h.frame_count = 9;
    h.segment_count = INDEX_SEGMENTS;
    nsdf_buffer_u64(&b, INDEX_START + 3 * 100 + 20);
    for (uint32_t i = 0; i < INDEX_SEGMENTS; i++) {
        nsdf_buffer_u32(&b, i == 0 ? 0 : i == 1 ? 3 : 5);
        nsdf_buffer_u32(&b, i == 0 ? 3 : i == 1 ? 5 : 8);
        nsdf_buffer_u32(&b, 1); /* lead, trail, fade, smallest piece */
        nsdf_buffer_u32(&b, i == 1 ? 2 : 1);
        nsdf_buffer_u32(&b, i == 0 ? 0 : 1);
        nsdf_buffer_f32(&b, 0.5f);
        nsdf_buffer_u64(&b, INDEX_START + 100 * i);
        nsdf_buffer_u64(&b, 100);
        nsdf_buffer_u64(&b, i);
    }
    assert_int_equal(b.size, nsdf_index_payload_size(INDEX_SEGMENTS));
    for (size_t i = 0; i < size; i++)
        b.data[offset + i] = (uint8_t)(value >> 8 * i);
    nsdf_parse status = nsdf_read_index(b.data, b.size, &h, entries, &file_size, fault);
    if (status == NSDF_PARSE_OK) {
        assert_int_equal(file_size, INDEX_START + 320);
        assert_true(entries[1].first_frame == 3 && entries[1].last_frame == 5 && entries[2].parameter_hash == 2);
        assert_true(entries[1].lead == 1 && entries[1].trail == 2 && entries[1].fade == 1);
        assert_true(entries[2].smallest_piece == 0.5f);
    }
    for (size_t n = 0; n < b.size && size == 0; n++)
        assert_int_equal(nsdf_read_index(b.data, n, &h, entries, &file_size, NULL), NSDF_PARSE_TRUNCATED);
    nsdf_buffer_free(&b);
    return status;
}

static void expect_bad_index(size_t offset, uint64_t value, size_t size, uint64_t fault_offset) {
    nsdf_fault fault = {UINT64_MAX, ""};
    assert_int_equal(read_changed_index(offset, value, size, &fault), NSDF_PARSE_CORRUPT);
    assert_int_equal(fault.offset, fault_offset);
}

static void indices_must_cover_all_frames_in_order(void **state) {
    (void)state;
    assert_int_equal(read_changed_index(0, 0, 0, NULL), NSDF_PARSE_OK);
    expect_bad_index(0, 100, 8, 0);                                  /* file smaller than its own front */
    expect_bad_index(0, UINT64_MAX, 8, 0);                           /* file size above 2^63 - 1 */
    expect_bad_index(0, INDEX_START + 319, 8, THIRD + 32);           /* no room for ENDF */
    expect_bad_index(ENTRY, 1, 4, ENTRY);                            /* first frame not 0 */
    expect_bad_index(ENTRY + 4, 0, 4, ENTRY + 4);                    /* segment without length */
    expect_bad_index(SECOND, 2, 4, SECOND);                          /* frames that overlap */
    expect_bad_index(SECOND, 4, 4, SECOND);                          /* gap between segments */
    expect_bad_index(THIRD + 4, 7, 4, THIRD + 4);                    /* ends before the last frame */
    expect_bad_index(THIRD + 4, 9, 4, THIRD + 4);                    /* ends behind the last frame */
    expect_bad_index(ENTRY + 24, INDEX_START - 1, 8, ENTRY + 24);    /* inside INDX */
    expect_bad_index(SECOND + 24, INDEX_START + 99, 8, SECOND + 24); /* overlap */
    expect_bad_index(THIRD + 24, UINT64_MAX - 50, 8, THIRD + 32);    /* offset + size wraps */
    expect_bad_index(THIRD + 32, UINT64_MAX, 8, THIRD + 32);
    expect_bad_index(ENTRY + 32, 19, 8, ENTRY + 32); /* smaller than an empty chunk */
}

static void cross_fades_must_lie_where_both_models_are(void **state) {
    float piece = 65.0f;
    uint32_t bits;
    (void)state;
    assert_int_equal(read_changed_index(THIRD + 8, 0x7fffffff, 4, NULL), NSDF_PARSE_OK);
    assert_int_equal(read_changed_index(THIRD + 12, (uint32_t)-4, 4, NULL), NSDF_PARSE_OK);
    expect_bad_index(THIRD + 12, (uint32_t)-5, 4, THIRD + 8); /* ends before it begins */
    expect_bad_index(SECOND + 12, UINT64_C(1) << 31, 4, SECOND + 8);
    expect_bad_index(ENTRY + 16, 1, 4, ENTRY + 16);   /* nothing to fade from */
    expect_bad_index(SECOND + 16, 2, 4, SECOND + 16); /* above the lead, and the trail before */
    expect_bad_index(SECOND + 8, 0, 4, SECOND + 16);  /* lead below the fade */
    expect_bad_index(ENTRY + 12, 0, 4, SECOND + 16);  /* trail before below the fade */
    memcpy(&bits, &piece, sizeof bits);
    expect_bad_index(THIRD + 20, bits, 4, THIRD + 20);
    expect_bad_index(THIRD + 20, 0x7fc00000, 4, THIRD + 20); /* NaN */
    expect_bad_index(THIRD + 20, 0xbf800000, 4, THIRD + 20); /* -1 */
}

/* Three segments of frames 0 to 3 to 5 to 8 whose models reach 9 frames further everywhere. */
static void two_cross_fades_may_not_meet_in_a_segment(void **state) {
    (void)state;
    for (uint32_t fade = 0; fade <= 3; fade++) {
        nsdf_file_header h = example_header();
        nsdf_index_entry in[3] = {
            {0, 3, 9, 9, 0, 0.0f, 0, 0, 0}, {3, 5, 9, 9, fade, 0.0f, 0, 0, 0}, {5, 8, 9, 9, 1, 0.0f, 0, 0, 0}};
        nsdf_index_entry out[3];
        nsdf_buffer b = {0}, segments[3] = {{0}};
        uint64_t file_size;
        h.frame_count = 9;
        h.segment_count = 3;
        nsdf_file_parts parts = {.header = h, .segments = segments, .entries = in};
        assert_int_equal(nsdf_write_file(&b, &parts), 0);
        const nsdf_parse status = nsdf_read_index(b.data + 16 + 148 + 16, 8 + 3 * 48, &h, out, &file_size, NULL);
        assert_int_equal(status, fade <= 1 ? NSDF_PARSE_OK : NSDF_PARSE_CORRUPT);
        nsdf_buffer_free(&b);
    }
}

static void a_single_frame_has_an_index_of_its_own_kind(void **state) {
    (void)state;
    nsdf_buffer file = {0};
    nsdf_file_header h = example_header();
    nsdf_index_entry entry;
    uint64_t file_size = 0;
    make_example(&file);
    uint8_t *payload = file.data + 16 + 148 + 16;
    assert_int_equal(nsdf_read_index(payload, 56, &h, &entry, &file_size, NULL), NSDF_PARSE_OK);
    assert_true(file_size == file.size && entry.first_frame == 0 && entry.last_frame == 0);
    assert_true(entry.offset + entry.size + NSDF_CHUNK_OVERHEAD == file.size);
    payload[12] = 1;
    assert_int_equal(nsdf_read_index(payload, 56, &h, &entry, &file_size, NULL), NSDF_PARSE_CORRUPT);
    nsdf_buffer_free(&file);
}

static void quality_comes_back_and_is_validated(void **state) {
    (void)state;
    nsdf_buffer b = {0};
    nsdf_quality_record q = {{1e-4, 2e-4}, {3e-4, 4e-4}, {5e-3, 6e-3}, 256, 12}, back;
    memset(&back, 0, sizeof back);
    nsdf_write_quality(&b, &q);
    assert_int_equal(b.size, 56);
    for (size_t n = 0; n < b.size; n++)
        assert_int_equal(nsdf_read_quality(b.data, n, &back, NULL), NSDF_PARSE_TRUNCATED);
    assert_int_equal(nsdf_read_quality(b.data, b.size, &back, NULL), NSDF_PARSE_OK);
    assert_memory_equal(&back, &q, sizeof q);
    b.data[15] = 0xff; /* the second number becomes negative */
    assert_int_equal(nsdf_read_quality(b.data, b.size, &back, NULL), NSDF_PARSE_CORRUPT);
    nsdf_buffer_free(&b);
}

static void metadata_come_back_in_order(void **state) {
    (void)state;
    nsdf_buffer b = {0};
    size_t cursor = 0;
    const char *key, *value;
    nsdf_write_metadata(&b, "title", "H\xc3\xa1\xe2\x82\xac\xf0\x9f\x98\x80");
    nsdf_write_metadata(&b, "empty", "");
    assert_int_equal(nsdf_read_metadata(b.data, b.size, &cursor, &key, &value, NULL), NSDF_PARSE_OK);
    assert_string_equal(key, "title");
    assert_string_equal(value, "H\xc3\xa1\xe2\x82\xac\xf0\x9f\x98\x80");
    size_t second = cursor;
    assert_int_equal(nsdf_read_metadata(b.data, b.size, &cursor, &key, &value, NULL), NSDF_PARSE_OK);
    assert_string_equal(key, "empty");
    assert_string_equal(value, "");
    assert_int_equal(nsdf_read_metadata(b.data, b.size, &cursor, &key, &value, NULL), NSDF_PARSE_OK);
    assert_null(key);
    for (size_t n = second + 1; n < b.size; n++) {
        cursor = second;
        assert_int_equal(nsdf_read_metadata(b.data, n, &cursor, &key, &value, NULL), NSDF_PARSE_TRUNCATED);
    }
    nsdf_buffer_free(&b);
}

static void metadata_must_be_utf8_without_nul(void **state) {
    (void)state;
    static const char *const bad[] = {
        "\x80", "\xc3", "\xc0\xaf", "\xe0\x80\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xf0\x80\x80\x80", "\xff"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        nsdf_buffer b = {0};
        size_t cursor = 0;
        const char *key, *value;
        nsdf_write_metadata(&b, "k", bad[i]);
        assert_int_equal(nsdf_read_metadata(b.data, b.size, &cursor, &key, &value, NULL), NSDF_PARSE_CORRUPT);
        assert_int_equal(cursor, 0);
        nsdf_buffer_free(&b);
    }
    uint8_t nul_inside[] = {1, 0, 2, 0, 0, 0, 'k', 0, 'a', 0, 0}, no_nul[] = {1, 0, 1, 0, 0, 0, 'k', 0, 'a', 'b'};
    uint8_t no_key[] = {0, 0, 0, 0, 0, 0, 0, 0};
    size_t cursor = 0;
    const char *key, *value;
    assert_int_equal(nsdf_read_metadata(nul_inside, 11, &cursor, &key, &value, NULL), NSDF_PARSE_CORRUPT);
    assert_int_equal(nsdf_read_metadata(no_nul, 10, &cursor, &key, &value, NULL), NSDF_PARSE_CORRUPT);
    assert_int_equal(nsdf_read_metadata(no_key, 8, &cursor, &key, &value, NULL), NSDF_PARSE_CORRUPT);
}

/* Walks the chunks of a file with everything in it, as a reader would. */
static void whole_files_hold_their_chunks_in_order(void **state) {
    (void)state;
    nsdf_buffer file = {0}, segments[2] = {{0}, {0}}, metadata = {0};
    nsdf_index_entry entries[2] = {{.first_frame = 0, .last_frame = 2}, {.first_frame = 2, .last_frame = 5}};
    nsdf_quality_record quality = {.resolution = 64, .frames = 6};
    nsdf_file_parts parts = {example_header(), segments, entries, &metadata, &quality, NULL, 0};
    parts.header.frame_count = 6;
    parts.header.segment_count = 2;
    nsdf_buffer_append(&segments[0], "first", 5);
    nsdf_buffer_append(&segments[1], "second", 6);
    nsdf_write_metadata(&metadata, "key", "value");
    assert_int_equal(nsdf_write_file(&file, &parts), 0);
    const uint32_t order[] = {NSDF_CHUNK_HEAD, NSDF_CHUNK_INDX, NSDF_CHUNK_QUAL, NSDF_CHUNK_META,
                              NSDF_CHUNK_SEGM, NSDF_CHUNK_SEGM, NSDF_CHUNK_ENDF};
    size_t at = NSDF_PREAMBLE_SIZE, segment = 0;
    for (size_t i = 0; i < 7; i++) {
        nsdf_chunk_header h;
        assert_int_equal(nsdf_read_chunk_header(file.data + at, file.size - at, &h, NULL), NSDF_PARSE_OK);
        assert_int_equal(h.type, order[i]);
        assert_int_equal(h.flags & NSDF_CHUNK_CRITICAL, i != 2 && i != 3);
        assert_int_equal(nsdf_check_chunk(file.data + at, &h, NULL), NSDF_PARSE_OK);
        if (h.type == NSDF_CHUNK_SEGM) {
            assert_int_equal(entries[segment].offset, at);
            assert_int_equal(entries[segment++].size, h.length + NSDF_CHUNK_OVERHEAD);
        }
        at += (size_t)h.length + NSDF_CHUNK_OVERHEAD;
    }
    assert_int_equal(at, file.size);
    nsdf_buffer_free(&file);
    nsdf_buffer_free(&metadata);
    nsdf_buffer_free(&segments[0]);
    nsdf_buffer_free(&segments[1]);
}

static void buffers_remember_that_memory_ran_out(void **state) {
    (void)state;
    nsdf_buffer b = {0}, out = {0};
    nsdf_index_entry entry = {0};
    nsdf_buffer_u8(&b, 7);
    volatile size_t impossible = SIZE_MAX;
    nsdf_buffer_append(&b, "", impossible);
    assert_true(b.failed && b.size == 1);
    nsdf_buffer_u8(&b, 8);
    assert_int_equal(b.size, 1);
    nsdf_file_parts parts = {.header = example_header(), .segments = &b, .entries = &entry};
    assert_int_equal(nsdf_write_file(&out, &parts), -1);
    nsdf_buffer_free(&b);
    nsdf_buffer_free(&out);
    assert_true(b.data == NULL && b.failed == 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_specification_shows_the_bytes_that_are_written),
        cmocka_unit_test(preamble_checks_come_in_order),
        cmocka_unit_test(other_minor_versions_are_refused_while_major_is_zero),
        cmocka_unit_test(chunks_are_checked),
        cmocka_unit_test(checksums_match_published_values),
        cmocka_unit_test(headers_come_back_unchanged),
        cmocka_unit_test(every_header_field_is_validated),
        cmocka_unit_test(indices_must_cover_all_frames_in_order),
        cmocka_unit_test(cross_fades_must_lie_where_both_models_are),
        cmocka_unit_test(two_cross_fades_may_not_meet_in_a_segment),
        cmocka_unit_test(a_single_frame_has_an_index_of_its_own_kind),
        cmocka_unit_test(quality_comes_back_and_is_validated),
        cmocka_unit_test(metadata_come_back_in_order),
        cmocka_unit_test(metadata_must_be_utf8_without_nul),
        cmocka_unit_test(whole_files_hold_their_chunks_in_order),
        cmocka_unit_test(buffers_remember_that_memory_ran_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
