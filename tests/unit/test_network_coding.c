#include "format_samples.h"

#include "fourier.h"

static void assert_same_shape(const nsdf_network_desc *a, const nsdf_network_desc *b) {
    assert_int_equal(a->input, b->input);
    assert_int_equal(a->fourier_source, b->fourier_source);
    assert_int_equal(a->fourier_count, b->fourier_count);
    assert_true(a->fourier_seed == b->fourier_seed && a->fourier_sigma == b->fourier_sigma);
    assert_true(a->time_scale == b->time_scale && a->value_scale == b->value_scale);
    assert_true(a->value_offset == b->value_offset);
    assert_int_equal(a->layer_count, b->layer_count);
    for (uint32_t i = 0; i < a->layer_count; i++) {
        assert_int_equal(a->layers[i].width, b->layers[i].width);
        assert_int_equal(a->layers[i].activation, b->layers[i].activation);
        assert_true(a->layers[i].omega == b->layers[i].omega);
    }
    assert_int_equal(a->list.count, b->list.count);
}

static void assert_same_tensors(const nsdf_network_desc *a, const nsdf_network_desc *b) {
    for (uint32_t t = 0; t < a->list.count; t++) {
        const nsdf_tensor_desc *p = &a->list.tensors[t], *q = &b->list.tensors[t];
        assert_int_equal(p->kind, q->kind);
        assert_int_equal(p->rows, q->rows);
        assert_int_equal(p->cols, q->cols);
        assert_int_equal(p->knots, q->knots);
        assert_int_equal(p->rank, q->rank);
        for (uint32_t k = 0; k < p->array_count; k++) {
            assert_int_equal(nsdf_array_size(&p->arrays[k]), nsdf_array_size(&q->arrays[k]));
            assert_int_equal(p->arrays[k].quantiser, q->arrays[k].quantiser);
            assert_int_equal(p->arrays[k].predict, q->arrays[k].predict);
            assert_int_equal(p->arrays[k].residual_min, q->arrays[k].residual_min);
            assert_true(p->arrays[k].step == q->arrays[k].step && p->arrays[k].offset == q->arrays[k].offset);
        }
    }
}

static void every_back_end_gives_back_every_kind_of_tensor(void **state) {
    (void)state;
    uint64_t rng = 7;
    for (int round = 0; round < 400; round++) {
        nsdf_network_desc d, back;
        size_t size = 0, coded = 0;
        nsdf_fault fault = {0, ""};
        sample_network(&rng, &d, (nsdf_entropy_kind)(round % NSDF_ENTROPY_COUNT));
        if (!nsdf_entropy_available((nsdf_entropy_kind)d.list.entropy))
            continue;
        int32_t *q = sample_parameters(&rng, &d);
        uint8_t *part = sample_part(&d, q, &size);
        float *expected = sample_expected(&d, q), *values = NULL;
        assert_int_equal(nsdf_read_network_desc(part, size, &back, &coded, &fault), NSDF_PARSE_OK);
        assert_same_shape(&d, &back);
        assert_same_tensors(&d, &back);
        assert_int_equal(sample_decode(part, size, &values, &fault), NSDF_PARSE_OK);
        assert_memory_equal(values, expected, (size_t)nsdf_parameter_count(&d.list) * sizeof *values);
        free(values);
        free(expected);
        free(part);
        free(q);
    }
}

static void every_prefix_and_every_longer_part_is_refused(void **state) {
    (void)state;
    uint64_t rng = 21;
    for (uint32_t round = 0; round < 24; round++) {
        nsdf_network_desc d;
        size_t size = 0;
        sample_network(&rng, &d, (nsdf_entropy_kind)(round % NSDF_ENTROPY_COUNT));
        if (!nsdf_entropy_available((nsdf_entropy_kind)d.list.entropy))
            continue;
        int32_t *q = sample_parameters(&rng, &d);
        uint8_t *part = sample_part(&d, q, &size);
        for (size_t n = 0; n <= size + 1; n += n + 40 < size && n > 300 ? 37 : 1) {
            uint8_t *copy = calloc(n ? n : 1, 1);
            float *values = NULL;
            nsdf_fault fault = {UINT64_MAX, ""};
            memcpy(copy, part, n < size ? n : size);
            nsdf_parse status = sample_decode(copy, n, &values, &fault);
            assert_int_equal(status, n < size ? NSDF_PARSE_TRUNCATED : n > size ? NSDF_PARSE_CORRUPT : NSDF_PARSE_OK);
            assert_true(status == NSDF_PARSE_OK || (fault.offset <= n && fault.what[0]));
            free(values);
            free(copy);
        }
        free(part);
        free(q);
    }
}

