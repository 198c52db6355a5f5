/* Checkpoints: a run that goes on from one ends in the bytes of a run without a break, and nothing else is accepted. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "checkpoint.h"
#include "encode_samples.h"
#include "run_identity.h"

/* ---- Runs ------------------------------------------------------------------------------------------------ */

enum { MOST_KEPT = 64, SIZE_AT = 10, VERSION_AT = SIZE_AT + 16 };

typedef struct {
    uint8_t *data;
    size_t size;
} bytes;

/* Takes a checkpoint after every step, or the last only; stops where it is told. */
typedef struct {
    bytes kept[MOST_KEPT]; /* [steps - 1] */
    uint32_t saves;
    int answer; /* to the first report of fitting */
    int stopped;
} keeper;

static void keep(void *user, const void *data, size_t size) {
    keeper *k = user;
    assert_true(k->saves < MOST_KEPT);
    bytes *b = &k->kept[k->saves++];
    b->data = malloc(size);
    b->size = size;
    assert_non_null(b->data);
    memcpy(b->data, data, size);
}

static void free_kept(keeper *k) {
    for (uint32_t i = 0; i < k->saves; i++)
        free(k->kept[i].data);
    memset(k, 0, sizeof *k);
}

static int answer_once(void *user, const nsdf_progress *progress) {
    keeper *k = user;
    if (progress->stage != NSDF_STAGE_FIT || k->stopped)
        return NSDF_CONTINUE;
    k->stopped = 1;
    return k->answer;
}

static nsdf_encoder *encoder_of(const nsdf_encoder_options *options, frame_maker make) {
    nsdf_encoder *encoder = NULL;
    assert_int_equal(nsdf_encoder_create(&encoder, options, NULL), NSDF_OK);
    assert_int_equal(add_frames(encoder, make, NULL), NSDF_OK);
    return encoder;
}

/* Runs, from a checkpoint if one is given, and keeps those that are saved if asked to. */
static encoded run_from(const nsdf_encoder_options *options, frame_maker make, const bytes *from, keeper *k,
                        double seconds) {
    encoded e;
    nsdf_encoder *encoder = encoder_of(options, make);
    memset(&e, 0, sizeof e);
    if (k)
        assert_int_equal(nsdf_encoder_set_checkpoint(encoder, seconds, keep, k, NULL), NSDF_OK);
    if (from)
        assert_int_equal(nsdf_encoder_resume(encoder, from->data, from->size, NULL, NULL), NSDF_OK);
    e.status = nsdf_encoder_run(encoder, k ? answer_once : NULL, k, &e.error);
    if (e.status == NSDF_OK)
        e.status = nsdf_encoder_write(encoder, append_bytes, &e, &e.error);
    assert_int_equal(nsdf_encoder_get_stats(encoder, &e.stats), NSDF_OK);
    nsdf_encoder_close(&encoder);
    return e;
}

static void assert_same_and_free(encoded *e, const encoded *expected) {
    assert_int_equal(e->status, NSDF_OK);
    assert_int_equal(e->size, expected->size);
    assert_memory_equal(e->data, expected->data, e->size);
    assert_true(e->stats.steps == expected->stats.steps && e->stats.samples == expected->stats.samples);
    assert_true(e->stats.fit_error == expected->stats.fit_error);
    free(e->data);
}

static nsdf_encoder_options network_options(void) {
    nsdf_encoder_options o = hasty_options();
    o.steps = 40; /* searches for strays before steps 16, 24, 30, 36; rounding from step 30 on */
    o.batch_frames = 3;
    return o;
}

enum { BLOCK_STEPS = 20, BLOCK_ROUNDING = 14 };

static nsdf_encoder_options block_options(void) {
    nsdf_encoder_options o = hasty_options();
    o.blocks = 40;
    o.bones = 2;
    o.block_steps = BLOCK_STEPS;
    o.block_points = 300;
    o.samples_per_frame = 1500;
    o.batch_frames = 3;
    return o;
}

