/* Targets through the encoder's public interface: sizes that hold, errors that are met or said to be missed. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "encode_samples.h"

static nsdf_encoder_options block_options(void) {
    nsdf_encoder_options o = hasty_options();
    o.blocks = 60;
    o.bones = 4;
    o.block_steps = 40;
    o.block_points = 300;
    o.samples_per_frame = 1500;
    return o;
}

static nsdf_encoder_options network_options(void) {
    nsdf_encoder_options o = hasty_options();
    o.steps = 40;
    o.hard_samples = 0;
    return o;
}

static void check_size(const encoded *e, uint64_t asked) {
    if (e->size > asked || (double)e->size < 0.97 * (double)asked)
        fail_msg("asked for %llu bytes, got %zu", (unsigned long long)asked, e->size);
    assert_true(e->stats.target_met && e->stats.round_count >= 3 && e->stats.file_size == e->size);
    const nsdf_rate_round *last = &e->stats.rounds[e->stats.round_count - 1];
    assert_true(last[last->kind == NSDF_RATE_VERIFY ? -1 : 0].kind == NSDF_RATE_QUANTISE);
    assert_int_equal(e->stats.rounds[e->stats.round_count - 1].bytes, e->size);
}

static void check_sizes(nsdf_encoder_options o, const uint64_t *sizes, size_t count) {
    for (size_t i = 0; i < count; i++) {
        o.target_size = sizes[i];
        encoded e = encode_well(&o, swelling_box, NULL, NULL);
        nsdf_decoder *decoder = open_file(&e);
        check_size(&e, sizes[i]);
        nsdf_close(&decoder);
        free(e.data);
    }
}

static void test_blocks_have_the_size_asked_for(void **state) {
    const uint64_t sizes[] = {1500, 4001, 9000};
    (void)state;
    check_sizes(block_options(), sizes, sizeof sizes / sizeof *sizes);
}

static void test_networks_have_the_size_asked_for(void **state) {
    const uint64_t sizes[] = {1000, 5999};
    (void)state;
    check_sizes(network_options(), sizes, sizeof sizes / sizeof *sizes);
}

static void test_sizes_hold_with_verification(void **state) {
    nsdf_encoder_options o = block_options();
    (void)state;
    o.verify = 1;
    o.target_size = 3000;
    encoded e = encode_well(&o, growing_sphere, NULL, NULL);
    check_size(&e, 3000);
    assert_true(e.stats.quality.frames == 4);
    free(e.data);
}

static void test_bitrates_are_sizes(void **state) {
    nsdf_encoder_options o = block_options();
    (void)state;
    o.rate_num = 10; /* frames 4 to 12 last 0.8 s */
    o.target_bitrate = 30.0;
    encoded e = encode_well(&o, swelling_box, NULL, NULL);
    check_size(&e, 3000);
    free(e.data);
}

static void test_the_same_target_gives_the_same_file(void **state) {
    nsdf_encoder_options o = block_options();
    (void)state;
    o.target_size = 3000;
    encoded one = encode_well(&o, swelling_box, NULL, NULL);
    o.threads = 3;
    encoded three = encode_well(&o, swelling_box, NULL, NULL);
    assert_int_equal(one.size, three.size);
    assert_memory_equal(one.data, three.data, one.size);
    free(one.data);
    free(three.data);
}

static int finish_at_once(void *user, const nsdf_progress *progress) {
    (void)user;
    return progress->stage == NSDF_STAGE_FIT ? NSDF_FINISH : NSDF_CONTINUE;
}

static int abort_fitting(void *user, const nsdf_progress *progress) {
    (void)user;
    return progress->stage == NSDF_STAGE_FIT ? NSDF_ABORT : NSDF_CONTINUE;
}

static void test_sizes_hold_when_fitting_is_cut_short(void **state) {
    nsdf_encoder_options o = block_options();
    (void)state;
    o.target_size = 3000;
    o.block_steps = 20000; /* progress is told, and asked, ten times a second */
    encoded e = encode_well(&o, swelling_box, finish_at_once, NULL);
    assert_true(e.size <= 3000 && e.size >= 2910 && e.stats.steps < o.block_steps / 4);
    free(e.data);
    e = encode(&o, swelling_box, abort_fitting, NULL);
    assert_int_equal(e.status, NSDF_CANCELLED);
}

static void test_too_few_bytes_are_told_before_fitting(void **state) {
    nsdf_encoder_options o = block_options();
    (void)state;
    o.target_size = 510;
    encoded e = encode(&o, swelling_box, abort_fitting, NULL);
    assert_int_equal(e.status, NSDF_LIMIT);
    assert_non_null(strstr(e.error.message, "510 bytes are too few"));
    o = network_options();
    o.layers = 16;
    o.target_size = 510;
    e = encode(&o, swelling_box, abort_fitting, NULL);
    assert_int_equal(e.status, NSDF_LIMIT);
}

/* ---- Errors ----------------------------------------------------------------------------------------------- */

static encoded encode_to(nsdf_encoder_options o, frame_maker make, double error) {
    o.verify = 1;
    o.target_error = error;
    return encode_well(&o, make, NULL, NULL);
}

/* Met, or said to be missed; the trail's last verification is what the file says. */
static void check_error(const encoded *e, double asked) {
    const double mean = nsdf_mean_error(&e->stats.quality);
    double last = 0.0;
    assert_int_equal(e->stats.target_met, mean <= asked);
    for (uint32_t i = 0; i < e->stats.round_count; i++)
        if (e->stats.rounds[i].kind == NSDF_RATE_VERIFY)
            last = e->stats.rounds[i].error;
    assert_true(last > 0.0 && (!e->stats.target_met || mean <= asked));
}

