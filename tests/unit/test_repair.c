/* Each kind of dirty input, made by samples/dirty_mesh.c, against distances that are known without it. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "dirty_mesh.h"
#include "fit_samples.h"
#include "frames_repair.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double no_limit = 1e30;

/* A shape with faults as one frame, repaired; and the unsigned distance to its triangles as they were made. */
typedef struct {
    nsdf_encoder_options options;
    nsdf_frames frames;
    nsdf_file_header header;
    nsdf_mesh_report report;
    nsdf_surface made;
    nsdf_sdf *sdf, *raw;
} patient;

static nsdf_surface copy_surface(const nsdf_surface *s) {
    nsdf_surface copy = {malloc(3 * sizeof(float) * s->vertex_count), malloc(3 * sizeof(uint32_t) * s->triangle_count),
                         s->vertex_count, s->triangle_count};
    assert_true(copy.positions && copy.indices);
    memcpy(copy.positions, s->positions, 3 * sizeof(float) * s->vertex_count);
    memcpy(copy.indices, s->indices, 3 * sizeof(uint32_t) * s->triangle_count);
    return copy;
}

/* `faults` are separated by blanks. */
static patient *admit(const char *shape, const char *faults, double shell) {
    patient *p = calloc(1, sizeof *p);
    dirty_mesh mesh = {0};
    char words[100], *rest = words;
    nsdf_encoder_error error;
    assert_non_null(p);
    assert_int_equal(dirty_shape(shape, 0.0, &mesh), 0);
    snprintf(words, sizeof words, "%s", faults);
    for (char *fault; (fault = strtok_r(rest, " ", &rest)) != NULL;)
        assert_int_equal(dirty_apply(fault, 1, &mesh), 0);
    p->options = sample_options(2, 8);
    p->options.shell = shell;
    const nsdf_input_mesh input = {mesh.positions, mesh.triangles, (uint32_t)mesh.vertex_count,
                                   (uint32_t)mesh.triangle_count};
    assert_int_equal(nsdf_frames_add(&p->frames, 0, &input, &error), NSDF_OK);
    assert_int_equal(nsdf_frames_normalise(&p->frames, 0.02, &p->header, &error), NSDF_OK);
    p->made = copy_surface(&p->frames.frames[0].surface);
    nsdf_workers *workers = nsdf_workers_create(1);
    const nsdf_repair_job job = {&p->frames, &p->options, &p->header, workers, NULL, NULL, 0.0};
    assert_int_equal(nsdf_frames_repair(&job, &p->report, &error), NSDF_OK);
    p->sdf = nsdf_frame_sdf(&p->frames.frames[0]);
    p->raw = nsdf_sdf_create(&p->made, NSDF_SIGN_WINDING);
    assert_true(p->sdf && p->raw);
    nsdf_workers_free(workers);
    dirty_mesh_free(&mesh);
    return p;
}

static void discharge(patient *p) {
    nsdf_sdf_free(p->sdf);
    nsdf_sdf_free(p->raw);
    nsdf_surface_free(&p->made);
    nsdf_frames_free(&p->frames);
    free(p);
}

/* Compares with what is expected at random points of the domain and near the surface; world units of the shape before
 * any `unit`.  Where the expected value is below -deepest, the sign is all that counts. */
static void expect(const patient *p, double (*distance)(const patient *p, const double x[3]), double unit,
                   double tolerance, double deepest) {
    nsdf_random random = nsdf_random_start(3, 5);
    for (int i = 0; i < 4000; i++) {
        float point[3];
        double x[3];
        const uint32_t vertex = nsdf_random_below(&random, p->made.vertex_count);
        for (size_t k = 0; k < 3; k++) {
            const float low = p->header.domain_min[k], high = p->header.domain_max[k];
            point[k] = i % 2 ? low + (high - low) * nsdf_random_unit(&random)
                             : p->made.positions[3 * (size_t)vertex + k] + 0.02f * nsdf_random_normal(&random);
            point[k] = fminf(fmaxf(point[k], low), high);
            x[k] = ((double)point[k] * p->header.scale + p->header.centre[k]) / unit;
        }
        const double wanted = distance(p, x), got = (double)nsdf_sdf_distance(p->sdf, point) * p->header.scale / unit;
        if (wanted < -deepest)
            assert_true(got < 0.0);
        else
            assert_true(fabs(got - wanted) < tolerance);
    }
}

