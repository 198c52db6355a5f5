/* The sample shapes: closed oriented manifolds on the analytic surface, different from frame to frame. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "shapes.h"

static const double pi = 3.141592653589793;

typedef struct edge {
    uint32_t low, high;
    int direction; /* +1 from low to high */
} edge;

static int compare_edges(const void *a, const void *b) {
    const edge *x = a, *y = b;
    if (x->low != y->low)
        return x->low < y->low ? -1 : 1;
    return x->high < y->high ? -1 : x->high > y->high;
}

static edge *sorted_edges(const nsdf_implicit_mesh *mesh) {
    edge *edges = malloc(3 * mesh->triangle_count * sizeof *edges);
    assert_non_null(edges);
    for (size_t i = 0; i < 3 * mesh->triangle_count; i++) {
        uint32_t a = mesh->triangles[i], b = mesh->triangles[i % 3 == 2 ? i - 2 : i + 1];
        assert_true(a < mesh->vertex_count && b < mesh->vertex_count && a != b);
        edges[i] = a < b ? (edge){a, b, 1} : (edge){b, a, -1};
    }
    qsort(edges, 3 * mesh->triangle_count, sizeof *edges, compare_edges);
    return edges;
}

/* Every edge must be used by exactly two triangles, once in each direction. */
static void assert_closed_and_oriented(const nsdf_implicit_mesh *mesh) {
    assert_true(mesh->triangle_count > 0);
    edge *edges = sorted_edges(mesh);
    for (size_t i = 0; i < 3 * mesh->triangle_count; i += 2) {
        assert_int_equal(compare_edges(&edges[i], &edges[i + 1]), 0);
        assert_int_equal(edges[i].direction + edges[i + 1].direction, 0);
        if (i)
            assert_int_not_equal(compare_edges(&edges[i - 1], &edges[i]), 0);
    }
    free(edges);
}

/* The triangles around each vertex must form one fan: as many corners as a walk around it visits. */
static void assert_vertices_are_manifold(const nsdf_implicit_mesh *mesh) {
    uint32_t *next =
        malloc(3 * mesh->triangle_count * sizeof *next); /* by corner: the corner across, at the same vertex */
    uint32_t *corners = calloc(mesh->vertex_count, sizeof *corners), *start = calloc(mesh->vertex_count, sizeof *start);
    edge *edges = sorted_edges(mesh);
    assert_true(next && corners && start);
    for (uint32_t i = 0; i < 3 * mesh->triangle_count; i++) {
        corners[mesh->triangles[i]]++;
        start[mesh->triangles[i]] = i;
    }
    /* out[e]: the corner whose outgoing edge is the directed edge e; found by hashing through the sorted list */
    uint32_t *outgoing = malloc(3 * mesh->triangle_count * sizeof *outgoing);
    assert_non_null(outgoing);
    for (uint32_t i = 0; i < 3 * mesh->triangle_count; i++) {
        uint32_t a = mesh->triangles[i], b = mesh->triangles[i % 3 == 2 ? i - 2 : i + 1];
        edge key = {a < b ? a : b, a < b ? b : a, 0};
        const edge *found = bsearch(&key, edges, 3 * mesh->triangle_count, sizeof *edges, compare_edges);
        size_t pair = (size_t)(found - edges) / 2;
        outgoing[2 * pair + (a < b ? 0 : 1)] = i;
    }
    for (uint32_t i = 0; i < 3 * mesh->triangle_count; i++) {
        uint32_t a = mesh->triangles[i], c = mesh->triangles[i % 3 == 0 ? i + 2 : i - 1];
        edge key = {a < c ? a : c, a < c ? c : a, 0};
        const edge *found = bsearch(&key, edges, 3 * mesh->triangle_count, sizeof *edges, compare_edges);
        next[i] = outgoing[2 * ((size_t)(found - edges) / 2) + (a < c ? 0 : 1)];
    }
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        uint32_t visited = 0, corner = start[v];
        assert_true(corners[v] >= 3);
        do {
            assert_int_equal(mesh->triangles[corner], v);
            corner = next[corner];
            visited++;
        } while (corner != start[v] && visited <= corners[v]);
        assert_int_equal(visited, corners[v]);
    }
    free(outgoing);
    free(edges);
    free(next);
    free(corners);
    free(start);
}

/* Sum over triangles of the signed volume to the origin. */
static double volume(const nsdf_implicit_mesh *mesh) {
    double sum = 0;
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *t = mesh->triangles + 3 * i;
        const double *a = mesh->positions + 3 * t[0], *b = mesh->positions + 3 * t[1], *c = mesh->positions + 3 * t[2];
        sum += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
               a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return sum / 6;
}

static uint32_t find_root(uint32_t *parent, uint32_t v) {
    while (parent[v] != v)
        v = parent[v] = parent[parent[v]];
    return v;
}

