#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "geometry_shapes.h"
#include "sampler.h"

typedef struct scene {
    nsdf_surface surface;
    nsdf_sdf *sdf;
} scene;

static scene make_scene(nsdf_surface surface) {
    scene s = {surface, NULL};
    return s;
}

static void open_scene(scene *s) {
    s->sdf = nsdf_sdf_create(&s->surface, NSDF_SIGN_PSEUDO_NORMAL);
    assert_non_null(s->sdf);
}

static void close_scene(scene *s) {
    nsdf_sdf_free(s->sdf);
    nsdf_surface_free(&s->surface);
}

static nsdf_sample_set sample(const scene *s, const nsdf_sampler_params *params, uint64_t seed) {
    nsdf_sample_set set;
    nsdf_random random = nsdf_random_start(seed, 7);
    assert_int_equal(nsdf_sample_frame(s->sdf, &s->surface, params, &random, &set), 0);
    assert_int_equal(set.count, params->count);
    return set;
}

static void assert_share(size_t got, size_t total, double wanted) {
    double deviation = 5.0 * sqrt((double)total * wanted * (1.0 - wanted)) + 1.0;
    if (fabs((double)got - (double)total * wanted) > deviation) {
        fail_msg("%zu of %zu, wanted a share of %g", got, total, wanted);
    }
}

static void surface_points_are_uniform_by_area(void **state) {
    (void)state;
    nsdf_surface s = shape_cube(0.25);
    enum { N = 20000 };
    float *xyz = malloc(3 * sizeof(float) * N);
    nsdf_random random = nsdf_random_start(1, 1);
    assert_int_equal(nsdf_sample_surface(&s, N, &random, xyz), 0);
    size_t top = 0, top_quarter = 0;
    for (size_t i = 0; i < N; i++) {
        const float *p = &xyz[3 * i];
        assert_true(fabsf(fmaxf(fmaxf(fabsf(p[0]), fabsf(p[1])), fabsf(p[2])) - 0.25f) < 1e-6f);
        top += p[2] > 0.2499999f;
        top_quarter += p[2] > 0.2499999f && p[0] > 0.0f && p[1] < 0.0f;
    }
    assert_share(top, N, 1.0 / 6.0);
    assert_share(top_quarter, N, 1.0 / 24.0);
    free(xyz);
    nsdf_surface_free(&s);
}

static void a_surface_without_area_cannot_be_sampled(void **state) {
    (void)state;
    nsdf_surface s = shape_empty();
    float xyz[3];
    nsdf_random random = nsdf_random_start(1, 1);
    (void)shape_vertex(&s, 0, 0, 0);
    shape_triangle(&s, 0, 0, 0);
    assert_int_equal(nsdf_sample_surface(&s, 1, &random, xyz), -1);
    nsdf_surface_free(&s);
}

/* On a plane that fills the domain in x and y, |d| of displaced points is half-normal of the width asked for. */
static void noise_has_the_widths_and_shares_asked_for(void **state) {
    (void)state;
    scene s = make_scene(shape_cube(0.25));
    open_scene(&s);
    nsdf_sampler_params params;
    nsdf_sampler_defaults(&params);
    params.count = 40000;
    params.frame_box_share = 0.0f;
    params.domain_share = 0.0f;
    const float widths[3] = {0.0005f, 0.004f, 0.03f};
    for (int only = 0; only < 3; only++) {
        for (int i = 0; i < 3; i++) {
            params.noise[i] = widths[i];
            params.noise_share[i] = i == only ? 0.5f : 0.0f;
        }
        nsdf_sample_set set = sample(&s, &params, 3);
        double within_one = 0.0;
        for (size_t i = 0; i < set.count; i++) {
            within_one += fabsf(set.d[i]) < widths[only];
        }
        /* Edges of the cube bring a few nearer than the plane's 68.3 %. */
        assert_true(fabs(within_one / 40000.0 - 0.683) < (only == 2 ? 0.08 : 0.02));
        nsdf_sample_set_free(&set);
    }
    close_scene(&s);
}