/* The middles of the triangles are inside. */
static void expect_within(const patient *p) {
    for (uint32_t i = 0; i < p->made.triangle_count; i++) {
        float middle[3] = {0.0f, 0.0f, 0.0f};
        for (size_t k = 0; k < 9; k++)
            middle[k % 3] += p->made.positions[3 * (size_t)p->made.indices[3 * (size_t)i + k / 3] + k % 3] / 3.0f;
        assert_true((double)nsdf_sdf_distance(p->sdf, middle) * p->header.scale < -0.2 * p->report.sheet_thickness);
    }
}

/* ---- Distances -------------------------------------------------------------------------------------------- */

static double to_sphere(const double x[3], double cx, double cy, double cz, double radius) {
    const double a = x[0] - cx, b = x[1] - cy, c = x[2] - cz;
    return sqrt(a * a + b * b + c * c) - radius;
}

static double one_sphere(const patient *p, const double x[3]) {
    (void)p;
    return to_sphere(x, 0.0, 0.0, 0.0, 1.0);
}

static double two_spheres(const patient *p, const double x[3]) {
    (void)p;
    return fmin(to_sphere(x, 0.0, 0.0, 0.0, 1.0), to_sphere(x, 1.2, 0.3, 0.1, 0.8));
}

static double unit_box(const patient *p, const double x[3]) {
    double outside = 0.0, most = -INFINITY;
    (void)p;
    for (int k = 0; k < 3; k++) {
        const double d = fabs(x[k]) - 1.0;
        outside += d > 0.0 ? d * d : 0.0;
        most = fmax(most, d);
    }
    return most > 0.0 ? sqrt(outside) : most;
}

/* What is half a thickness around the triangles. */
static double shell(const patient *p, const double x[3]) {
    float point[3];
    for (size_t k = 0; k < 3; k++)
        point[k] = (float)((x[k] - p->header.centre[k]) / p->header.scale);
    const double d = (double)nsdf_sdf_unsigned(p->raw, point, INFINITY, NULL) * p->header.scale;
    return d - 0.5 * p->report.sheet_thickness;
}

/* The shell or the sphere, whose triangles are among the raw ones: only its inside tells them apart. */
static double sphere_and_shell(const patient *p, const double x[3]) {
    const double ball = one_sphere(p, x);
    return ball < 0.0 ? ball : fmin(ball, shell(p, x) + (ball < 0.05 ? INFINITY : 0.0));
}

/* ---- Tests ------------------------------------------------------------------------------------------------ */

typedef struct {
    const char *faults;
    double unit;
    size_t counted; /* offset in the report of what has to be above 0, 0 = all is clean */
} sphere_case;

#define COUNTED(field) offsetof(nsdf_mesh_report, field)