static uint32_t component_count(const nsdf_implicit_mesh *mesh) {
    uint32_t *parent = malloc(mesh->vertex_count * sizeof *parent), count = 0;
    assert_non_null(parent);
    for (uint32_t v = 0; v < mesh->vertex_count; v++)
        parent[v] = v;
    for (size_t i = 0; i < 3 * mesh->triangle_count; i++)
        parent[find_root(parent, mesh->triangles[i])] = find_root(parent, mesh->triangles[i - i % 3]);
    for (uint32_t v = 0; v < mesh->vertex_count; v++)
        count += parent[v] == v;
    free(parent);
    return count;
}

static long euler_number(const nsdf_implicit_mesh *mesh) {
    return (long)mesh->vertex_count - (long)(mesh->triangle_count / 2);
}

static double ball_value(const void *user, const double p[3]) {
    return sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) - *(const double *)user;
}

static nsdf_implicit_field ball_field(const double *radius) {
    double r = *radius * 1.1;
    return (nsdf_implicit_field){radius, ball_value, 1.0, {-r, -r, -r}, {r, r, r}};
}

static void make_frame(const char *name, double seconds, uint64_t seed, double resolution, nsdf_implicit_mesh *mesh) {
    const nsdf_shape *shape = nsdf_shape_find(name);
    nsdf_shape_pose *pose = calloc(1, sizeof *pose);
    assert_true(shape && pose);
    shape->pose(seconds, pose);
    nsdf_implicit_field field = nsdf_shape_field(shape, pose);
    assert_int_equal(nsdf_implicit_extract(&field, nsdf_shape_extent(shape) / resolution, seed, mesh), 0);
    free(pose);
}

static void ball_has_the_volume_and_topology_of_a_ball(void **state) {
    (void)state;
    const double radius = 0.8;
    nsdf_implicit_field field = ball_field(&radius);
    nsdf_implicit_mesh mesh = {0};
    for (uint64_t seed = 0; seed < 20; seed++) {
        assert_int_equal(nsdf_implicit_extract(&field, 0.1, seed, &mesh), 0);
        assert_closed_and_oriented(&mesh);
        assert_vertices_are_manifold(&mesh);
        assert_int_equal(euler_number(&mesh), 2);
        assert_int_equal(component_count(&mesh), 1);
        double expected = 4 * pi / 3 * radius * radius * radius;
        assert_true(fabs(volume(&mesh) / expected - 1) < 0.02);
    }
    nsdf_implicit_mesh_free(&mesh);
}

static void every_shape_is_a_closed_manifold_at_every_time(void **state) {
    (void)state;
    size_t count;
    const nsdf_shape *shapes = nsdf_shapes(&count);
    nsdf_implicit_mesh mesh = {0};
    for (size_t s = 0; s < count; s++)
        for (int frame = 0; frame < 12; frame++) {
            make_frame(shapes[s].name, frame * 0.173, (uint64_t)frame, 40, &mesh);
            assert_closed_and_oriented(&mesh);
            assert_vertices_are_manifold(&mesh);
            assert_true(volume(&mesh) > 0);
        }
    nsdf_implicit_mesh_free(&mesh);
}

static void vertices_lie_on_the_analytic_surface(void **state) {
    (void)state;
    size_t count;
    const nsdf_shape *shapes = nsdf_shapes(&count);
    nsdf_implicit_mesh mesh = {0};
    nsdf_shape_pose *pose = calloc(1, sizeof *pose);
    assert_non_null(pose);
    for (size_t s = 0; s < count; s++) {
        double spacing = nsdf_shape_extent(&shapes[s]) / 40;
        memset(pose, 0, sizeof *pose);
        shapes[s].pose(0.4, pose);
        make_frame(shapes[s].name, 0.4, 7, 40, &mesh);
        for (size_t v = 0; v < mesh.vertex_count; v++) /* the margin at an edge's end is 0.004 of its length */
            assert_true(fabs(shapes[s].value(pose, mesh.positions + 3 * v)) < 0.006 * spacing);
    }
    free(pose);
    nsdf_implicit_mesh_free(&mesh);
}

static uint64_t random_state = 12345;

static double random_between(double low, double high) {
    random_state = random_state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return low + (high - low) * (double)(random_state >> 11) * 0x1p-53;
}

