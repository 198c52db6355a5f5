/* Blocks through the encoder's public interface: when they are used, and how well a moving sphere decodes. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "encode_samples.h"

enum { FRAMES = 5, RINGS = 24, SEGMENTS = 48 };

static nsdf_surface sphere_at(uint32_t frame, uint32_t rings) {
    nsdf_surface s = shape_sphere(1.0, rings, SEGMENTS);
    const float t = (float)frame / (FRAMES - 1);
    for (uint32_t v = 0; v < s.vertex_count; v++) { /* along a bow, while it turns and stretches */
        float *p = s.positions + 3 * (size_t)v, x = p[0], y = p[1];
        p[0] = cosf(t) * x - sinf(t) * y + 0.8f * t;
        p[1] = (sinf(t) * x + cosf(t) * y) * (1.0f + 0.2f * t) + 0.5f * t * t;
    }
    return s;
}

static int moving_sphere(uint32_t i, nsdf_surface *surface, uint32_t *number) {
    if (i >= FRAMES)
        return 0;
    *surface = sphere_at(i, RINGS);
    *number = i;
    return 1;
}

static int resting_sphere(uint32_t i, nsdf_surface *surface, uint32_t *number) {
    return i == 0 && moving_sphere(i, surface, number);
}

static int remeshed_sphere(uint32_t i, nsdf_surface *surface, uint32_t *number) {
    if (i >= FRAMES)
        return 0;
    *surface = sphere_at(i, i == 3 ? RINGS + 1 : RINGS);
    *number = i;
    return 1;
}

static nsdf_encoder_options block_options(void) {
    nsdf_encoder_options o = hasty_options();
    o.blocks = 150;
    o.bones = 3;
    o.block_steps = 150;
    o.block_points = 1000;
    o.samples_per_frame = 4000;
    return o;
}

/* The greatest |f| at corners and middles of the input's triangles, as a fraction of the diagonal. */
static double worst_at(nsdf_decoder *decoder, uint32_t frame, double diagonal) {
    nsdf_surface s = sphere_at(frame, RINGS);
    double t, worst = 0.0;
    assert_int_equal(nsdf_frame_time(decoder, frame, &t), NSDF_OK);
    for (uint32_t i = 0; i < s.triangle_count; i++) {
        const nsdf_vec3 a = shape_corner(&s, i, 0), b = shape_corner(&s, i, 1), c = shape_corner(&s, i, 2);
        const float xyz[6] = {(float)a.x,
                              (float)a.y,
                              (float)a.z,
                              (float)((a.x + b.x + c.x) / 3.0),
                              (float)((a.y + b.y + c.y) / 3.0),
                              (float)((a.z + b.z + c.z) / 3.0)};
        float value[2];
        assert_int_equal(nsdf_evaluate(decoder, t, xyz, 2, value, NULL), NSDF_OK);
        worst = fmax(worst, (double)fmaxf(fabsf(value[0]), fabsf(value[1])) / diagonal);
    }
    nsdf_surface_free(&s);
    return worst;
}

static void test_a_moving_sphere_decodes_well(void **state) {
    const nsdf_encoder_options o = block_options();
    encoded e = encode_well(&o, moving_sphere, NULL, NULL);
    nsdf_decoder *decoder = open_file(&e);
    (void)state;
    assert_true(e.stats.blocks == 150 && e.stats.bones >= 1 && e.stats.bones <= 3 && e.stats.steps == 150);
    for (uint32_t frame = 0; frame < FRAMES; frame++)
        assert_true(worst_at(decoder, frame, e.stats.diagonal) < 2e-3);
    nsdf_close(&decoder);
    free(e.data);
}

static void test_one_frame_gets_blocks_that_rest(void **state) {
    nsdf_encoder_options o = block_options();
    o.block_steps = 20;
    encoded e = encode_well(&o, resting_sphere, NULL, NULL);
    nsdf_decoder *decoder = open_file(&e);
    (void)state;
    assert_int_equal(e.stats.blocks, 150);
    assert_true(worst_at(decoder, 0, e.stats.diagonal) < 3e-3);
    nsdf_close(&decoder);
    free(e.data);
}

static void test_files_depend_on_the_seed_and_not_on_threads(void **state) {
    nsdf_encoder_options o = block_options();
    (void)state;
    o.block_steps = 20;
    encoded one = encode_well(&o, moving_sphere, NULL, NULL);
    o.threads = 3;
    encoded three = encode_well(&o, moving_sphere, NULL, NULL);
    o.seed = 7;
    encoded other = encode_well(&o, moving_sphere, NULL, NULL);
    assert_int_equal(one.size, three.size);
    assert_memory_equal(one.data, three.data, one.size);
    assert_true(other.size != one.size || memcmp(other.data, one.data, one.size) != 0);
    free(one.data);
    free(three.data);
    free(other.data);
}

static void test_the_network_stands_in_without_blocks(void **state) {
    nsdf_encoder_options o = block_options();
    (void)state;
    o.blocks = 0;
    encoded e = encode_well(&o, moving_sphere, skip_repair, NULL);
    nsdf_decoder *decoder = open_file(&e);
    assert_true(e.stats.blocks == 0 && e.stats.bones == 0 && e.stats.steps == o.steps);
    assert_true(e.stats.parameters > 8 * 8);
    assert_int_equal(nsdf_verify(decoder), NSDF_OK);
    nsdf_close(&decoder);
    free(e.data);
}