static void test_faults_of_a_closed_mesh_are_mended(void **state) {
    static const sphere_case cases[] = {
        {"", 1.0, 0},
        {"flip=0.1", 1.0, COUNTED(inconsistent_edges)},
        {"flip=0.7", 1.0, COUNTED(turned_faces)},
        {"inward", 1.0, COUNTED(reversed)},
        {"remove=0.01", 1.0, COUNTED(filled_holes)},
        {"split", 1.0, COUNTED(duplicate_vertices)},
        {"broken", 1.0, COUNTED(filled_holes)},
        {"broken inward", 1.0, COUNTED(turned_faces)},
        {"duplicate=0.1", 1.0, COUNTED(duplicate_faces)},
        {"sliver=0.1", 1.0, COUNTED(zero_area_faces)},
        {"unused=5", 1.0, COUNTED(unreferenced_vertices)},
        {"nan=5", 1.0, COUNTED(unreferenced_vertices)},
        {"order", 1.0, 0},
        {"scale=1e-9", 1e-9, 0},
        {"scale=1e12", 1e12, 0},
        {"broken duplicate=0.1 sliver=0.1 order scale=1e-6", 1e-6, COUNTED(inconsistent_edges)}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        patient *p = admit("sphere", cases[i].faults, 0.0);
        uint64_t count;
        memcpy(&count, (const char *)&p->report + cases[i].counted, sizeof count);
        assert_true(cases[i].counted ? count > 0 : p->report.dirty == 0);
        assert_int_equal(p->report.open_bodies + p->report.sheets + p->report.hidden_faces, 0);
        expect(p, one_sphere, cases[i].unit, 0.025, no_limit);
        discharge(p);
    }
}

/* Big enough that they are not filled. */
static void test_large_holes_are_closed_by_winding_number(void **state) {
    (void)state;
    patient *p = admit("sphere", "remove=0.3 flip=0.1 split", NSDF_NO_SHELL);
    assert_true(p->report.open_bodies == 1 || p->report.filled_holes > 0);
    expect(p, one_sphere, 1.0, 0.3, 0.2);
    discharge(p);
}