static void shapes_keep_their_lipschitz_constant_and_their_box(void **state) {
    (void)state;
    size_t count;
    const nsdf_shape *shapes = nsdf_shapes(&count);
    nsdf_shape_pose *pose = calloc(1, sizeof *pose);
    assert_non_null(pose);
    for (size_t s = 0; s < count; s++)
        for (int trial = 0; trial < 20000; trial++) {
            double p[3], q[3], step = 0;
            if (trial % 200 == 0) {
                memset(pose, 0, sizeof *pose);
                shapes[s].pose(random_between(0, 10), pose);
            }
            for (int c = 0; c < 3; c++) {
                p[c] = random_between(shapes[s].box_min[c], shapes[s].box_max[c]);
                q[c] = p[c] + random_between(-0.05, 0.05);
                step += (q[c] - p[c]) * (q[c] - p[c]);
            }
            double fp = shapes[s].value(pose, p), fq = shapes[s].value(pose, q);
            assert_true(fabs(fp - fq) <= shapes[s].lipschitz * sqrt(step) + 1e-12);
            p[trial % 3] = trial % 2 ? shapes[s].box_min[trial % 3] : shapes[s].box_max[trial % 3];
            assert_true(shapes[s].value(pose, p) > 0);
        }
    free(pose);
}

static void connectivity_changes_from_frame_to_frame_and_not_from_run_to_run(void **state) {
    (void)state;
    nsdf_implicit_mesh a = {0}, b = {0}, again = {0};
    make_frame("walker", 0.5, 1, 40, &a);
    make_frame("walker", 0.5, 2, 40, &b);
    make_frame("walker", 0.5, 1, 40, &again);
    size_t common = a.triangle_count < b.triangle_count ? a.triangle_count : b.triangle_count;
    assert_true(memcmp(a.triangles, b.triangles, 3 * common * sizeof *a.triangles) != 0);
    assert_int_equal(a.vertex_count, again.vertex_count);
    assert_memory_equal(a.positions, again.positions, 3 * a.vertex_count * sizeof *a.positions);
    assert_memory_equal(a.triangles, again.triangles, 3 * a.triangle_count * sizeof *a.triangles);
    nsdf_implicit_mesh_free(&a);
    nsdf_implicit_mesh_free(&b);
    nsdf_implicit_mesh_free(&again);
}

static void metaballs_merge_and_split(void **state) {
    (void)state;
    nsdf_implicit_mesh mesh = {0};
    uint32_t fewest = UINT32_MAX, most = 0;
    for (int frame = 0; frame < 48; frame++) {
        make_frame("metaballs", frame / 24.0, (uint64_t)frame, 40, &mesh);
        uint32_t components = component_count(&mesh);
        fewest = components < fewest ? components : fewest;
        most = components > most ? components : most;
    }
    assert_true(fewest < most);
    nsdf_implicit_mesh_free(&mesh);
}

static void walker_is_one_body_and_repeats_every_second(void **state) {
    (void)state;
    nsdf_implicit_mesh first = {0}, second = {0};
    make_frame("walker", 0.25, 3, 64, &first);
    make_frame("walker", 1.25, 3, 64, &second);
    assert_int_equal(component_count(&first), 1);
    assert_int_equal(first.vertex_count, second.vertex_count);
    double lowest = INFINITY, highest = -INFINITY;
    for (size_t v = 0; v < first.vertex_count; v++) {
        lowest = fmin(lowest, first.positions[3 * v + 1]);
        highest = fmax(highest, first.positions[3 * v + 1]);
    }
    assert_true(fabs(lowest) < 0.03);         /* the standing foot is on the ground */
    assert_true(fabs(highest - 1.75) < 0.06); /* the crown */
    nsdf_implicit_mesh_free(&first);
    nsdf_implicit_mesh_free(&second);
}

static void knot_is_one_torus(void **state) {
    (void)state;
    nsdf_implicit_mesh mesh = {0};
    for (int frame = 0; frame < 12; frame++) {
        make_frame("knot", frame * 0.21, (uint64_t)frame, 64, &mesh);
        assert_int_equal(component_count(&mesh), 1);
        assert_int_equal(euler_number(&mesh), 0);
    }
    nsdf_implicit_mesh_free(&mesh);
}

static void too_fine_a_lattice_is_refused(void **state) {
    (void)state;
    const double radius = 1;
    nsdf_implicit_field field = ball_field(&radius);
    nsdf_implicit_mesh mesh = {0};
    assert_int_equal(nsdf_implicit_extract(&field, 1e-7, 0, &mesh), -1);
    assert_int_equal(mesh.triangle_count, 0);
    nsdf_implicit_mesh_free(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ball_has_the_volume_and_topology_of_a_ball),
        cmocka_unit_test(every_shape_is_a_closed_manifold_at_every_time),
        cmocka_unit_test(vertices_lie_on_the_analytic_surface),
        cmocka_unit_test(shapes_keep_their_lipschitz_constant_and_their_box),
        cmocka_unit_test(connectivity_changes_from_frame_to_frame_and_not_from_run_to_run),
        cmocka_unit_test(metaballs_merge_and_split),
        cmocka_unit_test(walker_is_one_body_and_repeats_every_second),
        cmocka_unit_test(knot_is_one_torus),
        cmocka_unit_test(too_fine_a_lattice_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
