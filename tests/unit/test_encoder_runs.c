/* Whole runs of the encoder: the same file for any number of threads, stopping, gaps between frames, every model and
 * coder. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "encode_samples.h"
#include "network_read.h"

/* The decoder accepts the file, and its parameters have the hash that the file states. */
static void assert_valid(const encoded *e) {
    nsdf_decoder *decoder = open_file(e);
    assert_int_equal(nsdf_verify(decoder), NSDF_OK);
    nsdf_close(&decoder);
}

/* ---- The same file -------------------------------------------------------------------------------------- */

static void test_files_depend_on_the_seed_and_not_on_the_threads(void **state) {
    static const uint32_t threads[] = {1, 1, 3, 1};
    encoded e[4];
    (void)state;
    for (int i = 0; i < 4; i++) {
        nsdf_encoder_options o = hasty_options();
        o.batch_frames = 5;
        o.steps = 40;
        o.verify = 1;
        o.threads = threads[i];
        o.seed = i == 3 ? 2 : 1;
        e[i] = encode_well(&o, swelling_box, NULL, NULL);
    }
    for (int i = 1; i < 3; i++) {
        assert_int_equal(e[i].size, e[0].size);
        assert_memory_equal(e[i].data, e[0].data, e[0].size);
    }
    assert_true(e[3].size != e[0].size || memcmp(e[3].data, e[0].data, e[0].size) != 0);
    for (int i = 0; i < 4; i++)
        free(e[i].data);
}

/* ---- Stopping ------------------------------------------------------------------------------------------- */

typedef struct listener {
    nsdf_stage stop_at; /* when this stage reports, give `answer` */
    int answer;
    int reports[4];
    nsdf_progress last;
    int returns; /* to fitting, after verification */
} listener;

static int listen_to(void *user, const nsdf_progress *p) {
    listener *l = user;
    /* where verification, once complete, has found stray pieces, fitting goes on a little */
    const int returns = p->stage == NSDF_STAGE_FIT && l->last.stage == NSDF_STAGE_VERIFY && l->last.fraction == 1.0;
    l->returns += returns;
    assert_true(returns || (p->stage >= l->last.stage && p->stage <= NSDF_STAGE_VERIFY));
    assert_true(p->fraction > 0.0 && p->fraction <= 1.0);
    /* a bound that turns out too small is measured again, from the middle of its stage */
    assert_true(p->stage != l->last.stage || p->stage == NSDF_STAGE_BOUND || p->stage == NSDF_STAGE_VERIFY ||
                p->fraction >= l->last.fraction);
    assert_true(p->elapsed >= l->last.elapsed);
    l->reports[p->stage]++;
    l->last = *p;
    return p->stage == l->stop_at ? l->answer : NSDF_CONTINUE;
}

static void test_every_stage_reports_progress_up_to_its_end(void **state) {
    nsdf_encoder_options o = hasty_options();
    listener l = {NSDF_STAGE_SAMPLE, NSDF_CONTINUE, {0}, {0}, 0};
    (void)state;
    o.verify = 1;
    encoded e = encode_well(&o, swelling_box, listen_to, &l);
    for (int stage = 0; stage < 4; stage++)
        assert_true(l.reports[stage] > 0);
    assert_true(l.last.stage == NSDF_STAGE_VERIFY && l.last.fraction == 1.0);
    assert_true(l.returns <= 3);
    assert_true(e.stats.seconds_sample + e.stats.seconds_fit + e.stats.seconds_code + e.stats.seconds_verify <
                l.last.elapsed + 0.5);
    free(e.data);
}

static void test_finish_gives_a_valid_file_at_once(void **state) {
    nsdf_encoder_options o = hasty_options();
    listener l = {NSDF_STAGE_FIT, NSDF_FINISH, {0}, {0}, 0};
    (void)state;
    o.steps = 1000000000;
    o.width = 32;
    o.verify = 1;
    encoded e = encode_well(&o, long_box, listen_to, &l);
    assert_int_equal(l.reports[NSDF_STAGE_FIT], 1);
    assert_true(e.stats.steps > 0 && e.stats.steps < o.steps);
    assert_true(e.stats.samples == 2 * 64 * e.stats.steps);
    assert_true(e.size < 2 * e.stats.parameters + 500); /* 11 bits each, quantised without the steps that simulate it */
    assert_int_equal(e.stats.quality.frames, 1);
    assert_valid(&e);
    free(e.data);
}

