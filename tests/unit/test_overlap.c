/* Parts that pass through each other: spheres in one mesh, against the union of the two balls. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "frames.h"
#include "geometry_shapes.h"

/* Flat triangles between points on a sphere: how far they can be inside of it, and how long their edges are. */
enum { RINGS = 32, SEGMENTS = 64 };
static const double radius = 0.2, sagitta = 0.0025, edge = 0.02;

/* A mesh of one or two spheres of the same radius, with their centres at -apart / 2 and apart / 2 on the x axis. */
static nsdf_frame make_spheres(int count, double apart) {
    static const nsdf_repair_rule rule = {NSDF_SHEETS_NONE, 0.0};
    nsdf_frame frame;
    memset(&frame, 0, sizeof frame);
    frame.surface = shape_empty();
    for (int i = 0; i < count; i++) {
        const uint32_t first = frame.surface.vertex_count;
        shape_add_sphere(&frame.surface, radius, RINGS, SEGMENTS, 0, 0);
        for (uint32_t v = first; v < frame.surface.vertex_count; v++)
            frame.surface.positions[3 * (size_t)v] += (float)(i ? 0.5 * apart : -0.5 * apart);
    }
    assert_int_equal(nsdf_frame_repair(&frame, &rule), 0);
    assert_int_equal(nsdf_frame_find_outer(&frame), 0);
    return frame;
}

static void free_frame(nsdf_frame *frame) {
    nsdf_surface_free(&frame->surface);
    free(frame->outer.indices);
}

/* Distance to the nearer sphere: the union's signed distance outside of it. */
static double two_spheres(const float p[3], double apart) {
    const double yz = (double)p[1] * (double)p[1] + (double)p[2] * (double)p[2];
    const double a = sqrt(((double)p[0] + 0.5 * apart) * ((double)p[0] + 0.5 * apart) + yz);
    const double b = sqrt(((double)p[0] - 0.5 * apart) * ((double)p[0] - 0.5 * apart) + yz);
    return fmin(a, b) - radius;
}

static void middle_of(const nsdf_surface *s, uint32_t triangle, float p[3]) {
    for (size_t k = 0; k < 3; k++) {
        p[k] = 0.0f;
        for (size_t c = 0; c < 3; c++)
            p[k] += s->positions[3 * (size_t)s->indices[3 * (size_t)triangle + c] + k] / 3.0f;
    }
}

/* ---- What is left out ----------------------------------------------------------------------------------- */

static int has_triangle(const nsdf_surface *s, const uint32_t corners[3]) {
    for (size_t i = 0; i < s->triangle_count; i++)
        if (memcmp(s->indices + 3 * i, corners, 3 * sizeof *corners) == 0)
            return 1;
    return 0;
}

static void test_triangles_inside_of_the_other_sphere_are_left_out(void **state) {
    const double apart = 0.24;
    nsdf_frame frame = make_spheres(2, apart);
    const nsdf_surface *outer = nsdf_frame_outer(&frame);
    uint32_t hidden = 0, kept = 0;
    (void)state;
    assert_ptr_equal(outer, &frame.outer);
    assert_ptr_equal(outer->positions, frame.surface.positions);
    for (uint32_t i = 0; i < frame.surface.triangle_count; i++) {
        float p[3];
        middle_of(&frame.surface, i, p);
        /* negative inside of the other sphere; within a tessellation's error of it both answers are right */
        const float mirrored[3] = {p[0] < 0.0f ? p[0] : -p[0], p[1], p[2]};
        const int first = i < frame.surface.triangle_count / 2, on_far_side = (p[0] < 0.0f) == first;
        const double inside = on_far_side ? 1.0 : two_spheres(mirrored, apart);
        if (fabs(inside) < 2.0 * sagitta)
            continue;
        const int found = has_triangle(outer, frame.surface.indices + 3 * (size_t)i);
        assert_int_equal(found, inside > 0.0);
        hidden += (uint32_t)!found;
        kept += (uint32_t)found;
    }
    assert_true(hidden > 500 && kept > 4000); /* a cap of (1 - 0.12 / 0.2) / 2 = 1/5 of each sphere is hidden */
    free_frame(&frame);
}

static void test_a_single_sphere_hides_nothing(void **state) {
    nsdf_frame frame = make_spheres(1, 0.0);
    (void)state;
    assert_int_equal(frame.outer.triangle_count, 0);
    assert_null(frame.outer.indices);
    assert_ptr_equal(nsdf_frame_outer(&frame), &frame.surface);
    free_frame(&frame);
}

/* Two poles that share a place, and spheres a little apart. */
static void test_spheres_beside_each_other_hide_nothing(void **state) {
    static const double gaps[] = {0.0, 1e-3, 0.05};
    (void)state;
    for (size_t i = 0; i < sizeof gaps / sizeof *gaps; i++) {
        nsdf_frame frame = make_spheres(2, 2.0 * radius + gaps[i]);
        assert_int_equal(frame.outer.triangle_count, 0);
        assert_ptr_equal(nsdf_frame_outer(&frame), &frame.surface);
        free_frame(&frame);
    }
}

/* ---- The signed distance -------------------------------------------------------------------------------- */

static void test_distance_outside_is_that_to_the_nearer_sphere(void **state) {
    const double apart = 0.24;
    nsdf_frame frame = make_spheres(2, apart);
    nsdf_sdf *sdf = nsdf_frame_sdf(&frame);
    nsdf_random random = nsdf_random_start(1, 0);
    int tried = 0;
    (void)state;
    assert_non_null(sdf);
    for (int i = 0; i < 4000; i++) {
        float p[3];
        random_point(&random, 0.45f, p);
        const double expected = two_spheres(p, apart);
        if (expected < sagitta)
            continue;
        tried++;
        const double found = (double)nsdf_sdf_distance(sdf, p);
        assert_true(found >= expected - 1e-6 && found <= expected + 2.0 * sagitta);
    }
    assert_true(tried > 2000);
    nsdf_sdf_free(sdf);
    free_frame(&frame);
}