static void defaults_mix_as_documented(void **state) {
    (void)state;
    scene s = make_scene(shape_sphere(0.2, 20, 30));
    open_scene(&s);
    nsdf_sampler_params params;
    nsdf_sampler_defaults(&params);
    params.count = 40000;
    nsdf_sample_set set = sample(&s, &params, 4);
    size_t far = 0, outside_box = 0, very_near = 0;
    for (size_t i = 0; i < set.count; i++) {
        float most = fmaxf(fmaxf(fabsf(set.x[i]), fabsf(set.y[i])), fabsf(set.z[i]));
        far += fabsf(set.d[i]) > 0.1f;
        outside_box += most > 0.2401f;
        very_near += fabsf(set.d[i]) < 0.004f;
        assert_true(most <= 0.5f);
    }
    /* Outside the frame's box (side 0.48): 1 - 0.48^3 of the domain's 5 %, and a little of the widest noise. */
    assert_true((double)outside_box > 40000 * 0.05 * 0.86);
    assert_true((double)outside_box < 40000 * (0.05 * 0.92 + 0.01));
    /* Farther than 0.1, five widths: only the two uniform parts. */
    double ball = 4.18879 * 0.001, outer = 4.18879 * 0.027;
    double box_far = (ball + 0.110592 - 0.105) / 0.110592, domain_far = ball + 1.0 - outer;
    assert_true((double)far < 40000 * (0.10 * box_far * 2.0 + 0.05 * domain_far) * 1.1);
    assert_true((double)far > 40000 * 0.05 * domain_far * 0.9);
    assert_true((double)very_near > 40000 * (0.35 * 0.93 + 0.30 * 0.45 + 0.20 * 0.13));
    nsdf_sample_set_free(&set);
    close_scene(&s);
}

static void samples_carry_their_distance_and_any_stretch_is_fair(void **state) {
    (void)state;
    scene s = make_scene(shape_torus(0.3, 0.1, 30, 20));
    open_scene(&s);
    for (int kind = 0; kind < 2; kind++) {
        nsdf_sampler_params params;
        nsdf_sampler_defaults(&params);
        params.kind = (nsdf_sampler_kind)kind;
        params.count = 20000;
        nsdf_sample_set set = sample(&s, &params, 5);
        double sums[2] = {0.0, 0.0};
        for (size_t i = 0; i < set.count; i++) {
            const float p[3] = {set.x[i], set.y[i], set.z[i]};
            assert_true(set.d[i] == nsdf_sdf_distance(s.sdf, p));
            sums[i % 20000 < 10000] += (double)fabsf(set.d[i]);
        }
        assert_true(fabs(sums[0] - sums[1]) < 0.1 * (sums[0] + sums[1]));
        nsdf_sample_set_free(&set);
    }
    close_scene(&s);
}

static void samples_stay_in_a_domain_that_cuts_the_surface(void **state) {
    (void)state;
    scene s = make_scene(shape_sphere(0.3, 16, 20));
    open_scene(&s);
    for (int kind = 0; kind < 2; kind++) {
        nsdf_sampler_params params;
        nsdf_sampler_defaults(&params);
        params.kind = (nsdf_sampler_kind)kind;
        params.count = 5000;
        params.domain_min[0] = 0.1f;
        params.domain_max[2] = 0.05f;
        nsdf_sample_set set = sample(&s, &params, 6);
        for (size_t i = 0; i < set.count; i++) {
            assert_true(set.x[i] >= 0.1f && set.z[i] <= 0.05f && set.x[i] <= 0.5f && fabsf(set.y[i]) <= 0.5f);
        }
        nsdf_sample_set_free(&set);
    }
    close_scene(&s);
}

/* Counts by distance from a cube, against the integral of exp(-k |d|) over the shells: the cube keeps its shape inside,
 * and is rounded outside. */
static void check_rejection(double d_half, uint64_t seed) {
    scene s = make_scene(shape_cube(0.25));
    open_scene(&s);
    nsdf_sampler_params params;
    nsdf_sampler_defaults(&params);
    params.kind = NSDF_SAMPLER_REJECTION;
    params.count = 20000;
    params.d_half = (float)d_half;
    nsdf_sample_set set = sample(&s, &params, seed);
    double k = log(2.0) / d_half, weight[12] = {0.0}, total = 0.0;
    size_t counts[12] = {0}, octants[8] = {0};
    for (int i = -60000; i < 60000; i++) {
        double d = (i + 0.5) * d_half * 1e-4, side = 0.5 + 2.0 * fmin(d, 0.0);
        double area = 6.0 * side * side + (d > 0.0 ? 12.0 * 1.5707963 * d * 0.5 + 4.0 * 3.14159265 * d * d : 0.0);
        double w = area * exp(-k * fabs(d));
        weight[(int)floor(d / d_half) + 6] += w;
        total += w;
    }
    size_t seen = 0;
    for (size_t i = 0; i < set.count; i++) {
        double bin = floor((double)set.d[i] / d_half) + 6.0;
        octants[(set.x[i] > 0.0f) + 2 * (set.y[i] > 0.0f) + 4 * (set.z[i] > 0.0f)]++;
        if (bin >= 0.0 && bin < 12.0) {
            counts[(int)bin]++;
            seen++;
        }
    }
    assert_true(seen > 19500);
    for (int bin = 0; bin < 12; bin++) {
        assert_share(counts[bin], seen, weight[bin] / total);
    }
    for (int i = 0; i < 8; i++) {
        assert_share(octants[i], set.count, 0.125);
    }
    nsdf_sample_set_free(&set);
    close_scene(&s);
}