static void test_abort_leaves_nothing_in_every_stage(void **state) {
    (void)state;
    for (int stage = NSDF_STAGE_SAMPLE; stage <= NSDF_STAGE_VERIFY; stage++) {
        nsdf_encoder_options o = hasty_options();
        listener l = {(nsdf_stage)stage, NSDF_ABORT, {0}, {0}, 0};
        o.verify = 1;
        encoded e = encode(&o, swelling_box, listen_to, &l);
        assert_int_equal(e.status, NSDF_CANCELLED);
        assert_int_equal(e.error.status, NSDF_CANCELLED);
        assert_true(e.error.message[0] != 0);
        assert_int_equal(l.reports[stage], 1);
        assert_true(e.stats.file_size == 0 && e.size == 0);
    }
}

static void test_a_cancelled_encoder_has_no_bytes_to_write(void **state) {
    const nsdf_encoder_options o = hasty_options();
    nsdf_encoder *encoder = NULL;
    encoded e = {.size = 0};
    listener l = {NSDF_STAGE_BOUND, NSDF_ABORT, {0}, {0}, 0};
    (void)state;
    assert_int_equal(nsdf_encoder_create(&encoder, &o, NULL), NSDF_OK);
    assert_int_equal(add_frames(encoder, long_box, NULL), NSDF_OK);
    assert_int_equal(nsdf_encoder_run(encoder, listen_to, &l, NULL), NSDF_CANCELLED);
    assert_int_equal(nsdf_encoder_write(encoder, append_bytes, &e, &e.error), NSDF_INVALID_ARGUMENT);
    assert_true(e.size == 0);
    nsdf_encoder_close(&encoder);
}

/* ---- What the file says --------------------------------------------------------------------------------- */

static void test_gaps_between_frames_count_as_frames(void **state) {
    nsdf_encoder_options o = hasty_options();
    nsdf_info info;
    double last;
    (void)state;
    o.rate_num = 30000;
    o.rate_den = 1001;
    o.verify = 1;
    encoded e = encode_well(&o, swelling_box, skip_repair, NULL); /* 4, 6, 12 */
    assert_int_equal(e.stats.frames, 3);
    assert_int_equal(e.stats.nominal_frames, 9);
    assert_int_equal(e.stats.quality.frames, 3);
    nsdf_decoder *decoder = open_file(&e);
    assert_int_equal(nsdf_get_info(decoder, &info), NSDF_OK);
    assert_int_equal(info.frame_count, 9);
    assert_true(fabs(info.duration - 8.0 * 1001.0 / 30000.0) < 1e-12);
    assert_int_equal(nsdf_frame_time(decoder, 8, &last), NSDF_OK);
    assert_true(last == info.duration);
    nsdf_close(&decoder);
    free(e.data);
}

static void test_stats_are_those_of_the_file(void **state) {
    nsdf_encoder_options o = hasty_options();
    nsdf_info info;
    nsdf_segment_info segment;
    (void)state;
    o.verify = 1;
    encoded e = encode_well(&o, swelling_box, skip_repair, NULL);
    nsdf_decoder *decoder = open_file(&e);
    assert_int_equal(nsdf_get_info(decoder, &info), NSDF_OK);
    assert_int_equal(nsdf_get_segment_info(decoder, 0, &segment), NSDF_OK);
    assert_true(e.stats.file_size == e.size && info.file_size == e.size);
    assert_true(e.stats.bound == info.extraction_bound && e.stats.bound >= 1.0);
    assert_true(e.stats.diagonal == info.diagonal);
    assert_true(e.stats.parameters == segment.parameter_count);
    assert_int_equal(e.stats.triangles, 36);
    assert_int_equal(e.stats.input.dirty, 0);
    assert_memory_equal(&e.stats.quality, &info.quality, sizeof info.quality);
    assert_int_equal(info.quality.resolution, 32);
    assert_true(info.quality.mean_to_decoded > 0.0);
    nsdf_close(&decoder);
    free(e.data);
}

