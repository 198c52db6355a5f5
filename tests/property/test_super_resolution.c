/* Time is continuous: frames that were left out decode about as well as those that were fitted. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "unit/encode_samples.h"

enum { NOMINAL = 13, POINTS = 4000 };
static const double radius = 1.0;

/* Where the sphere is at nominal frame i: once along a bow. */
static void centre_at(uint32_t i, double centre[3]) {
    const double s = (double)i / (NOMINAL - 1);
    centre[0] = 2.4 * s;
    centre[1] = 0.6 * sin(3.141592653589793 * s);
    centre[2] = 0.3 * s * s;
}

static int every_second_frame(uint32_t i, nsdf_surface *surface, uint32_t *number) {
    double centre[3];
    *number = 2 * i;
    if (*number >= NOMINAL)
        return 0;
    centre_at(*number, centre);
    *surface = shape_sphere(radius, 20, 40);
    for (size_t k = 0; k < 3 * (size_t)surface->vertex_count; k++)
        surface->positions[k] += (float)centre[k % 3];
    return 1;
}

/* Mean |f| on the true sphere at nominal frame i, as a fraction of the diagonal. */
static double error_at(nsdf_decoder *decoder, uint32_t i, double diagonal) {
    static float xyz[3 * POINTS], value[POINTS];
    nsdf_random random = nsdf_random_start(21, i);
    double centre[3], t, sum = 0.0;
    centre_at(i, centre);
    for (size_t k = 0; k < POINTS; k++) {
        double p[3], length = 0.0;
        for (int a = 0; a < 3; a++) {
            p[a] = (double)nsdf_random_normal(&random);
            length += p[a] * p[a];
        }
        for (size_t a = 0; a < 3; a++)
            xyz[3 * k + a] = (float)(centre[a] + radius * p[a] / sqrt(length));
    }
    assert_int_equal(nsdf_frame_time(decoder, i, &t), NSDF_OK);
    assert_int_equal(nsdf_evaluate(decoder, t, xyz, POINTS, value, NULL), NSDF_OK);
    for (size_t k = 0; k < POINTS; k++)
        sum += (double)fabsf(value[k]);
    return sum / POINTS / diagonal;
}

static void check_model(nsdf_tensor_time weight_time) {
    nsdf_encoder_options o = sample_options(2, 24);
    o.weight_time = weight_time;
    o.rank = 4;
    o.omega_first = 10.0;
    o.learning_rate = 5e-3;
    o.steps = 1500;
    o.samples_per_frame = 20000;
    o.batch_frames = 7;
    o.batch_points = 512;
    o.verify = 0;
    encoded e = encode_well(&o, every_second_frame, skip_repair, NULL);
    nsdf_decoder *decoder = open_file(&e);
    double seen = 0.0, unseen = 0.0;
    for (uint32_t i = 0; i < NOMINAL; i++)
        *(i % 2 ? &unseen : &seen) += error_at(decoder, i, e.stats.diagonal);
    seen /= 7.0;
    unseen /= 6.0;
    print_message("mean error at fitted frames %.2e, between them %.2e\n", seen, unseen);
    assert_true(seen < 0.002);
    assert_true(unseen <= 1.3 * seen);
    nsdf_close(&decoder);
    free(e.data);
}

static void test_frames_left_out_are_as_good_with_spline_weights(void **state) {
    (void)state;
    check_model(NSDF_TIME_SPLINE);
}

static void test_frames_left_out_are_as_good_with_low_rank_weights(void **state) {
    (void)state;
    check_model(NSDF_TIME_LOW_RANK);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_frames_left_out_are_as_good_with_spline_weights),
        cmocka_unit_test(test_frames_left_out_are_as_good_with_low_rank_weights),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