static void flipped_bytes_never_do_more_than_fail(void **state) {
    (void)state;
    uint64_t rng = 99;
    uint32_t refused = 0, rounds = 6000;
    for (uint32_t round = 0; round < rounds; round++) {
        nsdf_network_desc d;
        size_t size = 0;
        sample_network(&rng, &d, (nsdf_entropy_kind)(round % NSDF_ENTROPY_COUNT));
        if (!nsdf_entropy_available((nsdf_entropy_kind)d.list.entropy))
            continue;
        int32_t *q = sample_parameters(&rng, &d);
        uint8_t *part = sample_part(&d, q, &size);
        uint32_t flips = 1 + sample_below(&rng, 4);
        for (uint32_t i = 0; i < flips; i++) {
            uint32_t front = sample_below(&rng, 2) && size > 120 ? 120 : (uint32_t)size;
            part[sample_below(&rng, front)] ^= (uint8_t)(1 + sample_below(&rng, 255));
        }
        float *values = NULL;
        nsdf_fault fault = {0, ""};
        nsdf_parse status = sample_decode(part, size, &values, &fault);
        refused += status != NSDF_PARSE_OK;
        assert_true(status == NSDF_PARSE_OK || status == NSDF_PARSE_NO_MEMORY || fault.what[0]);
        free(values);
        free(part);
        free(q);
    }
    assert_true(refused > rounds / 4);
}

/* A one-layer xyz network with one uniform weight array, to be bent field by field. */
static void plain_network(nsdf_network_desc *d) {
    memset(d, 0, sizeof *d);
    d->time_scale = d->value_scale = 1.0f;
    d->layer_count = 1;
    d->layers[0].width = 1;
    d->list.count = 2;
    for (uint32_t t = 0; t < 2; t++) {
        d->list.tensors[t].rows = 1;
        d->list.tensors[t].cols = t ? 1 : 3;
        nsdf_tensor_layout(&d->list.tensors[t]);
        d->list.tensors[t].arrays[0].quantiser = NSDF_QUANT_UNIFORM;
        d->list.tensors[t].arrays[0].step = 0.5f;
    }
}

/* Writes `bytes` over the plain network's part at `offset` and expects CORRUPT there. */
static void expect_corrupt_at(size_t offset, const char *bytes, size_t count, size_t fault_offset) {
    nsdf_network_desc d;
    const int32_t q[4] = {1, -2, 3, 4};
    size_t size = 0;
    float *values = NULL;
    nsdf_fault fault = {UINT64_MAX, ""};
    plain_network(&d);
    uint8_t *part = sample_part(&d, q, &size);
    memcpy(part + offset, bytes, count);
    assert_int_equal(sample_decode(part, size, &values, &fault), NSDF_PARSE_CORRUPT);
    assert_int_equal(fault.offset, fault_offset);
    free(part);
}

