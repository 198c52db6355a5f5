/* Stray surfaces: networks made by hand, whose zero set is a plane, an octahedron or a slab, against meshes. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "fit_samples.h"
#include "stray.h"

enum { MAX_FRAMES = 2, MAX_WORKERS = 3, RESOLUTION = 64 };

/* A network over x, y, z, t of one hidden relu layer, whose units the tests add one by one. */
typedef struct network {
    nsdf_model model;
    float parameters[128];
    uint32_t units;
} network;

static void set_tensor(nsdf_tensor_desc *t, uint32_t rows, uint32_t cols) {
    memset(t, 0, sizeof *t);
    t->rows = rows;
    t->cols = cols;
    nsdf_tensor_layout(t);
}

static network new_network(uint32_t units) {
    network n;
    memset(&n, 0, sizeof n);
    nsdf_network_desc *d = &n.model.desc;
    d->input = NSDF_INPUT_XYZT;
    d->time_scale = d->value_scale = 1.0f;
    d->layer_count = 2;
    d->layers[0] = (nsdf_layer_desc){units, NSDF_ACT_RELU, 0.0f};
    d->layers[1] = (nsdf_layer_desc){1, NSDF_ACT_IDENTITY, 0.0f};
    d->list.count = 4;
    set_tensor(&d->list.tensors[0], units, 4);
    set_tensor(&d->list.tensors[1], units, 1);
    set_tensor(&d->list.tensors[2], 1, units);
    set_tensor(&d->list.tensors[3], 1, 1);
    nsdf_model_layout(&n.model);
    return n;
}

/* Adds factor * relu(direction * coordinate). */
static void add_unit(network *n, int coordinate, float direction, float factor) {
    const uint32_t unit = n->units++;
    n->parameters[n->model.array_offset[0][0] + 4 * (size_t)unit + (size_t)coordinate] = direction;
    n->parameters[n->model.array_offset[2][0] + unit] = factor;
}

static void set_constant(network *n, float c) {
    n->parameters[n->model.array_offset[3][0]] = c;
}

/* f = z - height */
static network plane_network(float height) {
    network n = new_network(2);
    add_unit(&n, 2, 1.0f, 1.0f);
    add_unit(&n, 2, -1.0f, -1.0f);
    set_constant(&n, -height);
    return n;
}

/* f = |x| + |y| + |z| - radius - growth * t */
static network octahedron_network(float radius, float growth) {
    network n = new_network(7);
    for (int k = 0; k < 3; k++) {
        add_unit(&n, k, 1.0f, 1.0f);
        add_unit(&n, k, -1.0f, 1.0f);
    }
    add_unit(&n, 3, 1.0f, -growth);
    set_constant(&n, -radius);
    return n;
}

/* |x| + |y| + |z| = 1/4 */
static nsdf_surface octahedron(void) {
    const double radius = 0.25;
    nsdf_surface s = shape_empty();
    for (int i = 0; i < 6; i++)
        (void)shape_vertex(&s, i / 2 == 0 ? (i % 2 ? -radius : radius) : 0.0,
                           i / 2 == 1 ? (i % 2 ? -radius : radius) : 0.0,
                           i / 2 == 2 ? (i % 2 ? -radius : radius) : 0.0);
    for (uint32_t i = 0; i < 8; i++) {
        const uint32_t x = i & 1, y = 2 + (i >> 1 & 1), z = 4 + (i >> 2), odd = (x + y + z) % 2;
        shape_triangle(&s, x, odd ? z : y, odd ? y : z);
    }
    return s;
}

/* [-0.4, 0.4] x [-0.4, 0.4] x [-0.8, 0] */
static nsdf_surface box_below(void) {
    nsdf_surface s = shape_cube(0.4);
    for (size_t i = 0; i < 8; i++)
        s.positions[3 * i + 2] -= 0.4f;
    return s;
}

