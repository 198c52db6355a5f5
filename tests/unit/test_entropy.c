#include "format_samples.h"

#include "entropy_read.h"
#include "entropy_write.h"

/* One uniform array of a given shape in a description of its own. */
static nsdf_array_desc *single_array(nsdf_network_desc *d, nsdf_entropy_kind entropy, uint32_t planes, uint32_t rows,
                                     uint32_t cols) {
    memset(d, 0, sizeof *d);
    d->list.entropy = (uint8_t)entropy;
    d->list.count = 1;
    d->list.tensors[0].array_count = 1;
    nsdf_array_desc *a = &d->list.tensors[0].arrays[0];
    a->planes = planes;
    a->rows = rows;
    a->cols = cols;
    a->quantiser = NSDF_QUANT_UNIFORM;
    return a;
}

static void fit_range(nsdf_array_desc *a, const int32_t *residuals) {
    int32_t min = residuals[0], max = residuals[0];
    for (size_t i = 0; i < nsdf_array_size(a); i++) {
        min = residuals[i] < min ? residuals[i] : min;
        max = residuals[i] > max ? residuals[i] : max;
    }
    a->residual_min = min;
    a->bits = (uint8_t)nsdf_bit_length((uint32_t)(max - min));
}

/* Reads `size` bytes of a stream, from a heap block of exactly that size. */
static nsdf_parse decode(const nsdf_network_desc *d, const uint8_t *data, size_t size, int32_t *residuals) {
    uint8_t *exact = malloc(size ? size : 1), *planes = malloc((size_t)nsdf_all_plane_bytes(&d->list) + 1);
    nsdf_residual_reader reader;
    const char *what = NULL;
    assert_true(exact && planes);
    if (size)
        memcpy(exact, data, size);
    nsdf_parse status = nsdf_residuals_open(&reader, &d->list, exact, size, planes, NULL, &what);
    for (uint32_t t = 0; t < d->list.count && status == NSDF_PARSE_OK; t++) {
        status = nsdf_residuals_next(&reader, &d->list.tensors[t].arrays[0], residuals, &what);
        residuals += nsdf_array_size(&d->list.tensors[t].arrays[0]);
    }
    if (status == NSDF_PARSE_OK)
        status = nsdf_residuals_close(&reader, &what);
    assert_true(status == NSDF_PARSE_OK || what);
    free(exact);
    free(planes);
    return status;
}

/* Size of the coded residuals, which must come back unchanged. */
static size_t coded_size(nsdf_network_desc *d, const int32_t *residuals) {
    nsdf_array_desc *a = &d->list.tensors[0].arrays[0];
    size_t count = (size_t)nsdf_array_size(a);
    int32_t *back = malloc(count * sizeof *back);
    nsdf_buffer out = {0};
    assert_non_null(back);
    fit_range(a, residuals);
    assert_int_equal(nsdf_write_residuals(&out, &d->list, residuals), 0);
    assert_int_equal(decode(d, out.data, out.size, back), NSDF_PARSE_OK);
    assert_memory_equal(back, residuals, count * sizeof *back);
    size_t size = out.size;
    nsdf_buffer_free(&out);
    free(back);
    return size;
}

/* Entropy of the rounded distribution in bits per value, from its cumulative distribution. */
static double source_entropy(double sigma, int laplace) {
    double sum = 0.0;
    for (int k = -12000; k <= 12000; k++) {
        double a = (k - 0.5) / sigma, b = (k + 0.5) / sigma, p;
        if (laplace) {
            double l = sqrt(2.0);
            p = a >= 0.0   ? 0.5 * (exp(-l * a) - exp(-l * b))
                : b <= 0.0 ? 0.5 * (exp(l * b) - exp(l * a))
                           : 1.0 - 0.5 * (exp(l * a) + exp(-l * b));
        } else {
            p = 0.5 * (erfc(a / sqrt(2.0)) - erfc(b / sqrt(2.0)));
        }
        sum -= p > 0.0 ? p * log2(p) : 0.0;
    }
    return sum;
}

/* Entropy of the values' own histogram, bytes. */
static double histogram_entropy(const int32_t *values, size_t count) {
    enum { HALF = 1 << 16 };
    uint32_t *histogram = calloc(2 * HALF, sizeof *histogram);
    double bits = 0.0;
    assert_non_null(histogram);
    for (size_t i = 0; i < count; i++)
        histogram[values[i] + HALF]++;
    for (size_t i = 0; i < 2 * HALF; i++)
        if (histogram[i])
            bits += histogram[i] * log2((double)count / histogram[i]);
    free(histogram);
    return bits / 8.0;
}