static void forbidden_fields_are_named_with_their_offset(void **state) {
    (void)state;
    expect_corrupt_at(0, "\3", 1, 0);                 /* input kind */
    expect_corrupt_at(1, "\1", 1, 1);                 /* stored B without Fourier features */
    expect_corrupt_at(2, "\4", 1, 2);                 /* back end */
    expect_corrupt_at(3, "\0", 1, 3);                 /* no layer */
    expect_corrupt_at(3, "\41", 1, 3);                /* 33 layers */
    expect_corrupt_at(4, "\1", 1, 4);                 /* Fourier rows without Fourier features */
    expect_corrupt_at(6, "\0\0\200\177", 4, 6);       /* time scale infinite */
    expect_corrupt_at(10, "\0\0\0\0", 4, 10);         /* value scale 0 */
    expect_corrupt_at(14, "\1\0\300\377", 4, 14);     /* value offset NaN */
    expect_corrupt_at(18, "\0\0", 2, 18);             /* width 0 */
    expect_corrupt_at(18, "\1\4", 2, 18);             /* width 1025 */
    expect_corrupt_at(20, "\4", 1, 20);               /* activation */
    expect_corrupt_at(18, "\2\0", 2, 21);             /* last width 2 */
    expect_corrupt_at(21, "\3", 1, 21);               /* tensor kind */
    expect_corrupt_at(21, "\1\3\0", 3, 22);           /* 3 knots */
    expect_corrupt_at(21, "\2\4\0\0\0", 5, 24);       /* rank 0 */
    expect_corrupt_at(21, "\2\4\0\1\1", 5, 24);       /* rank 257 */
    expect_corrupt_at(22, "\2", 1, 22);               /* quantiser */
    expect_corrupt_at(22, "\101", 1, 22);             /* prediction */
    expect_corrupt_at(22, "\20", 1, 22);              /* prediction of a raw array */
    expect_corrupt_at(22, "\40", 1, 22);              /* the same by a line */
    expect_corrupt_at(23, "\31", 1, 23);              /* 25 bits */
    expect_corrupt_at(24, "\0\0\0\2", 4, 24);         /* residual 2^25 */
    expect_corrupt_at(28, "\0\0\0\277", 4, 28);       /* negative step */
    expect_corrupt_at(32, "\0\0\200\377", 4, 32);     /* offset infinite */
    expect_corrupt_at(24, "\0\0\0\1", 4, 59);         /* q of 2^24, found in the coded stream */
    expect_corrupt_at(28, "\377\377\177\177", 4, 59); /* step so large that w is not finite */
    expect_corrupt_at(60, "\377", 1, 59);             /* padding bits */
}

static void too_many_parameters_are_refused(void **state) {
    (void)state;
    nsdf_buffer part = {0};
    nsdf_network_desc d;
    size_t coded = 0;
    const uint8_t front[6] = {0, 0, 0, 3, 0, 0}, wide[3] = {0, 4, 0}, last[3] = {1, 0, 0};
    const uint8_t spline[4] = {1, 0xff, 0xff, 0}, constant[2] = {0, 0};
    nsdf_buffer_append(&part, front, 6);
    nsdf_buffer_f32(&part, 1.0f);
    nsdf_buffer_f32(&part, 1.0f);
    nsdf_buffer_f32(&part, 0.0f);
    nsdf_buffer_append(&part, wide, 3);
    nsdf_buffer_append(&part, wide, 3);
    nsdf_buffer_append(&part, last, 3);
    for (int i = 0; i < 6; i++)
        nsdf_buffer_append(&part, i == 2 ? spline : constant, i == 2 ? 4 : 2);
    nsdf_fault fault = {0, ""};
    assert_int_equal(nsdf_read_network_desc(part.data, part.size, &d, &coded, &fault), NSDF_PARSE_CORRUPT);
    assert_string_equal(fault.what, "more than 2^28 parameters");
    nsdf_buffer_free(&part);
}

static void fourier_fields_are_validated(void **state) {
    (void)state;
    nsdf_network_desc d, back;
    nsdf_buffer payload = {0};
    const int32_t q[3] = {1, 2, 3};
    size_t coded = 0;
    plain_network(&d);
    d.input = NSDF_INPUT_FOURIER;
    d.fourier_count = 1;
    d.fourier_sigma = 1.0f;
    d.list.tensors[0].cols = 2;
    nsdf_tensor_layout(&d.list.tensors[0]);
    assert_int_equal(nsdf_write_network_part(&payload, &d, q), 0);
    uint8_t *part = payload.data + 12;
    size_t size = payload.size - 12;
    assert_int_equal(nsdf_read_network_desc(part, size, &back, &coded, NULL), NSDF_PARSE_OK);
    part[17] = 0xbf; /* sigma -1 */
    assert_int_equal(nsdf_read_network_desc(part, size, &back, &coded, NULL), NSDF_PARSE_CORRUPT);
    part[17] = 0x7f;
    part[16] = 0x80; /* infinite */
    assert_int_equal(nsdf_read_network_desc(part, size, &back, &coded, NULL), NSDF_PARSE_CORRUPT);
    part[4] = 0; /* no rows */
    assert_int_equal(nsdf_read_network_desc(part, size, &back, &coded, NULL), NSDF_PARSE_CORRUPT);
    nsdf_buffer_free(&payload);
}

