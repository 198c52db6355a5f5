/* Training data: normalisation of frames, their orientation, samples, and what follows from them. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "dataset.h"
#include "frames_repair.h"
#include "fit_samples.h"

static const double margin = 0.02;

/* Frames, and all that sampling them needs. */
typedef struct fixture {
    nsdf_frames frames;
    nsdf_encoder_options options;
    nsdf_file_header header;
    nsdf_dataset dataset;
    nsdf_encoder_error error;
} fixture;

static fixture *new_fixture(void) {
    fixture *f = calloc(1, sizeof *f);
    assert_non_null(f);
    f->options = sample_options(2, 8);
    f->options.samples_per_frame = 3000;
    return f;
}

static void free_fixture(fixture *f) {
    nsdf_frames_free(&f->frames);
    nsdf_dataset_free(&f->dataset);
    free(f);
}

/* Frees the surface. */
static void add(fixture *f, uint32_t number, nsdf_surface surface, double scale, double x, double y, double z) {
    nsdf_input_mesh mesh = mesh_of(&surface, scale, x, y, z);
    assert_int_equal(nsdf_frames_add(&f->frames, number, &mesh, &f->error), NSDF_OK);
    free((void *)mesh.positions);
    nsdf_surface_free(&surface);
}

static nsdf_status sample(fixture *f, uint32_t threads, nsdf_progress_fn progress) {
    nsdf_workers *workers = nsdf_workers_create(threads);
    assert_non_null(workers);
    assert_int_equal(nsdf_frames_normalise(&f->frames, margin, &f->header, &f->error), NSDF_OK);
    const nsdf_repair_job repair = {&f->frames, &f->options, &f->header, workers, NULL, NULL, 0.0};
    const nsdf_dataset_job job = {&f->frames, &f->options, &f->header, workers, progress, NULL, 0.0};
    nsdf_mesh_report report;
    nsdf_status status = nsdf_frames_repair(&repair, &report, &f->error);
    if (status == NSDF_OK)
        status = nsdf_dataset_create(&f->dataset, &job, &f->error);
    nsdf_workers_free(workers);
    return status;
}

static nsdf_surface flat_sheet(void) {
    nsdf_surface s = shape_empty();
    for (int i = 0; i < 4; i++)
        (void)shape_vertex(&s, i & 1, i & 2 ? 1.0 : 0.0, 0.0);
    shape_triangle(&s, 0, 1, 3);
    shape_triangle(&s, 0, 3, 2);
    return s;
}

/* ---- Frames --------------------------------------------------------------------------------------------- */

static void test_one_box_over_all_frames_is_centred_and_divided_by_its_diagonal(void **state) {
    fixture *f = new_fixture();
    (void)state;
    add(f, 0, shape_cube(1.0), 1.0, 10.0, 20.0, 30.0);
    add(f, 1, shape_cube(1.0), 1.0, 14.0, 20.0, 30.0); /* the box is 6 x 2 x 2 */
    assert_int_equal(nsdf_frames_normalise(&f->frames, margin, &f->header, &f->error), NSDF_OK);
    const nsdf_file_header *h = &f->header;
    const double diagonal = sqrt(44.0);
    assert_true(fabs(h->scale - diagonal) < 1e-12);
    for (int k = 0; k < 3; k++) {
        const double side = k ? 2.0 : 6.0;
        assert_true(fabs(h->centre[k] - (k ? 10.0 + 10.0 * k : 12.0)) < 1e-12);
        assert_true(fabs(h->box_max[k] - h->box_min[k] - side) < 1e-12);
        assert_true(fabs((double)h->domain_max[k] - (0.5 * side / diagonal + margin)) < 1e-6);
        assert_true(h->domain_min[k] == -h->domain_max[k]);
    }
    for (int i = 0; i < 2; i++)
        for (int v = 0; v < 24; v++) {
            const double corner = v % 3 ? 1.0 : 1.0 + 2.0 * ((v / 3 & 1) == i);
            assert_true(fabs(fabs((double)f->frames.frames[i].surface.positions[v]) - corner / diagonal) < 1e-6);
        }
    free_fixture(f);
}