/* ---- Every model and every coder ------------------------------------------------------------------------ */

static void test_every_model_loss_and_sampling_gives_a_valid_file(void **state) {
    (void)state;
    for (int kind = 0; kind < SAMPLE_MODELS; kind++) {
        const nsdf_encoder_options quick = hasty_options();
        nsdf_encoder_options o = sample_model_options(kind, 2, 8);
        o.samples_per_frame = quick.samples_per_frame;
        o.steps = quick.steps;
        o.batch_frames = quick.batch_frames;
        o.batch_points = quick.batch_points;
        o.verify = 0;
        o.loss = (nsdf_loss)(kind % 3);
        o.sampling = (nsdf_sampling)(kind / 2 % 2);
        o.time_norm = (nsdf_time_norm)(kind % 2);
        o.sdf_norm = (nsdf_sdf_norm)(kind / 3 % 2);
        o.quantise_aware = kind % 4 < 2;
        o.d_half = 0.05;
        encoded e = encode_well(&o, swelling_box, skip_repair, NULL);
        assert_valid(&e);
        free(e.data);
    }
}

static void test_thesis_preset_works_with_small_layers(void **state) {
    nsdf_encoder_options o;
    (void)state;
    nsdf_encoder_options_init(&o, NSDF_PRESET_THESIS);
    o.layers = 4;
    o.width = 16;
    o.threads = 1;
    o.samples_per_frame = 2000;
    o.steps = 60;
    o.batch_points = 256;
    o.resolution = 32;
    if (!nsdf_entropy_available(NSDF_ENTROPY_DEFLATE))
        o.entropy = NSDF_CODER_RANGE;
    encoded e = encode_well(&o, swelling_box, NULL, NULL);
    assert_valid(&e);
    assert_true(e.stats.parameters == 4 * 16 + 16 + 3 * (16 * 16 + 16) + 16 + 1);
    free(e.data);
}

/* A network fitted so briefly has surface astray, for which fitting goes on. */
static void test_without_hard_samples_the_steps_are_those_asked_for(void **state) {
    (void)state;
    for (int hard = 0; hard < 2; hard++) {
        nsdf_encoder_options o = hasty_options();
        o.steps = 40;
        o.verify = 1;
        o.hard_samples = hard;
        o.smallest_piece = 0.0; /* else it would be left out */
        encoded e = encode_well(&o, swelling_box, NULL, NULL);
        assert_valid(&e);
        assert_true(hard ? e.stats.steps > 40 : e.stats.steps == 40);
        free(e.data);
    }
}

/* Spheres of radius 1 and 0.3 side by side, which a network fitted so briefly misses widely. */
static int two_sizes(uint32_t i, nsdf_surface *surface, uint32_t *number) {
    if (i >= 2)
        return 0;
    *surface = shape_empty();
    for (int small = 0; small < 2; small++) {
        const uint32_t first = surface->vertex_count;
        shape_add_sphere(surface, small ? 0.3 : 1.0, 12, 24, 0, 0);
        for (uint32_t v = first; v < surface->vertex_count; v++)
            surface->positions[3 * (size_t)v] += small ? 1.5f : -0.8f;
    }
    *number = i;
    return 1;
}

static double stored_smallest_piece(const nsdf_encoder_options *o) {
    nsdf_info info;
    encoded e = encode_well(o, two_sizes, NULL, NULL);
    nsdf_decoder *decoder = open_file(&e);
    assert_int_equal(nsdf_get_info(decoder, &info), NSDF_OK);
    nsdf_close(&decoder);
    free(e.data);
    return info.smallest_piece / info.diagonal;
}