static void segments_are_split_into_their_parts(void **state) {
    (void)state;
    nsdf_network_desc d;
    nsdf_buffer payload = {0};
    nsdf_part_ref parts[NSDF_MAX_PARTS];
    const int32_t q[4] = {1, 2, 3, 4};
    uint32_t count = 0;
    plain_network(&d);
    nsdf_write_segment_start(&payload, 2);
    assert_int_equal(nsdf_write_network_part(&payload, &d, q), 0);
    assert_int_equal(nsdf_write_network_part(&payload, &d, q), 0);
    assert_int_equal(nsdf_read_parts(payload.data, payload.size, parts, &count, NULL), NSDF_PARSE_OK);
    assert_int_equal(count, 2);
    assert_int_equal(parts[0].size, parts[1].size);
    assert_memory_equal(parts[0].data, parts[1].data, parts[0].size);
    for (size_t n = 0; n < payload.size; n++)
        assert_int_equal(nsdf_read_parts(payload.data, n, parts, &count, NULL), NSDF_PARSE_TRUNCATED);
    nsdf_buffer_u8(&payload, 0);
    assert_int_equal(nsdf_read_parts(payload.data, payload.size, parts, &count, NULL), NSDF_PARSE_CORRUPT);
    payload.data[4] = NSDF_PART_BLOCKS + 1;
    assert_int_equal(nsdf_read_parts(payload.data, payload.size, parts, &count, NULL), NSDF_PARSE_FEATURE);
    payload.data[0] = 17;
    assert_int_equal(nsdf_read_parts(payload.data, payload.size, parts, &count, NULL), NSDF_PARSE_CORRUPT);
    payload.data[0] = 0;
    assert_int_equal(nsdf_read_parts(payload.data, payload.size, parts, &count, NULL), NSDF_PARSE_CORRUPT);
    nsdf_buffer_free(&payload);
}

static void the_writer_refuses_what_a_reader_would(void **state) {
    (void)state;
    nsdf_network_desc d;
    nsdf_buffer payload = {0};
    int32_t q[4] = {1, 2, 3, NSDF_MAX_QUANTISED};
    plain_network(&d);
    assert_int_equal(nsdf_write_network_part(&payload, &d, q), -1);
    q[3] = 1;
    d.layers[0].width = 2;
    assert_int_equal(nsdf_write_network_part(&payload, &d, q), -1);
    plain_network(&d);
    d.list.entropy = 4;
    assert_int_equal(nsdf_write_network_part(&payload, &d, q), -1);
    plain_network(&d);
    q[0] = -(NSDF_MAX_QUANTISED - 1); /* with q[1] = 2^24 - 1: a span of 25 bits */
    q[1] = NSDF_MAX_QUANTISED - 1;
    assert_int_equal(nsdf_write_network_part(&payload, &d, q), -1);
    assert_int_equal(payload.size, 0);
    nsdf_buffer_free(&payload);
}

static void descriptions_stay_small(void **state) {
    (void)state;
    nsdf_network_desc d;
    size_t size = 0, coded = 0;
    memset(&d, 0, sizeof d);
    d.time_scale = d.value_scale = 1.0f;
    d.layer_count = 4;
    d.list.count = 8;
    for (uint32_t i = 0; i < 4; i++) {
        d.layers[i].width = i < 3 ? 64 : 1;
        d.layers[i].activation = i < 3 ? NSDF_ACT_SINE : NSDF_ACT_IDENTITY;
        for (uint32_t k = 0; k < 2; k++) {
            nsdf_tensor_desc *t = &d.list.tensors[2 * i + k];
            t->kind = k || !i ? NSDF_TENSOR_SPLINE : NSDF_TENSOR_CONSTANT;
            t->knots = 8;
            t->rows = d.layers[i].width;
            t->cols = k ? 1 : i ? 64 : 3;
            nsdf_tensor_layout(t);
            t->arrays[0].quantiser = NSDF_QUANT_UNIFORM;
        }
    }
    int32_t *q = calloc((size_t)nsdf_parameter_count(&d.list), sizeof *q);
    uint8_t *part = sample_part(&d, q, &size);
    assert_int_equal(nsdf_read_network_desc(part, size, &d, &coded, NULL), NSDF_PARSE_OK);
    assert_in_range(coded, 1, 200);
    assert_int_equal(size, coded + 8); /* every parameter is the same: no coded bytes */
    free(part);
    free(q);
}

