/* How many control points motion takes: a rod that swings slowly, and one that jumps to and fro. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "block_knots.h"
#include "motion_samples.h"

/* A rod that swings, and is moved sideways by `jump` in every other frame. */
static double spacing_for(double jump, double given) {
    nsdf_motion motion = sample_bending_rod();
    nsdf_bones bones;
    double u[64];
    nsdf_workers *workers = nsdf_workers_create(1);
    for (uint32_t f = 0; f < motion.frame_count; f++) {
        u[f] = (double)f / (motion.frame_count - 1);
        for (uint32_t k = 0; k < motion.block_count; k++) {
            nsdf_pose *pose = &motion.poses[(size_t)f * motion.block_count + k];
            *pose = (nsdf_pose){{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
            for (int axis = 0; axis < 3; axis++)
                pose->position[axis] = (double)motion.centres[k][axis];
            pose->position[1] += 0.05 * sin(2.0 * u[f]) + (f % 2 ? jump : 0.0);
        }
    }
    assert_int_equal(nsdf_bones_fit(&bones, &motion, 4, workers), 0);
    const double spacing = nsdf_block_knot_spacing(&motion, &bones, u, given);
    nsdf_bones_free(&bones);
    nsdf_workers_free(workers);
    nsdf_motion_free(&motion);
    return spacing;
}

static void test_jumps_take_a_control_point_a_frame(void **state) {
    (void)state;
    assert_true(spacing_for(0.2, 2.0) <= 1.0);
    assert_true(spacing_for(0.2, 4.0) <= 1.0);
}

static void test_what_is_slow_keeps_the_spacing_given(void **state) {
    (void)state;
    assert_true(spacing_for(0.0, 2.0) >= 2.0);
}

/* One that is finer already is what was asked for. */
static void test_fine_spacings_are_left_alone(void **state) {
    (void)state;
    assert_true(spacing_for(0.2, 1.0) >= 1.0 && spacing_for(0.2, 0.5) < 0.6);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_jumps_take_a_control_point_a_frame),
        cmocka_unit_test(test_what_is_slow_keeps_the_spacing_given),
        cmocka_unit_test(test_fine_spacings_are_left_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
