/* Poses of blocks against their definition in double precision, and the bound on how far a block has moved. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "block_fixture.h"
#include "block_pose.h"
#include "row4.h"

static const double at_time = 0.3;

/* Two balls, each block on four bones, the last of which may weigh nothing. */
static fixture blended_balls(void) {
    static const float shares[2][4] = {{0.5f, 0.25f, 0.25f, 0.0f}, {0.125f, 0.5f, 0.25f, 0.125f}};
    fixture x = two_balls(40, 4, 1);
    spread_weights(&x, shares, 2);
    nsdf_block_frame_pose(&x.frame, &x.model, x.model.values, at_time);
    return x;
}

static void test_rows(void **state) {
    nsdf_row4 m[4] = {
        {1.0f, 2.0f, 3.0f, 4.0f}, {5.0f, 6.0f, 7.0f, 8.0f}, {9.0f, 10.0f, 11.0f, 12.0f}, {13.0f, 14.0f, 15.0f, 16.0f}};
    const nsdf_row4 sums = nsdf_row4_sums(m[0], m[1], m[2], m[3]);
    const nsdf_row4 x = {2.0f, 0.0f, 0.0f, 0.0f}, y = {0.0f, 3.0f, 0.0f, 0.0f}, z = nsdf_row4_cross(x, y);
    const nsdf_row4 mixed = nsdf_row4_cross(m[0], m[2]);
    (void)state;
    nsdf_row4_transpose(m);
    for (int i = 0; i < 4; i++) {
        assert_true(sums[i] == (float)(10 + 16 * i));
        for (int j = 0; j < 4; j++)
            assert_true(m[i][j] == (float)(1 + i + 4 * j));
    }
    assert_true(z[0] == 0.0f && z[1] == 0.0f && z[2] == 6.0f && z[3] == 0.0f);
    assert_true(mixed[0] == -8.0f && mixed[1] == 16.0f && mixed[2] == -8.0f);
}

/* Sum over the bones of w (B / e, B (c - a) / e + b), from the values as the file has them. */
static void pose_by_definition(const fixture *x, size_t block, double pose[12]) {
    const nsdf_block_model *m = &x->model;
    const float *weight = values_of(m, NSDF_BLOCK_WEIGHTS) + NSDF_BONE_INFLUENCES * block;
    const float *centre = values_of(m, NSDF_BLOCK_CENTRES) + 3 * block;
    memset(pose, 0, 12 * sizeof *pose);
    for (size_t i = 0; i < NSDF_BONE_INFLUENCES; i++) {
        const size_t bone = m->influences[NSDF_BONE_INFLUENCES * block + i].bone;
        const float *anchor = values_of(m, NSDF_BLOCK_ANCHORS) + 4 * bone, *b = x->frame.bones + 12 * bone;
        const double w = (double)weight[i], extent = (double)anchor[3];
        for (int row = 0; row < 3; row++) {
            pose[4 * row + 3] += w * (double)b[4 * row + 3];
            for (int k = 0; k < 3; k++) {
                const double entry = w * (double)b[4 * row + k] / extent;
                pose[4 * row + k] += entry;
                pose[4 * row + 3] += entry * (double)(centre[k] - anchor[k]);
            }
        }
    }
}

/* The map takes the centre to 0 and the points one radius from it, along the pose's columns, to the unit vectors. */
static void check_map(const float map[12], const double pose[12], double radius) {
    for (int k = 0; k < 4; k++)
        for (int row = 0; row < 3; row++) {
            double u = (double)map[4 * row + 3];
            for (int axis = 0; axis < 3; axis++)
                u += (double)map[4 * row + axis] * (pose[4 * axis + 3] + (k < 3 ? radius * pose[4 * axis + k] : 0.0));
            assert_true(fabs(u - (k == row ? 1.0 : 0.0)) < 2e-5);
        }
}

static void test_poses_are_those_of_the_definition(void **state) {
    fixture x = blended_balls();
    const float *radii = values_of(&x.model, NSDF_BLOCK_RADII);
    (void)state;
    for (size_t block = 0; block < x.model.desc.block_count; block++) {
        double pose[12];
        pose_by_definition(&x, block, pose);
        for (int i = 0; i < 12; i++)
            assert_true(fabs((double)x.frame.pose[block][i] - pose[i]) < 2e-6);
        check_map(x.frame.map[block], pose, (double)radii[block]);
        for (int axis = 0; axis < 3; axis++) {
            const double *row = pose + 4 * axis;
            const double half = (double)radii[block] * sqrt(row[0] * row[0] + row[1] * row[1] + row[2] * row[2]);
            assert_true(fabs((double)x.frame.reach[block][axis] - (row[3] - half)) < 2e-6);
            assert_true(fabs((double)x.frame.reach[block][3 + axis] - (row[3] + half)) < 2e-6);
        }
    }
    free_fixture(&x);
}

/* Points of the ball now, in the coordinates of the ball as it was. */
static void test_moved_bounds_where_points_lie(void **state) {
    enum { BLOCKS = 40 };
    fixture x = blended_balls();
    float before[BLOCKS][12];
    const float *radii = values_of(&x.model, NSDF_BLOCK_RADII);
    nsdf_random random = nsdf_random_start(7, 1);
    float tightest = 10.0f;
    (void)state;
    assert_true(x.model.desc.block_count <= BLOCKS);
    memcpy(before, x.frame.map, sizeof *before * x.model.desc.block_count);
    for (size_t k = 0; k < x.model.desc.block_count; k++)
        assert_true(nsdf_block_moved(before[k], x.frame.pose[k], radii[k]) < 1e-4f);
    nsdf_block_frame_pose(&x.frame, &x.model, x.model.values, at_time + 0.05);
    for (size_t k = 0; k < x.model.desc.block_count; k++) {
        const float bound = nsdf_block_moved(before[k], x.frame.pose[k], radii[k]);
        for (int n = 0; n < 200; n++) {
            float u[3], p[3], then = 0.0f;
            random_point(&random, 1.0f, u);
            const float length = sqrtf(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
            for (int axis = 0; axis < 3; axis++) {
                const float *row = x.frame.pose[k] + 4 * axis;
                p[axis] = row[3] + radii[k] / length * (row[0] * u[0] + row[1] * u[1] + row[2] * u[2]);
            }
            for (int axis = 0; axis < 3; axis++) {
                const float *row = before[k] + 4 * axis;
                const float at = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
                then += at * at;
            }
            assert_true(sqrtf(then) < 1.0f + bound + 1e-4f);
            tightest = fminf(tightest, 1.0f + bound - sqrtf(then));
        }
        assert_true(bound > 1e-3f);
    }
    assert_true(tightest < 0.1f); /* and not by far */
    free_fixture(&x);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rows),
        cmocka_unit_test(test_poses_are_those_of_the_definition),
        cmocka_unit_test(test_moved_bounds_where_points_lie),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