static void slow_change_is_predicted_from_the_plane_before(void **state) {
    (void)state;
    nsdf_network_desc d;
    int32_t q[8 * 3 + 1];
    size_t size = 0;
    plain_network(&d);
    d.list.entropy = NSDF_ENTROPY_RANGE;
    d.list.tensors[0].kind = NSDF_TENSOR_SPLINE;
    d.list.tensors[0].knots = 8;
    nsdf_tensor_layout(&d.list.tensors[0]);
    for (int i = 0; i < 25; i++)
        q[i] = 1000 * (1 + i % 3) + 50 * (i / 3 % 2);
    free(sample_part(&d, q, &size));
    assert_int_equal(d.list.tensors[0].arrays[0].predict, NSDF_PREDICT_PLANE);
    for (int i = 0; i < 25; i++)
        q[i] = i / 3 % 2 ? 40 : -40;
    free(sample_part(&d, q, &size));
    assert_int_equal(d.list.tensors[0].arrays[0].predict, NSDF_PREDICT_NONE);
}

static void rows_that_resemble_each_other_are_predicted_from_the_row_before(void **state) {
    (void)state;
    nsdf_network_desc d;
    int32_t q[3 * 40 + 40 + 40 + 1] = {0};
    size_t size = 0;
    plain_network(&d);
    d.layer_count = 2;
    d.layers[0].width = 40;
    d.layers[0].activation = NSDF_ACT_RELU;
    d.layers[1].width = 1;
    d.layers[1].activation = NSDF_ACT_IDENTITY;
    d.list.entropy = NSDF_ENTROPY_RANGE;
    d.list.count = 4;
    for (uint32_t t = 0; t < 4; t++) {
        nsdf_tensor_desc *tensor = &d.list.tensors[t];
        *tensor = d.list.tensors[0];
        tensor->rows = t < 2 ? 40 : 1;
        tensor->cols = t == 0 ? 3 : t == 2 ? 40 : 1;
        nsdf_tensor_layout(tensor);
    }
    for (int i = 0; i < 120; i++)
        q[i] = 100 * (i % 3) + 10 * (i / 3) + i % 2;
    float *expected = sample_expected(&d, q), *values = NULL;
    uint8_t *part = sample_part(&d, q, &size);
    assert_int_equal(d.list.tensors[0].arrays[0].predict, NSDF_PREDICT_ROW);
    assert_true(size < 180); /* 120 numbers of 10 bits would take 150 bytes and the description 130 */
    assert_int_equal(sample_decode(part, size, &values, NULL), NSDF_PARSE_OK);
    assert_memory_equal(values, expected, (size_t)nsdf_parameter_count(&d.list) * sizeof *values);
    free(values);
    free(expected);
    free(part);
}

/* Three splines with 12 knots on lines of their own slopes, up to 1: residuals are -2 or 2 from plane 2 on. */
static void steady_change_is_predicted_by_a_line(void **state) {
    (void)state;
    nsdf_network_desc d;
    int32_t q[12 * 3 + 1] = {0};
    size_t size = 0;
    plain_network(&d);
    d.list.entropy = NSDF_ENTROPY_RANGE;
    d.list.tensors[0].kind = NSDF_TENSOR_SPLINE;
    d.list.tensors[0].knots = 12;
    nsdf_tensor_layout(&d.list.tensors[0]);
    for (int i = 0; i < 36; i++)
        q[i] = 100 * (i % 3) + (i / 3) * (37 - 31 * (i % 3)) + i / 3 % 2;
    float *expected = sample_expected(&d, q), *values = NULL;
    uint8_t *part = sample_part(&d, q, &size);
    assert_int_equal(d.list.tensors[0].arrays[0].predict, NSDF_PREDICT_LINEAR);
    assert_int_equal(part[24] >> 4, 2); /* behind kind and knots of the first tensor */
    assert_int_equal(sample_decode(part, size, &values, NULL), NSDF_PARSE_OK);
    assert_memory_equal(values, expected, 37 * sizeof *values);
    free(values);
    free(expected);
    free(part);
}

