/* Blocks without surface: lives that end, and samples where pieces are astray. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "block_fixture.h"
#include "block_lives.h"
#include "block_mend.h"

/* ---- Lives ------------------------------------------------------------------------------------------------ */

static int trim(fixture *x) {
    nsdf_file_header header = unit_header(SAMPLE_FRAMES);
    for (int axis = 0; axis < 3; axis++) {
        header.domain_min[axis] = low[axis];
        header.domain_max[axis] = high[axis];
    }
    return nsdf_block_trim_lives(&x->model, &x->frames, x->u, &header, x->workers);
}

static uint32_t count_alive(const fixture *x, uint32_t frame) {
    uint32_t alive = 0;
    for (uint32_t k = 0; k < x->model.desc.block_count; k++)
        alive += (uint32_t)nsdf_block_alive(&x->model, k, x->u[frame]);
    return alive;
}

/* The second ball's triangles are the second half. */
static void drop_second_ball(fixture *x, uint32_t frame) {
    x->frames.frames[frame].surface.triangle_count /= 2;
}

static void test_lives_with_surface_stay(void **state) {
    fixture x = two_balls(300, 4, 1);
    (void)state;
    assert_int_equal(trim(&x), 0);
    for (uint32_t f = 0; f < SAMPLE_FRAMES; f++)
        assert_int_equal(count_alive(&x, f), x.model.desc.block_count);
    free_fixture(&x);
}

/* Those of blocks that are next to the first ball go on. */
static void test_lives_end_with_their_surface(void **state) {
    fixture x = two_balls(300, 4, 1);
    const uint32_t all = x.model.desc.block_count;
    (void)state;
    drop_second_ball(&x, 3);
    drop_second_ball(&x, 4);
    assert_int_equal(trim(&x), 0);
    for (uint32_t f = 0; f < 3; f++)
        assert_int_equal(count_alive(&x, f), all);
    for (uint32_t f = 3; f < SAMPLE_FRAMES; f++)
        assert_in_range(count_alive(&x, f), 9 * all / 20, 13 * all / 20);
    free_fixture(&x);
}

static void test_lives_begin_with_their_surface_and_span_gaps(void **state) {
    fixture x = two_balls(300, 4, 1);
    const uint32_t all = x.model.desc.block_count;
    (void)state;
    drop_second_ball(&x, 0);
    drop_second_ball(&x, 1);
    drop_second_ball(&x, 3);
    assert_int_equal(trim(&x), 0);
    for (uint32_t f = 0; f < 2; f++)
        assert_in_range(count_alive(&x, f), 9 * all / 20, 13 * all / 20);
    for (uint32_t f = 2; f < SAMPLE_FRAMES; f++)
        assert_int_equal(count_alive(&x, f), all);
    free_fixture(&x);
}

/* As readers have it (spec, "Life"); 0 where the block is not there. */
static double life_at(const nsdf_block_model *m, uint32_t block, double u) {
    const float *life = m->values + nsdf_block_offset(&m->desc, NSDF_BLOCK_LIVES) + 2 * (size_t)block;
    const double from = (double)life[0], to = (double)life[1], fade = (double)m->desc.fade;
    const double in = from <= 0.0 ? 1.0 : (u - from) / fade, out = to >= 1.0 ? 1.0 : (to - u) / fade;
    return fmax(0.0, fmin(1.0, fmin(in, out)));
}

/* Whole in its frames and nothing at all in the others, with the file's rounding and with times a little off. */
static void test_readers_see_nothing_of_a_block_beyond_its_frames(void **state) {
    static const double off[] = {0.0, 1e-7, -1e-7};
    fixture x = two_balls(300, 4, 1);
    float *life = x.model.values + nsdf_block_offset(&x.model.desc, NSDF_BLOCK_LIVES);
    (void)state;
    for (uint32_t first = 0; first < SAMPLE_FRAMES; first++)
        for (uint32_t last = first; last < SAMPLE_FRAMES; last++) {
            nsdf_block_life(x.u, SAMPLE_FRAMES, first, last, life);
            nsdf_block_model_round_lives(&x.model);
            for (uint32_t f = 0; f < SAMPLE_FRAMES; f++)
                for (int i = 0; i < 3; i++) {
                    const double u = fmax(0.0, fmin(1.0, x.u[f] + off[i])), expected = f >= first && f <= last;
                    assert_true(fabs(life_at(&x.model, 0, u) - expected) < (expected > 0.0 ? 1e-5 : 1e-300));
                    assert_int_equal(nsdf_block_alive(&x.model, 0, u), expected > 0.0);
                }
        }
    free_fixture(&x);
}

/* ---- Samples ---------------------------------------------------------------------------------------------- */