/* From every checkpoint named, which ends with 0, the file is that of the whole run. */
static void assert_goes_on(const nsdf_encoder_options *options, frame_maker make, const uint32_t *steps) {
    keeper k = {.saves = 0};
    const encoded plain = run_from(options, make, NULL, NULL, 0.0);
    encoded whole = run_from(options, make, NULL, &k, 0.0);
    assert_int_equal(plain.status, NSDF_OK);
    assert_int_equal(k.saves, options->blocks ? options->block_steps : options->steps);
    assert_same_and_free(&whole, &plain); /* saving changes nothing */
    for (; *steps; steps++) {
        nsdf_encoder_options other = *options;
        other.threads = *steps % 2 ? 3 : 1;
        encoded e = run_from(&other, make, &k.kept[*steps - 1], NULL, 0.0);
        assert_same_and_free(&e, &plain);
    }
    free_kept(&k);
    free(plain.data);
}

/* ---- Going on -------------------------------------------------------------------------------------------- */

static void test_a_network_ends_the_same(void **state) {
    static const uint32_t steps[] = {1, 16, 29, 30, 35, 40, 0};
    const nsdf_encoder_options o = network_options();
    (void)state;
    assert_goes_on(&o, swelling_box, steps);
}

/* Stray pieces are mended after verification, which begins with what the main fit left. */
static void test_a_verified_network_ends_the_same(void **state) {
    static const uint32_t steps[] = {20, 40, 0};
    nsdf_encoder_options o = network_options();
    (void)state;
    o.verify = 1;
    o.smallest_piece = 0.0; /* else stray pieces would be left out */
    assert_goes_on(&o, swelling_box, steps);
}

static void test_every_kind_of_network_ends_the_same(void **state) {
    static const uint32_t steps[] = {7, 0};
    (void)state;
    for (int kind = 0; kind < SAMPLE_MODELS; kind++) {
        const nsdf_encoder_options quick = hasty_options();
        nsdf_encoder_options o = sample_model_options(kind, 2, 8);
        o.samples_per_frame = quick.samples_per_frame;
        o.batch_frames = quick.batch_frames;
        o.batch_points = quick.batch_points;
        o.steps = 8;
        o.verify = 0;
        o.hard_samples = 0;
        o.quantise_aware = kind % 3 < 2;
        o.weight_bits = kind % 3 == 1 ? 32.0 : 8.0;
        o.time_norm = (nsdf_time_norm)(kind % 2);
        o.sdf_norm = (nsdf_sdf_norm)(kind / 2 % 2);
        assert_goes_on(&o, swelling_box, steps);
    }
}

static void test_blocks_end_the_same(void **state) {
    static const uint32_t steps[] = {1, BLOCK_ROUNDING - 1, BLOCK_ROUNDING, BLOCK_STEPS, 0};
    const nsdf_encoder_options o = block_options();
    (void)state;
    assert_goes_on(&o, growing_sphere, steps);
}

/* Its frames have nothing in common: the blocks follow the surface by registration. */
static int remeshed_sphere(uint32_t i, nsdf_surface *surface, uint32_t *number) {
    if (i >= 3)
        return 0;
    *surface = shape_sphere(1.0 + 0.1 * i, 16 + 2 * i, 32);
    *number = i;
    return 1;
}

static void test_blocks_without_correspondences_end_the_same(void **state) {
    static const uint32_t steps[] = {9, 0};
    const nsdf_encoder_options o = block_options();
    (void)state;
    assert_goes_on(&o, remeshed_sphere, steps);
}

/* Two breaks, each where fitting is aborted, however far it has come by then. */
static void assert_survives_aborts(nsdf_encoder_options o, frame_maker make) {
    keeper k = {.answer = NSDF_ABORT};
    encoded e = run_from(&o, make, NULL, &k, 1e9);
    assert_int_equal(e.status, NSDF_CANCELLED);
    assert_int_equal(k.saves, 1);
    assert_true(e.stats.steps < 30000000);
    keeper second = {.answer = NSDF_ABORT};
    e = run_from(&o, make, &k.kept[0], &second, 1e9);
    assert_int_equal(e.status, NSDF_CANCELLED);
    assert_int_equal(second.saves, 1);
    free_kept(&k);
    free_kept(&second);
}

static void test_an_abort_leaves_a_checkpoint(void **state) {
    nsdf_encoder_options network = network_options(), blocks = block_options();
    (void)state;
    network.steps = blocks.block_steps = 30000000;
    assert_survives_aborts(network, swelling_box);
    assert_survives_aborts(blocks, growing_sphere);
}