static void quantised_values_are_the_nearest(void **state) {
    (void)state;
    uint64_t rng = 5;
    float values[500], step, offset;
    int32_t q[500];
    for (int bits = 2; bits <= 16; bits++) {
        for (int i = 0; i < 500; i++)
            values[i] = (float)sample_gauss(&rng);
        nsdf_minmax_quantiser(values, 500, bits, &step, &offset);
        assert_int_equal(nsdf_quantise(values, 500, step, offset, q), 0);
        for (int i = 0; i < 500; i++) {
            double error = fabs((double)nsdf_dequantise(q[i], step, offset) - (double)values[i]);
            assert_true(error <= 0.5 * (double)step + 1e-6);
            assert_in_range(q[i] + (1 << (bits - 1)), 0, (1 << bits) - 1);
        }
    }
}

static void quantiser_edges(void **state) {
    (void)state;
    float step = 1.0f, offset = 1.0f;
    const float same[3] = {0.3f, 0.3f, 0.3f}, ties[4] = {0.5f, 1.5f, -0.5f, 2.5f}, nan[1] = {NAN};
    const float large[1] = {16777216.0f};
    int32_t q[4];
    nsdf_minmax_quantiser(same, 3, 8, &step, &offset);
    assert_true(step == 0.0f && offset == 0.3f);
    assert_int_equal(nsdf_quantise(same, 3, step, offset, q), 0);
    assert_true(nsdf_dequantise(q[2], step, offset) == 0.3f);
    assert_int_equal(nsdf_quantise(ties, 4, 1.0f, 0.0f, q), 0);
    assert_true(q[0] == 0 && q[1] == 2 && q[2] == 0 && q[3] == 2);
    assert_int_equal(nsdf_quantise(nan, 1, 1.0f, 0.0f, q), -1);
    assert_int_equal(nsdf_quantise(large, 1, 1.0f, 0.0f, q), -1);
    assert_int_equal(nsdf_quantise(large, 1, 0.0f, 0.0f, q), 0);
    assert_true(nsdf_dequantise(16777215, 0.1f, 3.0f) == (float)(3.0 + (double)0.1f * 16777215.0));
}

/* Reference values made with a separate program from the text of the specification. */
static void fourier_matrix_is_pinned(void **state) {
    (void)state;
    const float expected[8] = {0x1.2f51000000000p+1f,  0x1.7b48000000000p-1f,  -0x1.c5b4000000000p-1f,
                               -0x1.5de4000000000p-1f, -0x1.c5a4000000000p-1f, 0x1.36fa000000000p+0f,
                               -0x1.9272000000000p+0f, -0x1.607b000000000p+1f};
    float b[8], wide[4 * 256];
    nsdf_fourier_matrix(1, 2.0f, 2, b);
    for (int i = 0; i < 8; i++)
        assert_true(b[i] == expected[i]);
    nsdf_fourier_matrix(3, 5.0f, 256, wide);
    double mean = 0.0, square = 0.0;
    for (int i = 0; i < 1024; i++) {
        mean += (double)wide[i] / 1024.0;
        square += (double)wide[i] * (double)wide[i] / 1024.0;
    }
    assert_true(fabs(mean) < 0.5 && fabs(sqrt(square) - 5.0) < 0.4);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_back_end_gives_back_every_kind_of_tensor),
        cmocka_unit_test(every_prefix_and_every_longer_part_is_refused),
        cmocka_unit_test(flipped_bytes_never_do_more_than_fail),
        cmocka_unit_test(forbidden_fields_are_named_with_their_offset),
        cmocka_unit_test(too_many_parameters_are_refused),
        cmocka_unit_test(fourier_fields_are_validated),
        cmocka_unit_test(segments_are_split_into_their_parts),
        cmocka_unit_test(the_writer_refuses_what_a_reader_would),
        cmocka_unit_test(descriptions_stay_small),
        cmocka_unit_test(slow_change_is_predicted_from_the_plane_before),
        cmocka_unit_test(rows_that_resemble_each_other_are_predicted_from_the_row_before),
        cmocka_unit_test(steady_change_is_predicted_by_a_line),
        cmocka_unit_test(quantised_values_are_the_nearest),
        cmocka_unit_test(quantiser_edges),
        cmocka_unit_test(fourier_matrix_is_pinned),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