static void test_vertices_without_triangles_do_not_count(void **state) {
    fixture *f = new_fixture();
    nsdf_surface cube = shape_cube(1.0);
    (void)state;
    (void)shape_vertex(&cube, 50.0, 0.0, 0.0);
    add(f, 0, cube, 1.0, 0.0, 0.0, 0.0);
    assert_int_equal(nsdf_frames_normalise(&f->frames, margin, &f->header, &f->error), NSDF_OK);
    assert_true(fabs(f->header.scale - sqrt(12.0)) < 1e-12);
    free_fixture(f);
}

static void test_meshes_far_from_the_origin_keep_their_shape(void **state) {
    fixture *near = new_fixture(), *far = new_fixture();
    (void)state;
    add(near, 0, shape_sphere(1.0, 8, 16), 1.0, 0.0, 0.0, 0.0);
    add(far, 0, shape_sphere(1.0, 8, 16), 1.0, 1e8, -1e8, 3e8);
    assert_int_equal(nsdf_frames_normalise(&near->frames, margin, &near->header, &near->error), NSDF_OK);
    assert_int_equal(nsdf_frames_normalise(&far->frames, margin, &far->header, &far->error), NSDF_OK);
    const nsdf_surface *a = &near->frames.frames[0].surface, *b = &far->frames.frames[0].surface;
    for (size_t i = 0; i < 3 * (size_t)a->vertex_count; i++)
        assert_true(fabsf(a->positions[i] - b->positions[i]) < 1e-6f);
    free_fixture(near);
    free_fixture(far);
}

/* ---- Samples -------------------------------------------------------------------------------------------- */

static void test_time_of_frames_follows_their_numbers(void **state) {
    static const uint32_t numbers[] = {5, 6, 10, 15};
    static const double expected[] = {0.0, 0.1, 0.5, 1.0};
    fixture *f = new_fixture(), *single = new_fixture();
    (void)state;
    for (int i = 0; i < 4; i++)
        add(f, numbers[i], shape_cube(1.0), 1.0, 0.0, 0.0, 0.0);
    assert_int_equal(sample(f, 1, NULL), NSDF_OK);
    assert_int_equal(f->dataset.frame_count, 4);
    for (int i = 0; i < 4; i++)
        assert_true(fabs(f->dataset.u[i] - expected[i]) < 1e-15);
    add(single, 7, shape_cube(1.0), 1.0, 0.0, 0.0, 0.0);
    assert_int_equal(sample(single, 1, NULL), NSDF_OK);
    assert_true(single->dataset.u[0] == 0.0);
    free_fixture(f);
    free_fixture(single);
}

static void check_distances(const nsdf_sample_set *set, const nsdf_surface *surface, const nsdf_file_header *h) {
    for (size_t i = 0; i < set->count; i++) {
        const float p[3] = {set->x[i], set->y[i], set->z[i]};
        for (int k = 0; k < 3; k++)
            assert_true(p[k] >= h->domain_min[k] && p[k] <= h->domain_max[k]);
        assert_true(fabs((double)set->d[i] - exact_signed(surface, p)) < 1e-6);
    }
}

static void test_samples_are_signed_distances_inside_the_domain(void **state) {
    (void)state;
    for (int sampling = NSDF_SAMPLE_NEAR_SURFACE; sampling <= NSDF_SAMPLE_REJECTION; sampling++) {
        fixture *f = new_fixture();
        f->options.sampling = (nsdf_sampling)sampling;
        f->options.d_half = 0.03;
        add(f, 0, shape_cube(1.0), 1.0, 0.0, 0.0, 0.0);
        add(f, 1, shape_cube(1.0), 1.0, 1.0, 0.5, 0.0);
        assert_int_equal(sample(f, 2, NULL), NSDF_OK);
        for (int i = 0; i < 2; i++) {
            assert_int_equal(f->dataset.sets[i].count, 3000);
            check_distances(&f->dataset.sets[i], &f->frames.frames[i].surface, &f->header);
        }
        free_fixture(f);
    }
}