static void test_an_early_end_leaves_one_too(void **state) {
    nsdf_encoder_options o = block_options();
    keeper k = {.answer = NSDF_FINISH};
    uint64_t steps = 0;
    (void)state;
    o.block_steps = 30000000;
    encoded e = run_from(&o, growing_sphere, NULL, &k, 1e9);
    assert_int_equal(e.status, NSDF_OK);
    assert_int_equal(k.saves, 1);
    nsdf_encoder *encoder = encoder_of(&o, growing_sphere);
    assert_int_equal(nsdf_encoder_resume(encoder, k.kept[0].data, k.kept[0].size, &steps, NULL), NSDF_OK);
    assert_true(steps == e.stats.steps);
    nsdf_encoder_close(&encoder);
    free_kept(&k);
    free(e.data);
}

static void test_the_end_of_fitting_is_kept_in_any_case(void **state) {
    const nsdf_encoder_options o = block_options();
    keeper k = {.saves = 0};
    uint64_t steps = 0;
    (void)state;
    encoded e = run_from(&o, growing_sphere, NULL, &k, 1e9);
    assert_int_equal(k.saves, 1);
    nsdf_encoder *encoder = encoder_of(&o, growing_sphere);
    assert_int_equal(nsdf_encoder_resume(encoder, k.kept[0].data, k.kept[0].size, &steps, NULL), NSDF_OK);
    assert_int_equal(steps, BLOCK_STEPS);
    nsdf_encoder_close(&encoder);
    free_kept(&k);
    free(e.data);
}

/* ---- Refusing -------------------------------------------------------------------------------------------- */

/* One checkpoint of blocks from the middle of fitting. */
static bytes checkpoint_of(const nsdf_encoder_options *o, frame_maker make) {
    keeper k = {.saves = 0};
    encoded e = run_from(o, make, NULL, &k, 0.0);
    assert_int_equal(e.status, NSDF_OK);
    bytes b = k.kept[5];
    k.kept[5].data = NULL;
    free_kept(&k);
    free(e.data);
    return b;
}

static bytes of_blocks; /* of block_options() and growing_sphere: made once, since many tests need it */

static int make_checkpoint(void **state) {
    const nsdf_encoder_options o = block_options();
    (void)state;
    of_blocks = checkpoint_of(&o, growing_sphere);
    return 0;
}

static int free_checkpoint(void **state) {
    (void)state;
    free(of_blocks.data);
    return 0;
}

static bytes block_checkpoint(void) {
    bytes b = {malloc(of_blocks.size), of_blocks.size};
    assert_non_null(b.data);
    memcpy(b.data, of_blocks.data, b.size);
    return b;
}

/* Makes the size and the checksum right again. */
static void mend_bytes(bytes *b) {
    for (size_t i = 0; i < 8; i++)
        b->data[SIZE_AT + i] = (uint8_t)((uint64_t)b->size >> 8 * i);
    const uint64_t hash = nsdf_hash64(NSDF_HASH_START, b->data, b->size - 8);
    for (size_t i = 0; i < 8; i++)
        b->data[b->size - 8 + i] = (uint8_t)(hash >> 8 * i);
}

/* The state begins behind the trace, which comes after version, options, frames and kernels. */
static size_t trace_at(const bytes *b, uint32_t frames) {
    size_t count, options = 0;
    const nsdf_option_field *f = nsdf_option_fields(&count);
    for (size_t i = 0; i < count; i++)
        options += (size_t)f[i].fitting;
    const size_t kernels = VERSION_AT + 1 + b->data[VERSION_AT] + 8 * options + 4 + 12 * (size_t)frames + 8;
    return kernels + 1 + b->data[kernels];
}

static void assert_refused(nsdf_encoder *encoder, const void *data, size_t size, nsdf_status status, const char *text) {
    nsdf_encoder_error error = {NSDF_OK, ""};
    uint64_t steps = 77;
    assert_int_equal(nsdf_encoder_resume(encoder, data, size, &steps, &error), status);
    assert_int_equal(error.status, status);
    assert_non_null(strstr(error.message, text));
    assert_int_equal(steps, 77);
}