static void test_open_pieces_are_given_a_thickness(void **state) {
    static const char *const cases[][2] = {{"sheet", ""},    {"sheet", "flip=0.3"}, {"sheet", "split order"},
                                           {"twosided", ""}, {"bowl", ""},          {"moebius", ""}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        for (int asked = 0; asked < 2; asked++) {
            patient *p = admit(cases[i][0], cases[i][1], asked ? 0.06 : 0.0);
            const double thickness = asked ? 0.06 : p->header.scale / 300.0;
            assert_int_equal(p->report.sheets, 1);
            assert_true(p->report.sheet_share == 1.0);
            assert_true(fabs(p->report.sheet_thickness - thickness) < 1e-9);
            assert_int_equal(p->report.one_sided, strcmp(cases[i][0], "moebius") == 0);
            /* The body ends where the sheet does, and not half a thickness further. */
            expect(p, shell, 1.0, 0.55 * thickness, no_limit);
            expect_within(p);
            discharge(p);
        }
}

static void test_sheets_beside_bodies_are_told_apart(void **state) {
    static const char *const shapes[] = {"cloak", "fin"}, *const faults[] = {"", "flip=0.2 split order"};
    (void)state;
    for (int i = 0; i < 4; i++) {
        patient *p = admit(shapes[i / 2], faults[i % 2], 0.0);
        assert_int_equal(p->report.sheets, 1);
        assert_true(p->report.sheet_share > 0.05 && p->report.sheet_share < 0.5);
        expect(p, sphere_and_shell, 1.0, 0.03, no_limit);
        discharge(p);
    }
}

static void test_what_is_within_a_body_does_not_count(void **state) {
    static const char *const faults[] = {"", "flip=0.2 split order"};
    (void)state;
    for (int i = 0; i < 2; i++) {
        patient *p = admit("walled", faults[i], 0.0);
        assert_true(p->report.inner_faces == 48 && p->report.non_manifold_edges == 48);
        expect(p, one_sphere, 1.0, 0.025, no_limit);
        discharge(p);
        p = admit("nested", faults[i], 0.0);
        assert_true(p->report.hidden_faces == p->report.triangles / 2);
        expect(p, one_sphere, 1.0, 0.025, no_limit);
        discharge(p);
        p = admit("crossing", faults[i], 0.0);
        assert_true(p->report.hidden_faces > 300);
        expect(p, two_spheres, 1.0, 0.12, 0.02);
        discharge(p);
    }
}

static void test_sides_that_share_no_edges_make_a_body(void **state) {
    static const char *const faults[] = {"", "split", "flip=0.1 split order"};
    (void)state;
    for (int i = 0; i < 3; i++) {
        patient *p = admit("seams", faults[i], 0.0);
        assert_true(p->report.sheets == 0 && p->report.open_bodies == 1);
        expect(p, unit_box, 1.0, 1e-4, no_limit);
        discharge(p);
    }
}

static void test_a_hole_in_a_cavity_keeps_it_a_cavity(void **state) {
    dirty_mesh outer = {0}, inner = {0};
    (void)state;
    assert_int_equal(dirty_shape("sphere", 0.0, &outer), 0);
    assert_int_equal(dirty_shape("sphere", 0.0, &inner), 0);
    assert_int_equal(dirty_apply("scale=0.5", 1, &inner) | dirty_apply("inward", 1, &inner), 0);
    const size_t base = outer.vertex_count;
    for (size_t v = 0; v < inner.vertex_count; v++) {
        const double *x = inner.positions + 3 * v;
        assert_int_equal(dirty_mesh_add_vertex(&outer, x[0], x[1], x[2]), 0);
    }
    for (size_t i = 0; i < inner.triangle_count; i++) {
        const uint32_t *t = inner.triangles + 3 * i;
        assert_int_equal(dirty_mesh_add_triangle(&outer, base + t[0], base + t[1], base + t[2]), 0);
    }
    assert_int_equal(dirty_apply("broken", 1, &outer), 0);
    const nsdf_input_mesh mesh = {outer.positions, outer.triangles, (uint32_t)outer.vertex_count,
                                  (uint32_t)outer.triangle_count};
    const nsdf_encoder_options options = sample_options(2, 8);
    nsdf_mesh_report report;
    assert_int_equal(nsdf_encoder_check_mesh(&options, &mesh, &report, NULL), NSDF_OK);
    /* About a tenth, not a half: the cavity was inward, and stays so. */
    assert_true(report.turned_faces < report.triangles / 6 && report.hidden_faces == 0 && report.sheets == 0);
    dirty_mesh_free(&outer);
    dirty_mesh_free(&inner);
}

static void test_unrepaired_frames_stay_as_they_are(void **state) {
    (void)state;
    patient *p = admit("sphere", "order unused=3 sliver=0.01", 0.0);
    const nsdf_surface *s = &p->frames.frames[0].surface;
    assert_int_equal(s->triangle_count, p->made.triangle_count);
    assert_memory_equal(s->indices, p->made.indices, 3 * sizeof(uint32_t) * s->triangle_count);
    assert_int_equal(p->frames.frames[0].filled, 0);
    discharge(p);
}

static void test_faces_must_have_finite_corners(void **state) {
    dirty_mesh mesh = {0};
    const nsdf_encoder_options options = sample_options(2, 8);
    nsdf_mesh_report report;
    nsdf_encoder_error error;
    (void)state;
    assert_int_equal(dirty_shape("sphere", 0.0, &mesh) | dirty_apply("badnan", 1, &mesh), 0);
    const nsdf_input_mesh input = {mesh.positions, mesh.triangles, (uint32_t)mesh.vertex_count,
                                   (uint32_t)mesh.triangle_count};
    assert_int_equal(nsdf_encoder_check_mesh(&options, &input, &report, &error), NSDF_INVALID_ARGUMENT);
    assert_string_equal(error.message, "frame 0: vertex 0 is not finite");
    dirty_mesh_free(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_faults_of_a_closed_mesh_are_mended),
        cmocka_unit_test(test_large_holes_are_closed_by_winding_number),
        cmocka_unit_test(test_open_pieces_are_given_a_thickness),
        cmocka_unit_test(test_sheets_beside_bodies_are_told_apart),
        cmocka_unit_test(test_what_is_within_a_body_does_not_count),
        cmocka_unit_test(test_sides_that_share_no_edges_make_a_body),
        cmocka_unit_test(test_a_hole_in_a_cavity_keeps_it_a_cavity),
        cmocka_unit_test(test_unrepaired_frames_stay_as_they_are),
        cmocka_unit_test(test_faces_must_have_finite_corners),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