static void range_coder_is_within_three_percent_of_the_entropy(void **state) {
    (void)state;
    enum { COUNT = 64 * 64 };
    static const double sigmas[] = {2.0, 5.0, 20.0, 50.0, 200.0};
    nsdf_network_desc d;
    int32_t r[COUNT];
    uint64_t rng = 11;
    for (int laplace = 0; laplace < 2; laplace++)
        for (int s = 0; s < 5; s++) {
            single_array(&d, NSDF_ENTROPY_RANGE, 1, 64, 64);
            for (int i = 0; i < COUNT; i++)
                r[i] = (int32_t)lrint(sigmas[s] * (laplace ? sample_laplace(&rng) : sample_gauss(&rng)));
            double size = (double)coded_size(&d, r);
            assert_true(size <= 1.03 * source_entropy(sigmas[s], laplace) * COUNT / 8.0);
            /* With more levels than that, 4096 values are too few for their own histogram to show the entropy. */
            assert_true(sigmas[s] > 50.0 || size <= 1.03 * histogram_entropy(r, COUNT));
        }
}

static void range_coder_gains_from_alike_magnitudes(void **state) {
    (void)state;
    enum { PLANES = 6, ROWS = 40, COLS = 24, COUNT = PLANES * ROWS * COLS };
    nsdf_network_desc d;
    int32_t r[COUNT];
    double scale[ROWS * COLS];
    uint64_t rng = 12;
    for (int by = 0; by < 3; by++) { /* by column, by row, by element over the planes */
        for (int i = 0; i < ROWS * COLS; i++)
            scale[i] = exp(1.2 * sample_gauss(&rng));
        for (int i = 0; i < COUNT; i++) {
            int element = i % (ROWS * COLS);
            int which = by == 0 ? element % COLS : by == 1 ? element / COLS : element;
            r[i] = (int32_t)lrint(3.0 * scale[which] * sample_gauss(&rng));
        }
        single_array(&d, NSDF_ENTROPY_RANGE, PLANES, ROWS, COLS);
        assert_true((double)coded_size(&d, r) < 0.985 * histogram_entropy(r, COUNT));
    }
}

static void squashed_logits_rise_and_are_symmetric(void **state) {
    (void)state;
    uint32_t before = 0;
    for (int32_t x = -NSDF_LOGIT_MAX; x <= NSDF_LOGIT_MAX; x++) {
        uint32_t p = nsdf_squash(x);
        assert_true(p >= before && p >= 22 && p <= 65514);
        assert_true(fabs(p / 65536.0 - 1.0 / (1.0 + exp(-x / 256.0))) < 0.0025);
        assert_in_range(p + nsdf_squash(-x), 65535, 65537);
        before = p;
    }
}

static void stretched_probabilities_come_back(void **state) {
    (void)state;
    nsdf_logistic_tables t;
    nsdf_logistic_fill(&t);
    for (int32_t p = 2; p < NSDF_STRETCH_SIZE - 2; p++) {
        assert_true(t.stretch[p] >= t.stretch[p - 1]);
        assert_in_range(nsdf_squash(t.stretch[p]), 16 * p, 16 * p + 300);
        assert_true(nsdf_squash(t.stretch[p] - 1) < 16 * (uint32_t)p + 8);
    }
    assert_int_equal(t.rates[0], 32768);
    assert_int_equal(t.trust[0], 0); /* a fresh model has no say */
    assert_int_equal(t.trust[1], 128);
}