static void test_samples_do_not_depend_on_the_threads(void **state) {
    fixture *f[2] = {new_fixture(), new_fixture()};
    (void)state;
    for (int k = 0; k < 2; k++) {
        for (uint32_t i = 0; i < 7; i++)
            add(f[k], i, shape_sphere(1.0, 6, 9), 1.0, 0.1 * i, 0.0, 0.0);
        assert_int_equal(sample(f[k], k ? 3 : 1, NULL), NSDF_OK);
    }
    for (int i = 0; i < 7; i++) {
        const nsdf_sample_set *a = &f[0]->dataset.sets[i], *b = &f[1]->dataset.sets[i];
        assert_int_equal(a->count, b->count);
        assert_memory_equal(a->x, b->x, a->count * sizeof *a->x);
        assert_memory_equal(a->d, b->d, a->count * sizeof *a->d);
    }
    assert_memory_not_equal(f[0]->dataset.sets[0].x, f[0]->dataset.sets[1].x, 100);
    free_fixture(f[0]);
    free_fixture(f[1]);
}

static void test_frames_need_an_inside(void **state) {
    fixture *f = new_fixture();
    (void)state;
    f->options.shell = NSDF_NO_SHELL;
    add(f, 3, flat_sheet(), 1.0, 0.0, 0.0, 0.0);
    assert_int_equal(sample(f, 1, NULL), NSDF_INVALID_ARGUMENT);
    assert_string_equal(f->error.message, "frame 3 has no inside: it is a sheet with 4 open edges; give it a thickness "
                                          "(shell)");
    free_fixture(f);
}

static void test_sheets_get_a_thickness(void **state) {
    (void)state;
    for (int asked = 0; asked < 2; asked++) {
        fixture *f = new_fixture();
        const double half = asked ? 0.05 / sqrt(2.0) : 0.5 / 300.0;
        double deepest = 0.0;
        f->options.shell = asked ? 0.1 : 0.0;
        add(f, 3, flat_sheet(), 1.0, 0.0, 0.0, 0.0);
        assert_int_equal(sample(f, 1, NULL), NSDF_OK);
        const nsdf_sample_set *set = &f->dataset.sets[0];
        for (size_t i = 0; i < set->count; i++) {
            const double x = (double)set->x[i] * sqrt(2.0) + 0.5, y = (double)set->y[i] * sqrt(2.0) + 0.5;
            deepest = fmin(deepest, (double)set->d[i]);
            if (x > 0.1 && x < 0.9 && y > 0.1 && y < 0.9 && (double)set->d[i] < 0.05)
                assert_true(fabs((double)set->d[i] - (fabs((double)set->z[i]) - half)) < 1e-5);
        }
        assert_true(deepest < -0.9 * half && deepest > -1.001 * half);
        free_fixture(f);
    }
}

static void test_frames_without_area_are_the_callers_mistake(void **state) {
    static const double line[9] = {0, 0, 0, 1, 1, 1, 2, 2, 2};
    static const uint32_t triangle[3] = {0, 1, 2};
    const nsdf_input_mesh mesh = {line, triangle, 3, 1};
    fixture *f = new_fixture();
    (void)state;
    add(f, 0, shape_cube(1.0), 1.0, 0.0, 0.0, 0.0);
    assert_int_equal(nsdf_frames_add(&f->frames, 1, &mesh, &f->error), NSDF_OK);
    assert_int_equal(sample(f, 1, NULL), NSDF_INVALID_ARGUMENT);
    assert_string_equal(f->error.message, "frame 1 has no area");
    free_fixture(f);
}

static int answer_abort(void *user, const nsdf_progress *progress) {
    (void)user;
    assert_int_equal(progress->stage, NSDF_STAGE_SAMPLE);
    return NSDF_ABORT;
}

static void test_abort_cancels_sampling(void **state) {
    fixture *f = new_fixture();
    (void)state;
    add(f, 0, shape_cube(1.0), 1.0, 0.0, 0.0, 0.0);
    assert_int_equal(sample(f, 1, answer_abort), NSDF_CANCELLED);
    assert_int_equal(f->error.status, NSDF_CANCELLED);
    assert_null(f->dataset.sets);
    free_fixture(f);
}