static void test_damaged_checkpoints_are_refused(void **state) {
    const nsdf_encoder_options o = block_options();
    bytes b = block_checkpoint();
    nsdf_encoder *encoder = encoder_of(&o, growing_sphere);
    (void)state;
    for (size_t size = 0; size < b.size; size += size < 2000 ? 1 : 97) {
        uint8_t *cut = malloc(size ? size : 1); /* no byte more, so that the sanitizer sees a read too far */
        assert_non_null(cut);
        memcpy(cut, b.data, size);
        assert_refused(encoder, cut, size, size == 0 ? NSDF_NOT_NSDF : NSDF_TRUNCATED, "checkpoint");
        free(cut);
    }
    for (size_t i = 0; i < b.size; i += i < 2000 ? 1 : 97) {
        b.data[i] ^= (uint8_t)(1u << i % 8);
        nsdf_encoder_error error;
        assert_int_not_equal(nsdf_encoder_resume(encoder, b.data, b.size, NULL, &error), NSDF_OK);
        b.data[i] ^= (uint8_t)(1u << i % 8);
    }
    b.data[b.size - 20] ^= 0x10;
    assert_refused(encoder, b.data, b.size, NSDF_CHECKSUM, "checksum");
    b.data[b.size - 20] ^= 0x10;
    uint8_t *longer = calloc(b.size + 1, 1);
    assert_non_null(longer);
    memcpy(longer, b.data, b.size);
    assert_refused(encoder, longer, b.size + 1, NSDF_CORRUPT, "expected");
    free(longer);
    assert_refused(encoder, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", 32, NSDF_NOT_NSDF, "not a checkpoint");
    assert_int_equal(nsdf_encoder_resume(encoder, b.data, b.size, NULL, NULL), NSDF_OK);
    nsdf_encoder_close(&encoder);
    free(b.data);
}

static void test_other_versions_are_refused(void **state) {
    const nsdf_encoder_options o = block_options();
    bytes b = block_checkpoint();
    nsdf_encoder *encoder = encoder_of(&o, growing_sphere);
    (void)state;
    b.data[SIZE_AT - 1]++;
    assert_refused(encoder, b.data, b.size, NSDF_UNSUPPORTED_VERSION, "layout 2");
    b.data[SIZE_AT - 1]--;
    assert_memory_equal(b.data + VERSION_AT + 1, nsdf_version_string(), b.data[VERSION_AT]);
    b.data[VERSION_AT + 1]++;
    mend_bytes(&b);
    assert_refused(encoder, b.data, b.size, NSDF_UNSUPPORTED_VERSION, "made by version ");
    b.data[VERSION_AT + 1]--;
    b.data[trace_at(&b, 4) - 1] ^= 1;
    mend_bytes(&b);
    assert_refused(encoder, b.data, b.size, NSDF_UNSUPPORTED_VERSION, "made by kernels anx, this is any");
    nsdf_encoder_close(&encoder);
    free(b.data);
}

static int wider_sphere(uint32_t i, nsdf_surface *surface, uint32_t *number) {
    if (!growing_sphere(i, surface, number))
        return 0;
    if (i == 2) {
        surface->positions[0] += 1e-3f;
        surface->positions[1] += 1e-3f;
    }
    return 1;
}

static int numbered_sphere(uint32_t i, nsdf_surface *surface, uint32_t *number) {
    const int more = growing_sphere(i, surface, number);
    *number = i < 3 ? i : 5;
    return more;
}

static int shorter_sphere(uint32_t i, nsdf_surface *surface, uint32_t *number) {
    return i < 3 && growing_sphere(i, surface, number);
}

/* Everything moved by a power of 2 of its size: relative to the first vertex it is the same. */
static int moved_sphere(uint32_t i, nsdf_surface *surface, uint32_t *number) {
    if (!growing_sphere(i, surface, number))
        return 0;
    for (size_t v = 0; v < surface->vertex_count; v++)
        surface->positions[3 * v] = (float)(int)(surface->positions[3 * v] * 1024.0f) / 1024.0f + 2.0f;
    return 1;
}

static int still_sphere(uint32_t i, nsdf_surface *surface, uint32_t *number) {
    if (!moved_sphere(i, surface, number))
        return 0;
    for (size_t v = 0; v < surface->vertex_count; v++)
        surface->positions[3 * v] -= 2.0f;
    return 1;
}

static void assert_input_refused(const bytes *b, frame_maker make, const char *text) {
    const nsdf_encoder_options o = block_options();
    nsdf_encoder *encoder = encoder_of(&o, make);
    assert_refused(encoder, b->data, b->size, NSDF_INVALID_ARGUMENT, text);
    nsdf_encoder_close(&encoder);
}

static void test_other_frames_are_refused(void **state) {
    const nsdf_encoder_options o = block_options();
    bytes b = block_checkpoint();
    (void)state;
    assert_input_refused(&b, wider_sphere, "frame 2 differs");
    assert_input_refused(&b, numbered_sphere, "frame 3 where frame 5 is now");
    assert_input_refused(&b, shorter_sphere, "4 frames, now 3");
    free(b.data);
    b = checkpoint_of(&o, still_sphere);
    assert_input_refused(&b, moved_sphere, "another place");
    free(b.data);
}

/* Every field is in the table, so that none can differ unseen: an option that is added belongs there too. */
static void test_all_options_are_compared(void **state) {
    size_t count, at = sizeof(size_t);
    const nsdf_option_field *f = nsdf_option_fields(&count);
    (void)state;
    for (size_t i = 0; i < count; i++) {
        const size_t aligned = (at + f[i].size - 1) / f[i].size * f[i].size;
        assert_true(f[i].size == 4 || f[i].size == 8);
        assert_int_equal(f[i].offset, aligned);
        at = aligned + f[i].size;
    }
    assert_int_equal((at + 7) / 8 * 8, sizeof(nsdf_encoder_options));
}

static void test_other_options_are_refused_if_they_take_part_in_fitting(void **state) {
    const nsdf_encoder_options o = block_options();
    bytes b = block_checkpoint();
    nsdf_frames frames = {0};
    size_t count, accepted = 0;
    const nsdf_option_field *f = nsdf_option_fields(&count);
    (void)state;
    for (uint32_t i = 0; i < 4; i++) {
        nsdf_surface surface;
        uint32_t number;
        assert_true(growing_sphere(i, &surface, &number));
        nsdf_input_mesh mesh = mesh_of(&surface, 1.0, 0.0, 0.0, 0.0);
        assert_int_equal(nsdf_frames_add(&frames, number, &mesh, NULL), NSDF_OK);
        free((void *)mesh.positions);
        nsdf_surface_free(&surface);
    }
    for (size_t i = 0; i < count; i++) {
        nsdf_encoder_options other = o;
        nsdf_checkpoint c = {0};
        nsdf_encoder_error error = {NSDF_OK, ""};
        ((unsigned char *)&other)[f[i].offset] ^= 2;
        const nsdf_status status = nsdf_checkpoint_open(&c, b.data, b.size, &other, &frames, NULL, &error);
        assert_int_equal(status, f[i].fitting ? NSDF_INVALID_ARGUMENT : NSDF_OK);
        assert_true(status == NSDF_OK || strstr(error.message, f[i].name));
        accepted += status == NSDF_OK;
        nsdf_checkpoint_free(&c);
    }
    assert_int_equal(accepted, 7); /* rate, threads, entropy, resolution, smallest piece, verification */
    nsdf_frames_free(&frames);
    free(b.data);
}

static void test_the_message_tells_both_values(void **state) {
    nsdf_encoder_options o = block_options();
    bytes b = block_checkpoint();
    (void)state;
    o.motion_rate = 0.5;
    o.resolution = 40;
    char text[64];
    snprintf(text, sizeof text, "motion rate was %g and is 0.5", block_options().motion_rate);
    nsdf_encoder *encoder = encoder_of(&o, growing_sphere);
    assert_refused(encoder, b.data, b.size, NSDF_INVALID_ARGUMENT, text);
    nsdf_encoder_close(&encoder);
    free(b.data);
}

/* ---- States that do not fit ------------------------------------------------------------------------------ */

static void assert_run_refuses(const nsdf_encoder_options *o, frame_maker make, const bytes *b, const char *text) {
    encoded e = run_from(o, make, b, NULL, 0.0);
    assert_int_equal(e.status, NSDF_CORRUPT);
    assert_non_null(strstr(e.error.message, "the checkpoint does not fit"));
    assert_non_null(strstr(e.error.message, text));
    assert_int_equal(e.size, 0);
}

static void assert_wrong_states_are_refused(const nsdf_encoder_options *o, frame_maker make, uint32_t frames) {
    bytes b = checkpoint_of(o, make);
    const size_t trace = trace_at(&b, frames), size = b.size;
    b.data[trace] ^= 1;
    mend_bytes(&b);
    assert_run_refuses(o, make, &b, "other samples or values");
    b.data[trace] ^= 1;
    b.data[trace + 8 + 7] = 1; /* steps */
    mend_bytes(&b);
    assert_run_refuses(o, make, &b, "more steps than there are");
    b.data[trace + 8 + 7] = 0;
    for (size_t left = trace + 8; left < size - 8; left += (size - trace) / 3) {
        bytes cut = {malloc(left + 8), left + 8};
        memcpy(cut.data, b.data, left);
        mend_bytes(&cut);
        assert_run_refuses(o, make, &cut, "");
        free(cut.data);
    }
    bytes longer = {calloc(size + 4, 1), size + 4};
    memcpy(longer.data, b.data, size - 8);
    mend_bytes(&longer);
    assert_run_refuses(o, make, &longer, "bytes behind its end");
    free(longer.data);
    free(b.data);
}

static void test_states_that_do_not_fit_are_refused(void **state) {
    const nsdf_encoder_options blocks = block_options(), network = network_options();
    (void)state;
    assert_wrong_states_are_refused(&blocks, growing_sphere, 4);
    assert_wrong_states_are_refused(&network, swelling_box, 3);
}

/* ---- Calls ----------------------------------------------------------------------------------------------- */

static void test_calls_that_make_no_sense_are_refused(void **state) {
    const nsdf_encoder_options o = block_options();
    bytes b = block_checkpoint();
    nsdf_encoder *encoder = encoder_of(&o, growing_sphere);
    keeper k = {.saves = 0};
    nsdf_encoder_error error;
    (void)state;
    assert_int_equal(nsdf_encoder_set_checkpoint(NULL, 1.0, keep, &k, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_encoder_set_checkpoint(encoder, -1.0, keep, &k, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_encoder_set_checkpoint(encoder, (double)NAN, keep, &k, &error), NSDF_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "expected 0 or more"));
    assert_int_equal(nsdf_encoder_resume(NULL, b.data, b.size, NULL, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_encoder_resume(encoder, NULL, 0, NULL, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_encoder_resume(encoder, b.data, b.size, NULL, NULL), NSDF_OK);
    assert_int_equal(nsdf_encoder_resume(encoder, b.data, b.size, NULL, NULL), NSDF_OK); /* once more */
    nsdf_surface surface = shape_cube(0.5);
    nsdf_input_mesh mesh = mesh_of(&surface, 1.0, 0.0, 0.0, 0.0);
    assert_int_equal(nsdf_encoder_add_frame(encoder, 9, &mesh, &error), NSDF_INVALID_ARGUMENT);
    assert_string_equal(error.message, "frames cannot be added after a checkpoint");
    free((void *)mesh.positions);
    nsdf_surface_free(&surface);
    assert_int_equal(nsdf_encoder_set_checkpoint(encoder, 0.0, NULL, NULL, NULL), NSDF_OK);
    assert_int_equal(nsdf_encoder_run(encoder, NULL, NULL, NULL), NSDF_OK);
    assert_int_equal(nsdf_encoder_set_checkpoint(encoder, 1.0, keep, &k, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_encoder_resume(encoder, b.data, b.size, NULL, NULL), NSDF_INVALID_ARGUMENT);
    nsdf_encoder_close(&encoder);
    free(b.data);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_network_ends_the_same),
        cmocka_unit_test(test_a_verified_network_ends_the_same),
        cmocka_unit_test(test_every_kind_of_network_ends_the_same),
        cmocka_unit_test(test_blocks_end_the_same),
        cmocka_unit_test(test_blocks_without_correspondences_end_the_same),
        cmocka_unit_test(test_an_abort_leaves_a_checkpoint),
        cmocka_unit_test(test_an_early_end_leaves_one_too),
        cmocka_unit_test(test_the_end_of_fitting_is_kept_in_any_case),
        cmocka_unit_test(test_damaged_checkpoints_are_refused),
        cmocka_unit_test(test_other_versions_are_refused),
        cmocka_unit_test(test_other_frames_are_refused),
        cmocka_unit_test(test_all_options_are_compared),
        cmocka_unit_test(test_other_options_are_refused_if_they_take_part_in_fitting),
        cmocka_unit_test(test_the_message_tells_both_values),
        cmocka_unit_test(test_states_that_do_not_fit_are_refused),
        cmocka_unit_test(test_calls_that_make_no_sense_are_refused),
    };
    return cmocka_run_group_tests(tests, make_checkpoint, free_checkpoint);
}