/* The longest runs of one bit, then of the other: weights and sums stay inside, and the mix comes round. */
static void mixing_follows_a_source_that_turns(void **state) {
    (void)state;
    nsdf_logistic_tables t;
    nsdf_logistic_fill(&t);
    nsdf_bit_model models[4] = {{32768, 0}, {32768, 0}, {32768, 0}, {32768, 0}};
    int32_t weights[4] = {NSDF_MIX_WEIGHT_START, NSDF_MIX_WEIGHT_MAX, -NSDF_MIX_WEIGHT_MAX, 0}, votes[4];
    for (int i = 0; i < 40000; i++) {
        uint32_t bit = i >= 20000;
        for (int k = 0; k < 4; k++)
            votes[k] = nsdf_bit_vote(&models[k], &t);
        uint32_t zero = nsdf_squash(nsdf_mix(votes, weights, 4));
        nsdf_mix_learn(votes, weights, 4, zero, bit);
        for (int k = 0; k < 4; k++) {
            nsdf_bit_update(&models[k], bit, &t);
            assert_true(models[k].zero > 0 && abs(weights[k]) <= NSDF_MIX_WEIGHT_MAX);
        }
        if (i == 19999)
            assert_true(zero > 64000);
        if (i == 39999)
            assert_true(zero < 1500);
    }
}

/* Elements that rest for some planes, then move: their own past tells which. */
static void range_coder_gains_from_rest_and_motion(void **state) {
    (void)state;
    enum { PLANES = 40, ELEMENTS = 240, COUNT = PLANES * ELEMENTS };
    nsdf_network_desc d;
    int32_t r[COUNT];
    uint64_t rng = 15;
    for (int i = 0; i < COUNT; i++) {
        const int moving = (i / ELEMENTS / 8 + i % ELEMENTS / 12) % 2;
        r[i] = (int32_t)lrint((moving ? 20.0 : 0.2) * sample_gauss(&rng));
    }
    single_array(&d, NSDF_ENTROPY_RANGE, PLANES, ELEMENTS / 12, 12);
    assert_true((double)coded_size(&d, r) < 0.87 * histogram_entropy(r, COUNT));
}

static void small_arrays_cost_little_more_than_packed(void **state) {
    (void)state;
    nsdf_network_desc d;
    int32_t r[64];
    uint64_t rng = 13;
    for (int s = 0; s < 8; s++) {
        for (int i = 0; i < 64; i++)
            r[i] = (int32_t)lrint(pow(3.0, s) * sample_gauss(&rng));
        single_array(&d, NSDF_ENTROPY_NONE, 1, 64, 1);
        size_t packed = coded_size(&d, r);
        single_array(&d, NSDF_ENTROPY_RANGE, 1, 64, 1);
        assert_true(coded_size(&d, r) <= packed + packed / 10 + 4);
    }
}

static void equal_values_cost_nothing(void **state) {
    (void)state;
    nsdf_network_desc d;
    const int32_t r[6] = {-5, -5, -5, -5, -5, -5};
    for (int kind = 0; kind < NSDF_ENTROPY_COUNT; kind++) {
        single_array(&d, (nsdf_entropy_kind)kind, 1, 2, 3);
        if (nsdf_entropy_available((nsdf_entropy_kind)kind))
            assert_int_equal(coded_size(&d, r), 0);
    }
}

/* The example in the specification, section "Range coder". */
static void range_stream_is_pinned(void **state) {
    (void)state;
    static const uint8_t expected[] = {0xcd, 0x04, 0x58, 0x8c, 0xfc, 0xcf, 0xa1, 0x70, 0xb4, 0x00, 0x00};
    nsdf_network_desc d;
    const int32_t r[12] = {3, -1, 0, 0, 12, -7, 2, -1, 1, 0, 9, -6};
    nsdf_buffer out = {0};
    nsdf_array_desc *a = single_array(&d, NSDF_ENTROPY_RANGE, 2, 2, 3);
    fit_range(a, r);
    assert_int_equal(a->bits, 5);
    nsdf_range_write(&out, &d.list, r);
    assert_int_equal(out.size, sizeof expected);
    assert_memory_equal(out.data, expected, sizeof expected);
    nsdf_buffer_free(&out);
}

/* Two arrays, the second predicted from the plane before, with the extremes that a description allows. */
static void extreme_residuals_survive(void **state) {
    (void)state;
    nsdf_network_desc d;
    const int32_t r[10] = {(1 << 24) - 1, 0, 1, 5, -(1 << 24) + 2, 1, -(1 << 23), -1, -8, -2};
    for (int kind = 0; kind < NSDF_ENTROPY_COUNT; kind++) {
        nsdf_array_desc *a = single_array(&d, (nsdf_entropy_kind)kind, 2, 2, 1);
        int32_t back[10];
        nsdf_buffer out = {0};
        if (!nsdf_entropy_available((nsdf_entropy_kind)kind))
            continue;
        d.list.count = 2;
        d.list.tensors[1] = d.list.tensors[0];
        nsdf_array_desc *b = &d.list.tensors[1].arrays[0];
        b->planes = 3;
        b->predict = NSDF_PREDICT_PLANE;
        fit_range(a, r);
        fit_range(b, r + 4);
        assert_int_equal(a->bits, 24);
        assert_int_equal(nsdf_write_residuals(&out, &d.list, r), 0);
        assert_int_equal(decode(&d, out.data, out.size, back), NSDF_PARSE_OK);
        assert_memory_equal(back, r, sizeof r);
        nsdf_buffer_free(&out);
    }
}