/* ---- Normalisations that need the samples --------------------------------------------------------------- */

static void test_unit_range_maps_all_distances_to_plus_minus_one(void **state) {
    fixture *f = new_fixture();
    nsdf_network_desc desc = {.value_scale = 1.0f, .time_scale = 1.0f};
    float low = 9.0f, high = -9.0f;
    (void)state;
    add(f, 0, shape_cube(1.0), 1.0, 0.0, 0.0, 0.0);
    add(f, 1, shape_cube(1.0), 1.0, 4.0, 0.0, 0.0);
    assert_int_equal(sample(f, 1, NULL), NSDF_OK);
    nsdf_dataset_normalise(&f->dataset, &f->options, &desc);
    assert_true(desc.value_scale == 1.0f && desc.value_offset == 0.0f);
    f->options.sdf_norm = NSDF_SDF_UNIT_RANGE;
    nsdf_dataset_normalise(&f->dataset, &f->options, &desc);
    for (int k = 0; k < 2; k++)
        for (size_t i = 0; i < f->dataset.sets[k].count; i++) {
            const float n = (f->dataset.sets[k].d[i] - desc.value_offset) / desc.value_scale;
            low = fminf(low, n);
            high = fmaxf(high, n);
        }
    assert_true(fabsf(low + 1.0f) < 1e-5f && fabsf(high - 1.0f) < 1e-5f);
    free_fixture(f);
}

/* Fits `frames` frames of a sphere that moves by `step` radii a frame; returns the time scale, and the movement. */
static float time_scale(double step, nsdf_model_input input, nsdf_time_norm norm, double *normalised_step) {
    fixture *f = new_fixture();
    nsdf_network_desc desc = {.value_scale = 1.0f, .time_scale = 1.0f};
    f->options.samples_per_frame = 20000;
    f->options.input = input;
    f->options.time_norm = norm;
    for (uint32_t i = 0; i < 4; i++)
        add(f, i, shape_sphere(1.0, 12, 24), 1.0, step * i, 0.0, 0.0);
    assert_int_equal(sample(f, 2, NULL), NSDF_OK);
    nsdf_dataset_normalise(&f->dataset, &f->options, &desc);
    *normalised_step = step / f->header.scale;
    free_fixture(f);
    return desc.time_scale;
}

/* The distance at a place changes by at most the movement; the estimate stays below that, and not far below. */
static void test_speed_of_a_moving_sphere(void **state) {
    double moved;
    (void)state;
    for (double step = 0.2; step < 1.0; step += 0.2) {
        const double scale = (double)time_scale(step, NSDF_MODEL_XYZT, NSDF_TIME_SPEED, &moved);
        assert_true(1.0 / scale <= moved * 1.001);
        assert_true(1.0 / scale >= moved * 0.85);
    }
    assert_true(time_scale(0.4, NSDF_MODEL_XYZT, NSDF_TIME_UNIT, &moved) == 1.0f);
    assert_true(time_scale(0.4, NSDF_MODEL_XYZ, NSDF_TIME_SPEED, &moved) == 1.0f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_one_box_over_all_frames_is_centred_and_divided_by_its_diagonal),
        cmocka_unit_test(test_vertices_without_triangles_do_not_count),
        cmocka_unit_test(test_meshes_far_from_the_origin_keep_their_shape),
        cmocka_unit_test(test_time_of_frames_follows_their_numbers),
        cmocka_unit_test(test_samples_are_signed_distances_inside_the_domain),
        cmocka_unit_test(test_samples_do_not_depend_on_the_threads),
        cmocka_unit_test(test_frames_need_an_inside),
        cmocka_unit_test(test_sheets_get_a_thickness),
        cmocka_unit_test(test_frames_without_area_are_the_callers_mistake),
        cmocka_unit_test(test_abort_cancels_sampling),
        cmocka_unit_test(test_unit_range_maps_all_distances_to_plus_minus_one),
        cmocka_unit_test(test_speed_of_a_moving_sphere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