/* Points on a small ball between the two balls' frame and its border. */
static nsdf_sample_set astray(const nsdf_sdf *sdf, size_t count) {
    float *xyz = random_floats(3 * (uint32_t)count, 0.02f, 5);
    nsdf_sample_set s;
    assert_int_equal(nsdf_sample_set_create(&s, count), 0);
    for (size_t i = 0; i < count; i++) {
        const float p[3] = {xyz[3 * i], xyz[3 * i + 1] + 0.4f, xyz[3 * i + 2]};
        s.x[i] = p[0];
        s.y[i] = p[1];
        s.z[i] = p[2];
        s.d[i] = nsdf_sdf_distance(sdf, p);
    }
    free(xyz);
    return s;
}

/* One in `stride` is new, around the stray points, and has the distances of the frame. */
static void check_mended(const nsdf_sample_set *before, const nsdf_sample_set *after, size_t stride,
                         const nsdf_sdf *sdf) {
    size_t changed = 0;
    assert_int_equal(before->count, after->count);
    for (size_t i = 0; i < after->count; i++) {
        const float p[3] = {after->x[i], after->y[i], after->z[i]};
        assert_true(fabsf(after->d[i] - nsdf_sdf_distance(sdf, p)) < 1e-5f);
        if (after->x[i] == before->x[i] && after->y[i] == before->y[i])
            continue;
        changed++;
        assert_true(after->d[i] > 0.0f && fabsf(p[1] - 0.4f) < 0.3f);
    }
    assert_int_equal(changed, (before->count + stride - 1) / stride);
}

static void mend_with_strays(size_t count, size_t stride) {
    fixture x = two_balls(40, 4, 1);
    fit_fixture f;
    nsdf_sample_set strays[SAMPLE_FRAMES] = {{0}}, sets[SAMPLE_FRAMES];
    make_fit(&f, &x, 10);
    nsdf_sdf *sdf = nsdf_frame_sdf(&x.frames.frames[1]);
    strays[1] = astray(sdf, count);
    assert_int_equal(nsdf_mend_samples(&f.job, strays, sets), 0);
    for (int i = 0; i < SAMPLE_FRAMES; i++)
        assert_true(i == 1 || sets[i].x == f.sets[i].x);
    check_mended(&f.sets[1], &sets[1], stride, sdf);
    nsdf_mended_samples_free(&f.job, sets);
    assert_true(f.sets[0].x != NULL && f.sets[1].x != NULL);
    nsdf_sample_set_free(&strays[1]);
    nsdf_sdf_free(sdf);
    free_fit(&f);
    free_fixture(&x);
}

/* Of 4,000 samples twice as many as there are strays, an eighth at most. */
static void test_strays_join_the_samples_of_their_frame(void **state) {
    (void)state;
    mend_with_strays(1, 2000);
    mend_with_strays(50, 40);
    mend_with_strays(300, 8);
}

/* The same steps give other values with strays. */
static void test_strays_change_a_fit(void **state) {
    fixture x = two_balls(40, 4, 2);
    fit_fixture f;
    nsdf_fit_result result;
    nsdf_sample_set strays[SAMPLE_FRAMES] = {{0}};
    const nsdf_fit_control control = {1, NULL, NULL};
    (void)state;
    start(&x);
    make_fit(&f, &x, 40);
    f.job.control = &control;
    float *given = malloc(x.model.value_count * sizeof *given);
    memcpy(given, x.model.values, x.model.value_count * sizeof *given);
    assert_int_equal(nsdf_fit_mended(&f.job, strays, &x.model, &result), 0);
    float *without = malloc(x.model.value_count * sizeof *without);
    memcpy(without, x.model.values, x.model.value_count * sizeof *without);
    memcpy(x.model.values, given, x.model.value_count * sizeof *given);
    nsdf_sdf *sdf = nsdf_frame_sdf(&x.frames.frames[2]);
    strays[2] = astray(sdf, 50);
    assert_int_equal(nsdf_fit_mended(&f.job, strays, &x.model, &result), 0);
    assert_int_equal(result.steps, 40);
    assert_true(memcmp(without, x.model.values, x.model.value_count * sizeof *without) != 0);
    nsdf_sample_set_free(&strays[2]);
    nsdf_sdf_free(sdf);
    free(without);
    free(given);
    free_fit(&f);
    free_fixture(&x);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lives_with_surface_stay),
        cmocka_unit_test(test_lives_end_with_their_surface),
        cmocka_unit_test(test_readers_see_nothing_of_a_block_beyond_its_frames),
        cmocka_unit_test(test_lives_begin_with_their_surface_and_span_gaps),
        cmocka_unit_test(test_strays_join_the_samples_of_their_frame),
        cmocka_unit_test(test_strays_change_a_fit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