/* One search over frames of one surface; the domain is +-half along x and y, +-0.3 along z. */
typedef struct search {
    nsdf_frame frames[MAX_FRAMES];
    nsdf_sample_set hard[MAX_FRAMES];
    uint32_t count, workers, resolution;
    uint64_t seed;
    float half;
} search;

static search new_search(nsdf_surface (*make)(void), nsdf_sign_rule sign, uint32_t count) {
    search s;
    memset(&s, 0, sizeof s);
    s.count = count;
    s.workers = 1;
    s.resolution = RESOLUTION;
    s.seed = 1;
    s.half = 0.35f;
    for (uint32_t i = 0; i < count; i++)
        s.frames[i] = (nsdf_frame){.number = i, .surface = make(), .sign = sign};
    return s;
}

static void free_search(search *s) {
    for (uint32_t i = 0; i < s->count; i++) {
        nsdf_surface_free(&s->frames[i].surface);
        nsdf_sample_set_free(&s->hard[i]);
    }
}

static uint64_t find(search *s, const network *n) {
    static const double u[MAX_FRAMES] = {0.0, 1.0};
    nsdf_fit_scratch *scratch[MAX_WORKERS] = {NULL};
    nsdf_workers *workers = nsdf_workers_create(s->workers);
    const nsdf_frames frames = {s->frames, s->count, s->count, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, 0};
    uint64_t found = 99999999;
    assert_non_null(workers);
    for (uint32_t i = 0; i < s->workers; i++)
        assert_non_null(scratch[i] = nsdf_fit_scratch_create(&n->model));
    const nsdf_stray_job job = {.model = &n->model,
                                .kernels = nsdf_fit_kernels_select(),
                                .scratch = scratch,
                                .parameters = n->parameters,
                                .frames = &frames,
                                .u = u,
                                .domain_min = {-s->half, -s->half, -0.3f},
                                .domain_max = {s->half, s->half, 0.3f},
                                .resolution = s->resolution,
                                .seed = s->seed,
                                .workers = workers,
                                .hard = s->hard};
    assert_int_equal(nsdf_find_strays(&job, &found), 0);
    for (uint32_t i = 0; i < s->workers; i++)
        nsdf_fit_scratch_free(scratch[i]);
    nsdf_workers_free(workers);
    return found;
}

static void assert_true_distances(const search *s, uint32_t frame) {
    const nsdf_sample_set *hard = &s->hard[frame];
    for (size_t i = 0; i < hard->count; i++) {
        const float p[3] = {hard->x[i], hard->y[i], hard->z[i]};
        assert_true(fabs((double)hard->d[i] - exact_signed(&s->frames[frame].surface, p)) < 1e-6);
    }
}

/* ---- Tests ---------------------------------------------------------------------------------------------- */

static void test_a_plane_on_a_flat_face_is_no_stray(void **state) {
    const network n = plane_network(0.0f);
    search s = new_search(box_below, NSDF_SIGN_PSEUDO_NORMAL, 1);
    (void)state;
    assert_true(find(&s, &n) == 0);
    assert_int_equal(s.hard[0].count, 0);
    free_search(&s);
}

/* Every vertical edge of the search grid that crosses the plane counts once. */
static void test_a_plane_away_from_the_surface_is_found_everywhere(void **state) {
    const network n = plane_network(0.15f);
    search s = new_search(box_below, NSDF_SIGN_PSEUDO_NORMAL, 1);
    (void)state;
    const uint64_t found = find(&s, &n);
    /* the grid is shifted, and may reach over the domain by two cells */
    assert_true(found >= RESOLUTION * RESOLUTION && found <= (RESOLUTION + 3) * (RESOLUTION + 3));
    assert_true(s.hard[0].count % 3 == 0 && s.hard[0].count >= 300 && s.hard[0].count <= 3 * found);
    assert_true_distances(&s, 0);
    for (size_t i = 0; i < s.hard[0].count; i += 3) { /* on the plane; two more points around each */
        assert_true(fabsf(s.hard[0].z[i] - 0.15f) < 1e-5f);
        assert_true(fabsf(s.hard[0].d[i] - 0.15f) < 1e-5f);
        for (size_t j = i + 1; j < i + 3; j++)
            assert_true(fabsf(s.hard[0].x[j] - s.hard[0].x[i]) < 6.0f * 0.7f / RESOLUTION);
    }
    free_search(&s);
}