static void every_shorter_and_longer_stream_is_refused(void **state) {
    (void)state;
    nsdf_network_desc d;
    int32_t r[300], back[300];
    uint64_t rng = 14;
    for (int i = 0; i < 300; i++)
        r[i] = (int32_t)lrint(40.0 * sample_gauss(&rng));
    for (int kind = 0; kind < NSDF_ENTROPY_COUNT; kind++) {
        nsdf_buffer out = {0};
        fit_range(single_array(&d, (nsdf_entropy_kind)kind, 3, 10, 10), r);
        if (!nsdf_entropy_available((nsdf_entropy_kind)kind))
            continue;
        assert_int_equal(nsdf_write_residuals(&out, &d.list, r), 0);
        for (size_t n = 0; n < out.size; n++)
            assert_int_not_equal(decode(&d, out.data, n, back), NSDF_PARSE_OK);
        nsdf_buffer_u8(&out, 0);
        assert_int_equal(decode(&d, out.data, out.size, back), NSDF_PARSE_CORRUPT);
        nsdf_buffer_free(&out);
    }
}

static void residuals_outside_the_described_range_are_refused(void **state) {
    (void)state;
    nsdf_network_desc d;
    const int32_t r[4] = {0, 31, 5, 2};
    int32_t back[4];
    for (int kind = NSDF_ENTROPY_DEFLATE; kind < NSDF_ENTROPY_COUNT; kind++) {
        nsdf_buffer out = {0};
        nsdf_array_desc *a = single_array(&d, (nsdf_entropy_kind)kind, 1, 2, 2);
        if (!nsdf_entropy_available((nsdf_entropy_kind)kind))
            continue;
        fit_range(a, r);
        assert_int_equal(nsdf_write_residuals(&out, &d.list, r), 0);
        a->bits = 4; /* for the range coder: also a smaller tree */
        assert_int_not_equal(decode(&d, out.data, out.size, back), NSDF_PARSE_OK);
        a->bits = 5;
        a->residual_min = 1; /* 31 stays in the same class, but 0 is too small now, and 32 fits no more */
        assert_true(kind != NSDF_ENTROPY_RANGE || decode(&d, out.data, out.size, back) != NSDF_PARSE_OK);
        nsdf_buffer_free(&out);
    }
}

static void padding_bits_must_be_zero(void **state) {
    (void)state;
    nsdf_network_desc d;
    const int32_t r[3] = {0, 7, 4};
    int32_t back[3];
    nsdf_buffer out = {0};
    fit_range(single_array(&d, NSDF_ENTROPY_NONE, 1, 1, 3), r);
    assert_int_equal(nsdf_write_residuals(&out, &d.list, r), 0);
    assert_int_equal(out.size, 2);
    assert_int_equal(out.data[0], (0 | 7 << 3 | 4 << 6) & 0xff);
    assert_int_equal(out.data[1], 1);
    out.data[1] |= 2;
    assert_int_equal(decode(&d, out.data, out.size, back), NSDF_PARSE_CORRUPT);
    nsdf_buffer_free(&out);
}

typedef struct counted_memory {
    int left; /* allocations until one fails */
    int held;
} counted_memory;

static void *counted_allocate(void *user, size_t size) {
    counted_memory *m = user;
    if (m->left-- <= 0)
        return NULL;
    m->held++;
    return malloc(size);
}

static void counted_release(void *user, void *pointer) {
    counted_memory *m = user;
    m->held -= pointer != NULL;
    free(pointer);
}