/* Where the two spheres meet there is a circle, of radius sqrt(0.2^2 - 0.12^2) = 0.16.  Triangles that cross it are
 * kept or left out as a whole. */
static double to_circle(const float p[3]) {
    const double across = sqrt((double)p[1] * (double)p[1] + (double)p[2] * (double)p[2]) - 0.16;
    return sqrt(across * across + (double)p[0] * (double)p[0]);
}

static void test_distance_is_negative_everywhere_inside(void **state) {
    const double apart = 0.24;
    nsdf_frame frame = make_spheres(2, apart);
    nsdf_sdf *sdf = nsdf_frame_sdf(&frame);
    nsdf_random random = nsdf_random_start(2, 0);
    const float middle[3] = {0.0f, 0.0f, 0.0f};
    int tried = 0;
    (void)state;
    assert_non_null(sdf);
    for (int i = 0; i < 6000; i++) {
        float p[3];
        random_point(&random, 0.32f, p);
        const double expected = two_spheres(p, apart);
        if (expected > -2.0 * sagitta)
            continue;
        tried++;
        const double found = (double)nsdf_sdf_distance(sdf, p);
        assert_true(found < 0.0); /* the union is at least as deep as each ball */
        assert_true(found <= fmax(expected + 2.0 * sagitta, edge - to_circle(p)));
    }
    assert_true(tried > 1000);
    assert_true(fabs((double)nsdf_sdf_distance(sdf, middle) + 0.16) <= edge);
    nsdf_sdf_free(sdf);
    free_frame(&frame);
}

/* The plain distance is zero there, and its sign wrong between the hidden surfaces by other rules. */
static void test_hidden_surfaces_leave_no_trace(void **state) {
    const double apart = 0.24;
    nsdf_frame frame = make_spheres(2, apart);
    nsdf_sdf *sdf = nsdf_frame_sdf(&frame);
    int tried = 0;
    (void)state;
    assert_non_null(sdf);
    for (int i = 0; i < 400; i++)
        for (int step = -2; step <= 2; step++) {
            /* on the first sphere, deep inside of the second */
            const double angle = 0.01 * (i % 40), turn = 0.62 * (i / 40), r = radius + 5e-4 * step;
            const float p[3] = {(float)(r * cos(angle) - 0.5 * apart), (float)(r * sin(angle) * cos(turn)),
                                (float)(r * sin(angle) * sin(turn))};
            assert_true(nsdf_sdf_distance(sdf, p) < -0.08f);
            tried++;
        }
    assert_int_equal(tried, 2000);
    nsdf_sdf_free(sdf);
    free_frame(&frame);
}

/* ---- How small pieces are ------------------------------------------------------------------------------- */

static float smallest_piece(nsdf_frame *frame) {
    assert_int_equal(nsdf_frame_find_smallest_piece(frame), 0);
    return frame->smallest_piece;
}

static void test_the_smallest_piece_is_measured(void **state) {
    const float whole = 2.0f * (float)radius * sqrtf(3.0f);
    nsdf_frame apart = make_spheres(2, 0.6), together = make_spheres(2, 0.24);
    (void)state;
    assert_float_equal(smallest_piece(&apart), whole, 0.01);
    assert_float_equal(smallest_piece(&together), whole, 0.01); /* although each is seen in part only */
    for (uint32_t v = 0; v < apart.surface.vertex_count / 2; v++)
        for (size_t k = 0; k < 3; k++)
            apart.surface.positions[3 * v + k] *= 0.5f;
    assert_float_equal(smallest_piece(&apart), 0.5f * whole, 0.01);
    free_frame(&apart);
    free_frame(&together);
}

static void test_hidden_pieces_do_not_count(void **state) {
    nsdf_frame frame = make_spheres(2, 0.001); /* were they the same, one would be a duplicate */
    (void)state;
    for (uint32_t v = 0; v < frame.surface.vertex_count / 2; v++)
        for (size_t k = 0; k < 3; k++)
            frame.surface.positions[3 * v + k] *= 0.5f;
    free(frame.outer.indices);
    memset(&frame.outer, 0, sizeof frame.outer);
    assert_int_equal(nsdf_frame_find_outer(&frame), 0);
    assert_true(frame.outer.triangle_count == frame.surface.triangle_count / 2);
    assert_float_equal(smallest_piece(&frame), 2.0f * (float)radius * sqrtf(3.0f), 0.01);
    nsdf_frames frames = {.frames = &frame, .count = 1};
    assert_float_equal(nsdf_frames_smallest_piece(&frames), frame.smallest_piece, 0.0);
    free_frame(&frame);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_triangles_inside_of_the_other_sphere_are_left_out),
        cmocka_unit_test(test_a_single_sphere_hides_nothing),
        cmocka_unit_test(test_spheres_beside_each_other_hide_nothing),
        cmocka_unit_test(test_distance_outside_is_that_to_the_nearer_sphere),
        cmocka_unit_test(test_distance_is_negative_everywhere_inside),
        cmocka_unit_test(test_hidden_surfaces_leave_no_trace),
        cmocka_unit_test(test_the_smallest_piece_is_measured),
        cmocka_unit_test(test_hidden_pieces_do_not_count),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