static void rejection_follows_the_exponential(void **state) {
    (void)state;
    check_rejection(0.02, 8);
    check_rejection(0.004, 9);
}

/* Cells of several sizes meet at the surface here, because their number is limited: none may be preferred.  On a grid
 * that fits the cube half of the samples are in even cells. */
static void rejection_does_not_show_its_cells(void **state) {
    (void)state;
    scene s = make_scene(shape_cube(0.25));
    open_scene(&s);
    nsdf_sampler_params params;
    nsdf_sampler_defaults(&params);
    params.kind = NSDF_SAMPLER_REJECTION;
    params.count = 40000;
    params.d_half = 3e-4f;
    nsdf_sample_set set = sample(&s, &params, 12);
    for (int cells = 8; cells <= 256; cells *= 2) {
        size_t even[3] = {0, 0, 0};
        for (size_t i = 0; i < set.count; i++) {
            even[0] += (int)floorf((set.x[i] + 0.5f) * (float)cells) % 2 == 0;
            even[1] += (int)floorf((set.y[i] + 0.5f) * (float)cells) % 2 == 0;
            even[2] += (int)floorf((set.z[i] + 0.5f) * (float)cells) % 2 == 0;
        }
        for (int k = 0; k < 3; k++) {
            assert_share(even[k], set.count, 0.5);
        }
    }
    nsdf_sample_set_free(&set);
    close_scene(&s);
}

static void rejection_is_finite_and_right_for_tiny_d_half(void **state) {
    (void)state;
    check_rejection(3e-5, 10);
    scene s = make_scene(shape_cube(0.25));
    open_scene(&s);
    nsdf_sampler_params params;
    nsdf_sampler_defaults(&params);
    params.kind = NSDF_SAMPLER_REJECTION;
    params.count = 1000;
    params.d_half = 0.0f;
    nsdf_sample_set set = sample(&s, &params, 11);
    for (size_t i = 0; i < set.count; i++) {
        assert_true(fabsf(set.d[i]) < 1e-6f);
    }
    nsdf_sample_set_free(&set);
    close_scene(&s);
}

static void the_same_random_state_gives_the_same_samples(void **state) {
    (void)state;
    scene s = make_scene(shape_torus(0.3, 0.1, 20, 10));
    open_scene(&s);
    for (int kind = 0; kind < 2; kind++) {
        nsdf_sampler_params params;
        nsdf_sampler_defaults(&params);
        params.kind = (nsdf_sampler_kind)kind;
        params.count = 1000;
        nsdf_sample_set a = sample(&s, &params, 1), b = sample(&s, &params, 1), c = sample(&s, &params, 2);
        assert_memory_equal(a.x, b.x, 1000 * sizeof(float));
        assert_memory_equal(a.y, b.y, 1000 * sizeof(float));
        assert_memory_equal(a.z, b.z, 1000 * sizeof(float));
        assert_memory_equal(a.d, b.d, 1000 * sizeof(float));
        assert_memory_not_equal(a.x, c.x, 1000 * sizeof(float));
        nsdf_sample_set_free(&a);
        nsdf_sample_set_free(&b);
        nsdf_sample_set_free(&c);
    }
    close_scene(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(surface_points_are_uniform_by_area),
        cmocka_unit_test(a_surface_without_area_cannot_be_sampled),
        cmocka_unit_test(noise_has_the_widths_and_shares_asked_for),
        cmocka_unit_test(defaults_mix_as_documented),
        cmocka_unit_test(samples_carry_their_distance_and_any_stretch_is_fair),
        cmocka_unit_test(samples_stay_in_a_domain_that_cuts_the_surface),
        cmocka_unit_test(rejection_follows_the_exponential),
        cmocka_unit_test(rejection_does_not_show_its_cells),
        cmocka_unit_test(rejection_is_finite_and_right_for_tiny_d_half),
        cmocka_unit_test(the_same_random_state_gives_the_same_samples),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