static void back_ends_allocate_through_the_hooks_only(void **state) {
    (void)state;
    nsdf_network_desc d;
    const int32_t r[4] = {0, 300, 5, 2};
    for (int kind = NSDF_ENTROPY_DEFLATE; kind <= NSDF_ENTROPY_ZSTD; kind++) {
        nsdf_buffer out = {0};
        nsdf_residual_reader reader;
        const char *what = NULL;
        uint8_t planes[8];
        fit_range(single_array(&d, (nsdf_entropy_kind)kind, 1, 2, 2), r);
        if (!nsdf_entropy_available((nsdf_entropy_kind)kind))
            continue;
        assert_int_equal(nsdf_write_residuals(&out, &d.list, r), 0);
        nsdf_parse status = NSDF_PARSE_NO_MEMORY;
        for (int left = 0; left < 20; left++) {
            counted_memory counted = {left, 0};
            nsdf_codec_memory memory = {&counted, counted_allocate, counted_release};
            status = nsdf_residuals_open(&reader, &d.list, out.data, out.size, planes, &memory, &what);
            assert_int_equal(counted.held, 0);
            assert_int_equal(status, left == 0 || counted.left < 0 ? NSDF_PARSE_NO_MEMORY : NSDF_PARSE_OK);
        }
        assert_int_equal(status, NSDF_PARSE_OK);
        nsdf_buffer_free(&out);
    }
}

static void streams_of_another_length_are_refused(void **state) {
    (void)state;
    nsdf_network_desc d;
    const int32_t r[6] = {0, 9, 5, 2, 7, 1};
    for (int kind = NSDF_ENTROPY_DEFLATE; kind <= NSDF_ENTROPY_ZSTD; kind++) {
        nsdf_buffer out = {0};
        int32_t back[7];
        nsdf_array_desc *a = single_array(&d, (nsdf_entropy_kind)kind, 1, 6, 1);
        if (!nsdf_entropy_available((nsdf_entropy_kind)kind))
            continue;
        fit_range(a, r);
        assert_int_equal(nsdf_write_residuals(&out, &d.list, r), 0);
        a->rows = 5;
        assert_int_equal(decode(&d, out.data, out.size, back), NSDF_PARSE_CORRUPT);
        a->rows = 7;
        assert_int_equal(decode(&d, out.data, out.size, back), NSDF_PARSE_CORRUPT);
        a->rows = 6;
        nsdf_buffer_append(&out, "\x50\x2a\x4d\x18\0\0\0\0", 8); /* an empty skippable zstd frame */
        assert_int_equal(decode(&d, out.data, out.size, back), NSDF_PARSE_CORRUPT);
        nsdf_buffer_free(&out);
    }
}

static void back_ends_have_names(void **state) {
    (void)state;
    assert_string_equal(nsdf_entropy_name(NSDF_ENTROPY_NONE), "none");
    assert_string_equal(nsdf_entropy_name(NSDF_ENTROPY_DEFLATE), "deflate");
    assert_string_equal(nsdf_entropy_name(NSDF_ENTROPY_ZSTD), "zstd");
    assert_string_equal(nsdf_entropy_name(NSDF_ENTROPY_RANGE), "range");
    assert_null(nsdf_entropy_name((nsdf_entropy_kind)4));
    assert_true(nsdf_entropy_available(NSDF_ENTROPY_NONE) && nsdf_entropy_available(NSDF_ENTROPY_RANGE));
    assert_false(nsdf_entropy_available((nsdf_entropy_kind)4));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(range_coder_is_within_three_percent_of_the_entropy),
        cmocka_unit_test(squashed_logits_rise_and_are_symmetric),
        cmocka_unit_test(stretched_probabilities_come_back),
        cmocka_unit_test(mixing_follows_a_source_that_turns),
        cmocka_unit_test(range_coder_gains_from_alike_magnitudes),
        cmocka_unit_test(range_coder_gains_from_rest_and_motion),
        cmocka_unit_test(small_arrays_cost_little_more_than_packed),
        cmocka_unit_test(equal_values_cost_nothing),
        cmocka_unit_test(range_stream_is_pinned),
        cmocka_unit_test(extreme_residuals_survive),
        cmocka_unit_test(every_shorter_and_longer_stream_is_refused),
        cmocka_unit_test(residuals_outside_the_described_range_are_refused),
        cmocka_unit_test(padding_bits_must_be_zero),
        cmocka_unit_test(back_ends_allocate_through_the_hooks_only),
        cmocka_unit_test(streams_of_another_length_are_refused),
        cmocka_unit_test(back_ends_have_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