/* Frames whose triangles have nothing to do with each other. */
static void test_blocks_need_no_correspondences(void **state) {
    const nsdf_encoder_options o = block_options();
    (void)state;
    encoded e = encode_well(&o, remeshed_sphere, NULL, NULL);
    nsdf_decoder *decoder = open_file(&e);
    assert_true(e.stats.blocks >= o.blocks);
    assert_true(e.stats.quality.mean_to_decoded < 3e-3 && e.stats.quality.mean_to_input < 3e-3);
    assert_int_equal(nsdf_verify(decoder), NSDF_OK);
    nsdf_close(&decoder);
    free(e.data);
}

static int stop_fitting(void *user, const nsdf_progress *progress) {
    return progress->stage == NSDF_STAGE_FIT ? *(const int *)user : NSDF_CONTINUE;
}

/* Grows to fifty times its size: balls cannot. */
static int exploding_sphere(uint32_t i, nsdf_surface *surface, uint32_t *number) {
    if (i >= FRAMES)
        return 0;
    *surface = shape_sphere(0.02 + 0.98 * i / (FRAMES - 1), RINGS, SEGMENTS);
    *number = i;
    return 1;
}

static void test_what_blocks_cannot_follow_gets_a_network(void **state) {
    const nsdf_encoder_options o = block_options();
    nsdf_encoder_error error;
    nsdf_encoder_stats stats;
    (void)state;
    for (int grows = 0; grows < 2; grows++) {
        nsdf_encoder *encoder = NULL;
        assert_int_equal(nsdf_encoder_create(&encoder, &o, &error), NSDF_OK);
        assert_int_equal(add_frames(encoder, grows ? exploding_sphere : moving_sphere, &error), NSDF_OK);
        assert_int_equal(nsdf_encoder_run(encoder, NULL, NULL, &error), NSDF_OK);
        assert_int_equal(nsdf_encoder_get_stats(encoder, &stats), NSDF_OK);
        assert_int_equal(stats.unfollowed, grows);
        assert_int_equal(stats.blocks > 0, !grows);
        nsdf_encoder_close(&encoder);
    }
}

/* A small sphere that flies far. */
static int flying_sphere(uint32_t i, nsdf_surface *surface, uint32_t *number) {
    if (i >= FRAMES)
        return 0;
    *surface = shape_sphere(0.3, RINGS, SEGMENTS);
    for (uint32_t v = 0; v < surface->vertex_count; v++)
        surface->positions[3 * (size_t)v] += 1.1f * (float)i;
    *number = i;
    return 1;
}

/* Motion so coarse that blocks lose the surface; against a network of that many steps. */
static encoded encode_coarse_blocks(frame_maker frames, uint32_t network_steps) {
    nsdf_encoder_options o = block_options();
    o.block_steps = 20;
    o.pose_step = 0.1;
    o.verify = 1;
    o.steps = network_steps;
    return encode_well(&o, frames, NULL, NULL);
}

static void test_blocks_that_come_apart_give_way_to_a_better_network(void **state) {
    (void)state;
    encoded e = encode_coarse_blocks(flying_sphere, 3000);
    nsdf_decoder *decoder = open_file(&e);
    assert_true(e.stats.came_apart && !e.stats.unfollowed);
    assert_true(e.stats.blocks == 0 && e.stats.steps >= 3000);
    assert_true(nsdf_mean_error(&e.stats.quality) < 0.02);
    assert_int_equal(nsdf_verify(decoder), NSDF_OK);
    nsdf_close(&decoder);
    free(e.data);
}

static void test_but_not_to_a_worse_one(void **state) {
    (void)state;
    encoded e = encode_coarse_blocks(moving_sphere, 1);
    nsdf_decoder *decoder = open_file(&e);
    assert_true(!e.stats.came_apart && e.stats.blocks == 150 && e.stats.steps == 20);
    assert_true(nsdf_mean_error(&e.stats.quality) > 0.02 && e.stats.file_size == e.size);
    assert_int_equal(nsdf_verify(decoder), NSDF_OK);
    nsdf_close(&decoder);
    free(e.data);
}

static void test_fitting_of_blocks_can_be_stopped(void **state) {
    nsdf_encoder_options o = block_options();
    int finish = NSDF_FINISH, abort_it = NSDF_ABORT;
    (void)state;
    o.block_steps = 1000000;
    encoded e = encode_well(&o, moving_sphere, stop_fitting, &finish);
    nsdf_decoder *decoder = open_file(&e);
    assert_true(e.stats.blocks == 150 && e.stats.steps < 1000000);
    assert_int_equal(nsdf_verify(decoder), NSDF_OK);
    nsdf_close(&decoder);
    free(e.data);
    e = encode(&o, moving_sphere, stop_fitting, &abort_it);
    assert_int_equal(e.status, NSDF_CANCELLED);
    free(e.data);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_moving_sphere_decodes_well),
        cmocka_unit_test(test_one_frame_gets_blocks_that_rest),
        cmocka_unit_test(test_files_depend_on_the_seed_and_not_on_threads),
        cmocka_unit_test(test_the_network_stands_in_without_blocks),
        cmocka_unit_test(test_blocks_need_no_correspondences),
        cmocka_unit_test(test_what_blocks_cannot_follow_gets_a_network),
        cmocka_unit_test(test_blocks_that_come_apart_give_way_to_a_better_network),
        cmocka_unit_test(test_but_not_to_a_worse_one),
        cmocka_unit_test(test_fitting_of_blocks_can_be_stopped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
