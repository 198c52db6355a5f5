/* What makes block parts small: the order of the blocks, the rate of the motion, and how bytes are accounted for. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "block_order.h"
#include "block_rate.h"
#include "block_stage.h"
#include "motion_samples.h"

typedef struct {
    nsdf_frames frames;
    nsdf_workers *workers;
    nsdf_motion motion;
    nsdf_bones bones;
    double u[SAMPLE_FRAMES];
} fixture;

static fixture two_balls(uint32_t blocks, uint32_t bones) {
    fixture x;
    uint32_t second;
    nsdf_surface rest = sample_two_balls(&second);
    x.frames = sample_frames(&rest, SAMPLE_FRAMES, second, sample_rigid);
    x.workers = nsdf_workers_create(1);
    x.motion = sample_motion(&x.frames, blocks, x.workers);
    for (uint32_t f = 0; f < SAMPLE_FRAMES; f++)
        x.u[f] = (double)f / (SAMPLE_FRAMES - 1);
    assert_int_equal(nsdf_bones_fit(&x.bones, &x.motion, bones, x.workers), 0);
    return x;
}

static void free_fixture(fixture *x) {
    nsdf_bones_free(&x->bones);
    nsdf_motion_free(&x->motion);
    nsdf_workers_free(x->workers);
    sample_frames_free(&x->frames);
}

static nsdf_block_model make_model(const fixture *x) {
    const nsdf_block_steps steps = {2e-4, 2e-4};
    nsdf_block_model model;
    assert_int_equal(nsdf_block_model_create(&model, &x->motion, &x->bones, x->u, 2, 1.0, 0.0, &steps), 0);
    return model;
}

/* ---- Order ----------------------------------------------------------------------------------------------- */

static double weight_of(const nsdf_bones *bones, uint32_t block, uint32_t bone) {
    double sum = 0.0;
    for (int i = 0; i < NSDF_BONE_INFLUENCES; i++)
        sum += bones->bone[block][i] == bone ? bones->weight[block][i] : 0.0;
    return sum;
}

/* Every block is there once, with its normal, poses and bones. */
static void test_ordering_keeps_the_blocks(void **state) {
    fixture x = two_balls(120, 6), y = two_balls(120, 6);
    (void)state;
    assert_int_equal(nsdf_order_blocks(&y.motion, &y.bones), 0);
    const uint32_t count = x.motion.block_count;
    assert_int_equal(y.motion.block_count, count);
    uint32_t moved = 0;
    for (uint32_t k = 0; k < count; k++) {
        uint32_t at = 0;
        while (at < count && memcmp(y.motion.centres[at], x.motion.centres[k], sizeof *x.motion.centres) != 0)
            at++;
        assert_true(at < count);
        moved += at != k;
        assert_memory_equal(y.motion.normals[at], x.motion.normals[k], sizeof *x.motion.normals);
        assert_memory_equal(y.motion.lives[at], x.motion.lives[k], sizeof *x.motion.lives);
        for (uint32_t f = 0; f < SAMPLE_FRAMES; f++)
            assert_memory_equal(&y.motion.poses[f * count + at], &x.motion.poses[f * count + k], sizeof(nsdf_pose));
        for (uint32_t b = 0; b < x.bones.bone_count; b++)
            assert_true(weight_of(&y.bones, at, b) == weight_of(&x.bones, k, b));
    }
    assert_true(moved > count / 2);
    free_fixture(&x);
    free_fixture(&y);
}

static void test_ordering_saves_bytes(void **state) {
    fixture x = two_balls(200, 12);
    nsdf_block_bytes before, after;
    (void)state;
    nsdf_block_model plain = make_model(&x);
    assert_int_equal(nsdf_weigh_blocks(&plain, &before), 0);
    assert_int_equal(nsdf_order_blocks(&x.motion, &x.bones), 0);
    nsdf_block_model ordered = make_model(&x);
    assert_int_equal(nsdf_weigh_blocks(&ordered, &after), 0);
    assert_true(10 * after.places < 9 * before.places);
    assert_true(2 * after.influences < before.influences);
    nsdf_block_model_free(&plain);
    nsdf_block_model_free(&ordered);
    free_fixture(&x);
}

/* ---- Accounting ------------------------------------------------------------------------------------------ */

static void test_the_parts_make_up_the_whole(void **state) {
    fixture x = two_balls(200, 12);
    nsdf_block_bytes bytes;
    nsdf_coded_segment segment;
    (void)state;
    memset(&segment, 0, sizeof segment);
    nsdf_block_model model = make_model(&x);
    for (size_t i = 0; i < model.term_count; i++)
        model.values[model.term_offset + i] = 1e-3f * (float)(i * 7919 % 31);
    assert_int_equal(nsdf_weigh_blocks(&model, &bytes), 0);
    assert_int_equal(nsdf_code_blocks(&model, &segment), 0);
    const uint64_t sum = bytes.places + bytes.influences + bytes.motion + bytes.shapes;
    assert_true(bytes.places > 0 && bytes.influences > 0 && bytes.motion > 0 && bytes.shapes > 500);
    assert_true(sum < segment.payload.size && segment.payload.size < sum + 400); /* and the description */
    nsdf_buffer_free(&segment.payload);
    nsdf_block_model_free(&model);
    free_fixture(&x);
}

/* ---- Rate ------------------------------------------------------------------------------------------------ */

/* What block_rate.h promises, in double. */
static double mean_bits(const nsdf_block_model *m) {
    const size_t columns = m->pose_count / m->knots;
    const double step = (double)m->desc.list.tensors[NSDF_BLOCK_POSES].arrays[0].step;
    double bits = 0.0;
    for (size_t i = columns; i < m->pose_count; i++) {
        const double r =
            ((double)m->values[m->pose_offset + i] - (double)m->values[m->pose_offset + i - columns]) / step;
        bits += 0.5 * log2(1.0 + r * r);
    }
    return bits / (double)m->pose_count;
}

static void test_the_rates_gradient_is_that_of_the_bits(void **state) {
    fixture x = two_balls(60, 3);
    nsdf_block_model model = make_model(&x);
    float *gradient = calloc(model.value_count, sizeof *gradient);
    const double weight = 0.25, h = 1e-5;
    (void)state;
    assert_non_null(gradient);
    nsdf_block_add_rate(&model, model.values, weight, gradient);
    for (size_t i = 0; i < model.value_count; i++) {
        const int pose = i >= model.pose_offset && i < model.pose_offset + model.pose_count;
        if (!pose)
            assert_true(gradient[i] == 0.0f);
        if (!pose || i % 7)
            continue;
        const float value = model.values[i];
        model.values[i] = value + (float)h;
        const double high = mean_bits(&model), above = (double)model.values[i];
        model.values[i] = value - (float)h;
        const double slope = weight * (high - mean_bits(&model)) / (above - (double)model.values[i]);
        model.values[i] = value;
        assert_true(fabs((double)gradient[i] - slope) < 0.02 * fabs(slope) + 2e-3);
    }
    memset(gradient, 0, model.value_count * sizeof *gradient);
    nsdf_block_add_rate(&model, model.values, 0.0, gradient);
    for (size_t i = 0; i < model.value_count; i++)
        assert_true(gradient[i] == 0.0f);
    free(gradient);
    nsdf_block_model_free(&model);
    free_fixture(&x);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ordering_keeps_the_blocks),
        cmocka_unit_test(test_ordering_saves_bytes),
        cmocka_unit_test(test_the_parts_make_up_the_whole),
        cmocka_unit_test(test_the_rates_gradient_is_that_of_the_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
