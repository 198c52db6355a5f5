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

/* About the bits of a tensor's differences between values `apart` from each other, or of its values. */
static double tensor_bits(const nsdf_block_model *m, uint32_t tensor, size_t apart) {
    const nsdf_array_desc *a = &m->desc.list.tensors[tensor].arrays[0];
    const float *now = m->values + nsdf_block_offset(&m->desc, tensor);
    double bits = 0.0;
    for (size_t i = apart; i < (size_t)nsdf_array_size(a); i++) {
        const double r = ((double)now[i] - (apart > 0 ? (double)now[i - apart] : 0.0)) / (double)a->step;
        bits += 0.5 * log2(1.0 + r * r);
    }
    return bits;
}

/* What block_rate.h promises, in double. */
static double mean_bits(const nsdf_block_model *m) {
    return (tensor_bits(m, NSDF_BLOCK_POSES, m->pose_count / m->knots) + tensor_bits(m, NSDF_BLOCK_CENTRES, 3) +
            tensor_bits(m, NSDF_BLOCK_RADII, 1) + tensor_bits(m, NSDF_BLOCK_WEIGHTS, NSDF_BONE_INFLUENCES) +
            tensor_bits(m, NSDF_BLOCK_COEFFICIENTS + 1, 3) + tensor_bits(m, NSDF_BLOCK_COEFFICIENTS + 2, 0)) /
           (double)(m->pose_count + m->level_count + m->term_count + NSDF_BONE_INFLUENCES * m->desc.block_count);
}

static int has_rate(const nsdf_block_model *m, size_t i) {
    static const int tensors[] = {NSDF_BLOCK_WEIGHTS, NSDF_BLOCK_POSES, NSDF_BLOCK_COEFFICIENTS + 1,
                                  NSDF_BLOCK_COEFFICIENTS + 2};
    for (size_t k = 0; k < sizeof tensors / sizeof *tensors; k++)
        if (i >= nsdf_block_offset(&m->desc, (uint32_t)tensors[k]) &&
            i < nsdf_block_offset(&m->desc, (uint32_t)tensors[k] + 1))
            return 1;
    return 0;
}

static void test_the_rates_gradient_is_that_of_the_bits(void **state) {
    fixture x = two_balls(60, 3);
    nsdf_block_model model = make_model(&x);
    float *gradient = calloc(model.value_count, sizeof *gradient);
    const double weight = 0.25, h = 1e-5;
    (void)state;
    assert_non_null(gradient);
    for (size_t i = 0; i < model.term_count; i++)
        model.values[model.term_offset + i] = 4e-4f * (float)(i * 7919 % 31) - 5e-3f;
    nsdf_block_add_rate(&model, model.values, weight, gradient);
    for (size_t i = 0; i < model.value_count; i++) {
        if (!has_rate(&model, i))
            assert_true(gradient[i] == 0.0f);
        if (!has_rate(&model, i) || i % 7)
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