static void test_no_piece_of_the_input_is_ever_a_speck(void **state) {
    const double small = 0.6 * sqrt(3.0) / sqrt(3.6 * 3.6 + 4.0 + 4.0);
    nsdf_encoder_options o = hasty_options();
    (void)state;
    assert_true(fabs(stored_smallest_piece(&o) - 0.5 * small) < 0.01 * small);
    o.verify = 1; /* pieces of the decoded surface are astray, maybe all */
    const double verified = stored_smallest_piece(&o);
    assert_true(verified > 0.49 * small && verified < 0.76 * small);
    o.smallest_piece = 0.0;
    assert_true(stored_smallest_piece(&o) == 0.0);
    o.smallest_piece = 0.03;
    assert_true(fabs(stored_smallest_piece(&o) - 0.03) < 1e-6);
}

static void test_every_coder_writes_every_number_of_bits(void **state) {
    (void)state;
    for (int coder = NSDF_CODER_NONE; coder <= NSDF_CODER_RANGE; coder++) {
        const int byte_planes = coder == NSDF_CODER_DEFLATE || coder == NSDF_CODER_ZSTD;
        size_t before = 0;
        if (!nsdf_entropy_available((nsdf_entropy_kind)coder))
            continue;
        for (int bits = 4; bits <= 17; bits++) {
            nsdf_encoder_options o = hasty_options();
            o.width = 16;
            o.steps = 2;
            o.quantise_aware = 0; /* the same parameters for all */
            o.entropy = (nsdf_entropy_coder)coder;
            o.weight_bits = bits == 17 ? 32 : bits;
            encoded e = encode_well(&o, long_box, skip_repair, NULL);
            assert_valid(&e);
            /* deflate and zstd see whole bytes: with two full ones a bit more costs nothing */
            assert_true(e.size > before + 10 || (byte_planes && bits > 12 && e.size >= before));
            before = e.size;
            free(e.data);
        }
    }
}

/* ---- Several codings of one fit ------------------------------------------------------------------------- */

/* Runs an encoder that is left open. */
static nsdf_encoder *run_encoder(const nsdf_encoder_options *o) {
    nsdf_encoder *encoder = NULL;
    assert_int_equal(nsdf_encoder_create(&encoder, o, NULL), NSDF_OK);
    assert_int_equal(add_frames(encoder, swelling_box, NULL), NSDF_OK);
    assert_int_equal(nsdf_encoder_run(encoder, NULL, NULL, NULL), NSDF_OK);
    return encoder;
}

static encoded bytes_of(nsdf_encoder *encoder) {
    encoded e;
    memset(&e, 0, sizeof e);
    assert_int_equal(nsdf_encoder_write(encoder, append_bytes, &e, &e.error), NSDF_OK);
    assert_int_equal(nsdf_encoder_get_stats(encoder, &e.stats), NSDF_OK);
    assert_int_equal(e.stats.file_size, e.size);
    return e;
}

static void assert_same_and_free(encoded *a, encoded *b) {
    assert_int_equal(a->size, b->size);
    assert_memory_equal(a->data, b->data, a->size);
    assert_memory_equal(&a->stats.quality, &b->stats.quality, sizeof a->stats.quality);
    assert_true(a->stats.bound == b->stats.bound);
    free(a->data);
    free(b->data);
}

static nsdf_encoder_options plain_options(double bits, nsdf_entropy_coder entropy) {
    nsdf_encoder_options o = hasty_options();
    o.verify = 1;
    o.hard_samples = 0;
    o.quantise_aware = 0;
    o.weight_bits = bits;
    o.entropy = entropy;
    return o;
}

static void test_recoding_gives_the_file_of_a_run_with_these_options(void **state) {
    static const struct {
        double bits;
        nsdf_entropy_coder entropy;
    } codings[] = {{6, NSDF_CODER_RANGE}, {6, NSDF_CODER_NONE}, {12, NSDF_CODER_NONE}, {32, NSDF_CODER_RANGE}};
    const nsdf_encoder_options first = plain_options(32, NSDF_CODER_NONE);
    nsdf_encoder *encoder = run_encoder(&first);
    (void)state;
    for (size_t i = 0; i < sizeof codings / sizeof *codings; i++) {
        const nsdf_encoder_options o = plain_options(codings[i].bits, codings[i].entropy);
        nsdf_encoder *other = run_encoder(&o);
        encoded expected = bytes_of(other);
        nsdf_encoder_close(&other);
        assert_int_equal(nsdf_encoder_recode(encoder, o.weight_bits, o.entropy, NULL, NULL, NULL), NSDF_OK);
        encoded found = bytes_of(encoder);
        assert_valid(&found);
        assert_same_and_free(&found, &expected);
    }
    nsdf_encoder_close(&encoder);
}