/* An octahedron that is off by e lies e / sqrt 3 beside the faces, and e off at the corners. */
static void test_crossings_within_the_tolerance_are_no_strays(void **state) {
    static const float off[] = {0.0f, 0.7f, -0.7f, 2.5f, -2.5f}; /* tolerances */
    (void)state;
    for (int i = 0; i < 5; i++) {
        const network n = octahedron_network(0.25f + off[i] * NSDF_STRAY_TOLERANCE, 0.0f);
        search s = new_search(octahedron, NSDF_SIGN_PSEUDO_NORMAL, 1);
        assert_int_equal(find(&s, &n) > 0, i >= 3);
        assert_int_equal(s.hard[0].count > 0, i >= 3);
        assert_true_distances(&s, 0);
        free_search(&s);
    }
}

static void test_strays_belong_to_their_frame(void **state) {
    const network n = octahedron_network(0.25f, 0.08f); /* right at time 0, too large at time 1 */
    search s = new_search(octahedron, NSDF_SIGN_PSEUDO_NORMAL, 2);
    (void)state;
    assert_true(find(&s, &n) > 100);
    assert_int_equal(s.hard[0].count, 0);
    assert_true(s.hard[1].count >= 300);
    assert_true_distances(&s, 1);
    for (size_t i = 0; i < s.hard[1].count; i += 3)
        assert_true(s.hard[1].d[i] > 0.02f); /* outside, where the network says surface */
    free_search(&s);
}

static void test_hard_points_are_kept_up_to_a_limit(void **state) {
    const network n = plane_network(0.15f);
    search s = new_search(box_below, NSDF_SIGN_PSEUDO_NORMAL, 1);
    size_t before = 0;
    (void)state;
    for (s.seed = 1; s.seed <= 30; s.seed++) {
        (void)find(&s, &n);
        assert_true(s.hard[0].count > before || before == NSDF_MOST_HARD);
        assert_true(s.hard[0].count <= NSDF_MOST_HARD);
        before = s.hard[0].count;
    }
    assert_int_equal(before, NSDF_MOST_HARD);
    assert_true_distances(&s, 0);
    free_search(&s);
}

static void test_results_do_not_depend_on_the_threads_but_on_the_seed(void **state) {
    const network n = octahedron_network(0.3f, 0.08f);
    search s[3];
    uint64_t found[3];
    (void)state;
    for (int k = 0; k < 3; k++) {
        s[k] = new_search(octahedron, NSDF_SIGN_PSEUDO_NORMAL, 2);
        s[k].workers = k == 1 ? 3 : 1;
        s[k].seed = k == 2 ? 2 : 1;
        found[k] = find(&s[k], &n);
    }
    assert_true(found[0] == found[1] && found[0] > 0);
    for (int i = 0; i < 2; i++) {
        const nsdf_sample_set *a = &s[0].hard[i], *b = &s[1].hard[i];
        assert_int_equal(a->count, b->count);
        assert_memory_equal(a->x, b->x, a->count * sizeof *a->x);
        assert_memory_equal(a->d, b->d, a->count * sizeof *a->d);
    }
    assert_memory_not_equal(s[0].hard[1].x, s[2].hard[1].x, 100);
    for (int k = 0; k < 3; k++)
        free_search(&s[k]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_plane_on_a_flat_face_is_no_stray),
        cmocka_unit_test(test_a_plane_away_from_the_surface_is_found_everywhere),
        cmocka_unit_test(test_crossings_within_the_tolerance_are_no_strays),
        cmocka_unit_test(test_strays_belong_to_their_frame),
        cmocka_unit_test(test_hard_points_are_kept_up_to_a_limit),
        cmocka_unit_test(test_results_do_not_depend_on_the_threads_but_on_the_seed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