static void test_smaller_errors_take_more_bytes(void **state) {
    nsdf_encoder_options o = block_options();
    (void)state;
    o.blocks = 100;
    o.block_steps = 60;
    o.block_points = 500;
    o.samples_per_frame = 3000;
    encoded coarse = encode_to(o, growing_sphere, 8e-3), fine = encode_to(o, growing_sphere, 3e-3);
    check_error(&coarse, 8e-3);
    check_error(&fine, 3e-3);
    assert_true(coarse.stats.target_met && fine.stats.target_met && coarse.size < fine.size);
    free(coarse.data);
    free(fine.data);
}

/* The file that misses is the one that was nearest. */
static void check_nearest(const encoded *e) {
    double least = 1.0;
    for (uint32_t i = 0; i < e->stats.round_count; i++)
        if (e->stats.rounds[i].kind == NSDF_RATE_VERIFY)
            least = fmin(least, e->stats.rounds[i].error);
    assert_true(nsdf_mean_error(&e->stats.quality) <= least * (1.0 + 1e-9));
}

static void test_errors_out_of_reach_are_said_to_be_missed(void **state) {
    nsdf_encoder_options o = block_options();
    (void)state;
    o.block_steps = 10;
    const encoded blocks = encode_to(o, swelling_box, 2e-6);
    o = network_options();
    o.steps = 10;
    const encoded network = encode_to(o, swelling_box, 1e-5);
    check_error(&blocks, 2e-6);
    check_nearest(&blocks);
    check_error(&network, 1e-5);
    assert_false(blocks.stats.target_met || network.stats.target_met);
    free(blocks.data);
    free(network.data);
}

static void test_networks_meet_an_error(void **state) {
    nsdf_encoder_options o = network_options();
    (void)state;
    o.steps = 300;
    o.batch_points = 512;
    const encoded e = encode_to(o, growing_sphere, 0.095);
    check_error(&e, 0.095);
    assert_true(e.stats.target_met);
    free(e.data);
}

/* The probe is too short for any surface, a whole fit is far better than asked for. */
static void test_a_network_that_is_too_good_becomes_narrower(void **state) {
    nsdf_encoder_options o = network_options();
    uint32_t widths[2] = {0, 0}, fits = 0;
    (void)state;
    o.width = 24;
    o.steps = 1500;
    o.batch_points = 512;
    const encoded e = encode_to(o, growing_sphere, 0.03);
    for (uint32_t i = 0; i < e.stats.round_count && fits < 2; i++)
        if (e.stats.rounds[i].kind == NSDF_RATE_FIT)
            widths[fits++] = e.stats.rounds[i].width;
    assert_int_equal(fits, 2);
    assert_true(widths[1] < widths[0] && widths[1] * 2 >= widths[0]);
    check_error(&e, 0.03);
    assert_true(e.stats.target_met);
    free(e.data);
}

/* ---- Options ---------------------------------------------------------------------------------------------- */

static void refuse(const nsdf_encoder_options *o, const char *text) {
    nsdf_encoder *encoder = NULL;
    nsdf_encoder_error error;
    assert_int_equal(nsdf_encoder_create(&encoder, o, &error), NSDF_INVALID_ARGUMENT);
    if (!strstr(error.message, text))
        fail_msg("'%s' does not mention '%s'", error.message, text);
}

static void test_targets_are_checked(void **state) {
    const nsdf_encoder_options good = block_options();
    nsdf_encoder_options o = good;
    (void)state;
    o.target_size = 499;
    refuse(&o, "target size is 499, expected 500");
    o.target_size = 5000;
    o.target_bitrate = 10.0;
    refuse(&o, "only one of");
    o = good;
    o.target_error = 1e-3;
    refuse(&o, "without verifying");
    o.verify = 1;
    o.entropy = NSDF_CODER_ZSTD;
    refuse(&o, "range coder");
    o.entropy = NSDF_CODER_RANGE;
    o.target_error = 0.2;
    refuse(&o, "target error is 0.2, expected 1e-06 to 0.1");
    o.target_error = NAN;
    refuse(&o, "target error");
    o.target_error = 0.0;
    o.target_bitrate = -1.0;
    refuse(&o, "target bitrate is -1");
}

static void test_without_a_target_there_are_no_rounds(void **state) {
    const nsdf_encoder_options o = network_options();
    (void)state;
    encoded e = encode_well(&o, swelling_box, NULL, NULL);
    assert_true(e.stats.target_met && e.stats.round_count == 0);
    free(e.data);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_blocks_have_the_size_asked_for),
        cmocka_unit_test(test_networks_have_the_size_asked_for),
        cmocka_unit_test(test_sizes_hold_with_verification),
        cmocka_unit_test(test_bitrates_are_sizes),
        cmocka_unit_test(test_the_same_target_gives_the_same_file),
        cmocka_unit_test(test_sizes_hold_when_fitting_is_cut_short),
        cmocka_unit_test(test_too_few_bytes_are_told_before_fitting),
        cmocka_unit_test(test_smaller_errors_take_more_bytes),
        cmocka_unit_test(test_errors_out_of_reach_are_said_to_be_missed),
        cmocka_unit_test(test_networks_meet_an_error),
        cmocka_unit_test(test_a_network_that_is_too_good_becomes_narrower),
        cmocka_unit_test(test_targets_are_checked),
        cmocka_unit_test(test_without_a_target_there_are_no_rounds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