static void test_recoding_finds_back_to_the_first_coding(void **state) {
    nsdf_encoder_options o = hasty_options();
    (void)state;
    o.verify = 1; /* and quantisers of the fitting's own */
    nsdf_encoder *encoder = run_encoder(&o);
    encoded before = bytes_of(encoder);
    assert_int_equal(nsdf_encoder_recode(encoder, 5.0, NSDF_CODER_NONE, NULL, NULL, NULL), NSDF_OK);
    encoded small = bytes_of(encoder);
    assert_valid(&small);
    assert_true(small.size < before.size);
    free(small.data);
    assert_int_equal(nsdf_encoder_recode(encoder, o.weight_bits, o.entropy, NULL, NULL, NULL), NSDF_OK);
    encoded after = bytes_of(encoder);
    assert_same_and_free(&before, &after);
    nsdf_encoder_close(&encoder);
}

static void test_recoding_is_refused_or_stopped(void **state) {
    const nsdf_encoder_options o = plain_options(8, NSDF_CODER_NONE);
    listener l = {NSDF_STAGE_BOUND, NSDF_ABORT, {0}, {.stage = NSDF_STAGE_BOUND}, 0};
    nsdf_encoder *encoder = NULL;
    encoded e = {.size = 0};
    (void)state;
    assert_int_equal(nsdf_encoder_recode(NULL, 8, NSDF_CODER_NONE, NULL, NULL, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_encoder_create(&encoder, &o, NULL), NSDF_OK);
    assert_int_equal(nsdf_encoder_recode(encoder, 8, NSDF_CODER_NONE, NULL, NULL, &e.error), NSDF_INVALID_ARGUMENT);
    assert_string_equal(e.error.message, "nothing was encoded");
    nsdf_encoder_close(&encoder);
    encoder = run_encoder(&o);
    encoded before = bytes_of(encoder);
    assert_int_equal(nsdf_encoder_recode(encoder, 3, NSDF_CODER_NONE, NULL, NULL, &e.error), NSDF_INVALID_ARGUMENT);
    assert_string_equal(e.error.message, "weight bits are 3, expected 4 to 16, or 32");
    encoded after = bytes_of(encoder);
    assert_same_and_free(&before, &after);
    assert_int_equal(nsdf_encoder_recode(encoder, 5, NSDF_CODER_NONE, listen_to, &l, &e.error), NSDF_CANCELLED);
    assert_int_equal(nsdf_encoder_write(encoder, append_bytes, &e, NULL), NSDF_INVALID_ARGUMENT);
    nsdf_encoder_close(&encoder);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_files_depend_on_the_seed_and_not_on_the_threads),
        cmocka_unit_test(test_every_stage_reports_progress_up_to_its_end),
        cmocka_unit_test(test_finish_gives_a_valid_file_at_once),
        cmocka_unit_test(test_abort_leaves_nothing_in_every_stage),
        cmocka_unit_test(test_a_cancelled_encoder_has_no_bytes_to_write),
        cmocka_unit_test(test_gaps_between_frames_count_as_frames),
        cmocka_unit_test(test_stats_are_those_of_the_file),
        cmocka_unit_test(test_every_model_loss_and_sampling_gives_a_valid_file),
        cmocka_unit_test(test_thesis_preset_works_with_small_layers),
        cmocka_unit_test(test_without_hard_samples_the_steps_are_those_asked_for),
        cmocka_unit_test(test_no_piece_of_the_input_is_ever_a_speck),
        cmocka_unit_test(test_every_coder_writes_every_number_of_bits),
        cmocka_unit_test(test_recoding_gives_the_file_of_a_run_with_these_options),
        cmocka_unit_test(test_recoding_finds_back_to_the_first_coding),
        cmocka_unit_test(test_recoding_is_refused_or_stopped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
