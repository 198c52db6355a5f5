/* The mesher on analytic fields: closed oriented 2-manifolds, near the true surface, the same however they are made. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mesher.h"

/* ---- Fields ------------------------------------------------------------------------------------------------ */

typedef double (*distance_fn)(const double p[3]);

static double length3(double x, double y, double z) {
    return sqrt(x * x + y * y + z * z);
}

static double sphere(const double p[3]) {
    return length3(p[0] - 0.013, p[1] + 0.021, p[2] - 0.007) - 0.31;
}

static double box(const double p[3]) {
    const double half[3] = {0.3, 0.2, 0.25};
    double out = 0, in = -1;
    for (int a = 0; a < 3; a++) {
        const double d = fabs(p[a] - 0.003) - half[a];
        out += d > 0 ? d * d : 0;
        in = fmax(in, d);
    }
    return out > 0 ? sqrt(out) : in;
}

static double torus(const double p[3]) {
    return hypot(hypot(p[0], p[1]) - 0.28, p[2] - 0.01) - 0.11;
}

static double two_spheres(const double p[3]) {
    return fmin(length3(p[0] - 0.25, p[1], p[2]) - 0.17, length3(p[0] + 0.25, p[1] - 0.02, p[2]) - 0.19);
}

/* The sphere, a bubble of radius 0.06 in it, and a speck of radius 0.04 beside it. */
static double speck_and_bubble(const double p[3]) {
    const double bubble = length3(p[0] - 0.05, p[1], p[2] + 0.06) - 0.06,
                 speck = length3(p[0], p[1] - 0.43, p[2]) - 0.04;
    return fmin(fmax(sphere(p), -bubble), speck);
}

static double gyroid(const double p[3]) {
    const double k = 14;
    return (sin(k * p[0]) * cos(k * p[1]) + sin(k * p[1]) * cos(k * p[2]) + sin(k * p[2]) * cos(k * p[0])) / (2 * k);
}

static double waves(const double p[3]) {
    return 0.03 * (sin(17 * p[0] + 3 * p[1] + 1) + sin(13 * p[1] - 9 * p[2] + 2) + sin(19 * p[2] + 7 * p[0]) +
                   sin(29 * p[0] - 31 * p[1] + 23 * p[2]));
}

/* Another sign at every corner, whatever the grid. */
static double random_signs(const double p[3]) {
    uint64_t h = 88172645463325252u;
    for (int a = 0; a < 3; a++) {
        h ^= (uint64_t)(int64_t)llround(p[a] * 1e6);
        h *= 0x9e3779b97f4a7c15u;
        h ^= h >> 29;
    }
    return ((double)(h >> 11) * 0x1p-53 - 0.5) * 0.02;
}

static double nowhere(const double p[3]) {
    return sphere(p) + 5;
}

static double everywhere(const double p[3]) {
    return sphere(p) - 5;
}

static double not_a_number(const double p[3]) {
    return p[0] > 0.05 ? (double)NAN : p[1] > 0.1 ? -(double)INFINITY : sphere(p);
}

static void evaluate_field(void *user, uint32_t worker, size_t count, const float *const xyz[3], float *value,
                           float *const grad[3]) {
    const distance_fn f = *(const distance_fn *)user;
    const double e = 1e-5;
    (void)worker;
    for (size_t i = 0; i < count; i++) {
        double p[3] = {(double)xyz[0][i], (double)xyz[1][i], (double)xyz[2][i]};
        value[i] = (float)f(p);
        for (int a = 0; a < 3 && grad[0]; a++) {
            const double x = p[a];
            p[a] = x + e;
            const double high = f(p);
            p[a] = x - e;
            grad[a][i] = (float)((high - f(p)) / (2 * e));
            p[a] = x;
        }
    }
}

/* ---- Running ----------------------------------------------------------------------------------------------- */

/* A slab through the domain, whose faces are nearly corners of a grid of 32 cells; too steep for a bound of 1 at x < 0,
 * where all centres of cubes are too far from it. */
static double steep_slab(const double p[3]) {
    return (fabs(p[1]) - 0.2515) * (p[0] < 0 ? 3 : 1);
}

typedef struct bench {
    nsdf_memory memory;
    nsdf_tasks *tasks;
    nsdf_mesher *mesher;
    nsdf_mesh_storage mesh;
    distance_fn f;
    nsdf_mesher_job job;
} bench;

static void bench_start(bench *b, uint32_t threads) {
    memset(b, 0, sizeof *b);
    nsdf_memory_init(&b->memory, NULL, (uint64_t)1 << 30);
    assert_int_equal(nsdf_tasks_create(&b->memory, threads, NULL, &b->tasks), NSDF_OK);
    assert_int_equal(nsdf_mesher_create(&b->memory, b->tasks, &b->mesher), NSDF_OK);
    for (int a = 0; a < 3; a++) {
        b->job.domain_min[a] = -0.5f;
        b->job.domain_max[a] = 0.5f;
    }
    b->job.bound = 1;
    b->job.projection = 2;
    b->job.normals = 1;
    b->job.scale = 1;
    b->job.resolution = 32;
}

static void bench_end(bench *b) {
    nsdf_mesh_storage_free(&b->memory, &b->mesh);
    nsdf_mesher_free(&b->mesher);
    nsdf_tasks_free(&b->tasks);
    assert_int_equal(b->memory.used, 0);
}

static nsdf_status bench_run(bench *b, distance_fn f) {
    b->f = f;
    b->job.field.user = &b->f;
    b->job.field.evaluate = evaluate_field;
    return nsdf_mesher_run(b->mesher, &b->job, &b->memory, &b->mesh);
}

/* ---- What a good mesh is ----------------------------------------------------------------------------------- */

typedef struct corner {
    uint32_t vertex, next, previous; /* of a triangle */
} corner;

static int compare_corners(const void *a, const void *b) {
    const corner *p = a, *q = b;
    if (p->vertex != q->vertex)
        return p->vertex < q->vertex ? -1 : 1;
    return p->next < q->next ? -1 : p->next > q->next;
}

static corner *sorted_corners(const nsdf_mesh_storage *mesh) {
    const size_t n = 3 * (size_t)mesh->triangle_count;
    corner *corners = malloc((n + 1) * sizeof *corners);
    assert_non_null(corners);
    for (size_t i = 0; i < n; i++) {
        const uint32_t *t = mesh->indices + i / 3 * 3;
        corners[i] = (corner){t[i % 3], t[(i + 1) % 3], t[(i + 2) % 3]};
        assert_true(corners[i].vertex < mesh->vertex_count);
        assert_true(corners[i].vertex != corners[i].next);
    }
    qsort(corners, n, sizeof *corners, compare_corners);
    return corners;
}

static size_t find_corner(const corner *corners, size_t count, uint32_t vertex, uint32_t next) {
    const corner key = {vertex, next, 0};
    const corner *found = bsearch(&key, corners, count, sizeof key, compare_corners);
    assert_non_null(found); /* else an edge has no other side */
    return (size_t)(found - corners);
}

/* Each directed edge occurs once and has its opposite; the triangles round each vertex form one ring; every vertex is
 * used.  Returns the Euler number. */
static int64_t assert_closed_manifold(const nsdf_mesh_storage *mesh) {
    const size_t n = 3 * (size_t)mesh->triangle_count;
    corner *corners = sorted_corners(mesh);
    uint32_t vertices = 0;
    for (size_t first = 0, last; first < n; first = last, vertices++) {
        for (last = first + 1; last < n && corners[last].vertex == corners[first].vertex; last++)
            assert_true(corners[last].next != corners[last - 1].next);
        size_t ring = 0, at = first;
        do {
            at = find_corner(corners, n, corners[at].vertex, corners[at].previous);
            ring++;
        } while (at != first && ring <= last - first);
        assert_int_equal(ring, last - first);
    }
    free(corners);
    assert_int_equal(vertices, mesh->vertex_count);
    assert_int_equal(n % 2, 0);
    return (int64_t)vertices - (int64_t)(n / 2) + (int64_t)mesh->triangle_count;
}

static void measure(const nsdf_mesh_storage *mesh, double *area, double *volume) {
    *area = *volume = 0;
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        const float *p[3];
        for (int k = 0; k < 3; k++)
            p[k] = mesh->positions + 3 * (size_t)mesh->indices[3 * (size_t)i + (size_t)k];
        double u[3], v[3], c[3];
        for (int a = 0; a < 3; a++) {
            u[a] = (double)p[1][a] - (double)p[0][a];
            v[a] = (double)p[2][a] - (double)p[0][a];
        }
        for (int a = 0; a < 3; a++) {
            const int s = (a + 1) % 3, t = (a + 2) % 3;
            c[a] = u[s] * v[t] - u[t] * v[s];
            *volume += (double)p[0][a] * c[a] / 6;
        }
        *area += length3(c[0], c[1], c[2]) / 2;
    }
}

static double largest_distance(const bench *b) {
    double most = 0;
    for (uint32_t i = 0; i < b->mesh.vertex_count; i++) {
        const float *x = b->mesh.positions + 3 * (size_t)i;
        const double p[3] = {(double)x[0], (double)x[1], (double)x[2]};
        most = fmax(most, fabs(b->f(p)));
    }
    return most;
}

static void assert_same_mesh(const nsdf_mesh_storage *a, const nsdf_mesh_storage *b) {
    assert_int_equal(a->vertex_count, b->vertex_count);
    assert_int_equal(a->triangle_count, b->triangle_count);
    assert_memory_equal(a->positions, b->positions, a->vertex_count * 3 * sizeof(float));
    assert_memory_equal(a->normals, b->normals, a->vertex_count * 3 * sizeof(float));
    assert_memory_equal(a->indices, b->indices, a->triangle_count * 3 * sizeof(uint32_t));
}

/* ---- Tests ------------------------------------------------------------------------------------------------- */

static void shapes_have_their_area_volume_and_euler_number(void **state) {
    (void)state;
    const double pi = acos(-1.0);
    const struct {
        distance_fn f;
        double area, volume;
        int64_t euler;
        double area_tolerance; /* marching cubes cut sharp edges off: half a cell along each edge of the box */
    } shapes[] = {
        {sphere, 4 * pi * 0.31 * 0.31, 4 * pi / 3 * 0.31 * 0.31 * 0.31, 2, 0.01},
        {box, 8 * (0.3 * 0.2 + 0.2 * 0.25 + 0.3 * 0.25), 8 * 0.3 * 0.2 * 0.25, 2, 0.03},
        {torus, 4 * pi * pi * 0.28 * 0.11, 2 * pi * pi * 0.28 * 0.11 * 0.11, 0, 0.01},
        {two_spheres, 4 * pi * (0.17 * 0.17 + 0.19 * 0.19), 4 * pi / 3 * (0.17 * 0.17 * 0.17 + 0.19 * 0.19 * 0.19), 4,
         0.01},
    };
    bench b;
    bench_start(&b, 1);
    b.job.resolution = 64;
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        double area, volume;
        assert_int_equal(bench_run(&b, shapes[i].f), NSDF_OK);
        assert_int_equal(assert_closed_manifold(&b.mesh), shapes[i].euler);
        measure(&b.mesh, &area, &volume);
        assert_true(fabs(area / shapes[i].area - 1) < shapes[i].area_tolerance);
        assert_true(fabs(volume / shapes[i].volume - 1) < 0.01);
    }
    bench_end(&b);
}

static void vertices_end_on_the_zero_set_with_its_normals(void **state) {
    (void)state;
    bench b;
    bench_start(&b, 1);
    b.job.resolution = 64;
    assert_int_equal(bench_run(&b, sphere), NSDF_OK);
    assert_true(b.mesh.has_normals);
    assert_true(largest_distance(&b) < 1e-3 / 64);
    for (uint32_t i = 0; i < b.mesh.vertex_count; i++) {
        const float *x = b.mesh.positions + 3 * (size_t)i, *n = b.mesh.normals + 3 * (size_t)i;
        const double d[3] = {(double)x[0] - 0.013, (double)x[1] + 0.021, (double)x[2] - 0.007};
        const double along = (d[0] * (double)n[0] + d[1] * (double)n[1] + d[2] * (double)n[2]) / 0.31;
        assert_true(along > 0.9999 && along < 1.0001);
    }
    b.job.projection = 0;
    assert_int_equal(bench_run(&b, sphere), NSDF_OK);
    assert_true(largest_distance(&b) > 1e-3 / 64); /* so the steps did it */
    bench_end(&b);
}

static void no_vertex_moves_further_than_half_a_cell(void **state) {
    (void)state;
    bench plain, moved;
    bench_start(&plain, 1);
    bench_start(&moved, 1);
    plain.job.resolution = moved.job.resolution = 20;
    plain.job.projection = 0;
    moved.job.projection = 8;
    assert_int_equal(bench_run(&plain, waves), NSDF_OK);
    assert_int_equal(bench_run(&moved, waves), NSDF_OK);
    assert_int_equal(plain.mesh.vertex_count, moved.mesh.vertex_count);
    assert_true(largest_distance(&moved) <= largest_distance(&plain));
    for (uint32_t i = 0; i < plain.mesh.vertex_count; i++) {
        const float *p = plain.mesh.positions + 3 * (size_t)i, *q = moved.mesh.positions + 3 * (size_t)i;
        const double d = length3((double)(p[0] - q[0]), (double)(p[1] - q[1]), (double)(p[2] - q[2]));
        assert_true(d < 0.5001 / 20);
    }
    bench_end(&plain);
    bench_end(&moved);
}

static void sparse_equals_dense_for_distances(void **state) {
    (void)state;
    const distance_fn shapes[] = {sphere, box, torus, two_spheres};
    bench sparse, dense;
    bench_start(&sparse, 1);
    bench_start(&dense, 1);
    dense.job.dense = 1;
    sparse.job.bound = 1.001f;
    for (uint32_t resolution = 2; resolution < 60; resolution += 7) {
        sparse.job.resolution = dense.job.resolution = resolution;
        for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
            assert_int_equal(bench_run(&sparse, shapes[i]), NSDF_OK);
            assert_int_equal(bench_run(&dense, shapes[i]), NSDF_OK);
            assert_same_mesh(&sparse.mesh, &dense.mesh);
        }
    }
    bench_end(&sparse);
    bench_end(&dense);
}

static void pieces_below_the_smallest_are_left_out(void **state) {
    (void)state;
    bench all, sphere_only;
    bench_start(&all, 2);
    bench_start(&sphere_only, 2);
    all.job.resolution = sphere_only.job.resolution = 64;
    assert_int_equal(bench_run(&sphere_only, sphere), NSDF_OK);
    assert_int_equal(bench_run(&all, speck_and_bubble), NSDF_OK);
    assert_int_equal(assert_closed_manifold(&all.mesh), 6);
    all.job.smallest_piece = 0.17f; /* the boxes' diagonals are close to 0.14, 0.21 and 1.07 */
    assert_int_equal(bench_run(&all, speck_and_bubble), NSDF_OK);
    assert_int_equal(assert_closed_manifold(&all.mesh), 4);
    all.job.smallest_piece = 0.25f;
    assert_int_equal(bench_run(&all, speck_and_bubble), NSDF_OK);
    assert_same_mesh(&all.mesh, &sphere_only.mesh);
    all.job.smallest_piece = 1.2f;
    assert_int_equal(bench_run(&all, speck_and_bubble), NSDF_OK);
    assert_int_equal(all.mesh.vertex_count, 0);
    assert_int_equal(all.mesh.triangle_count, 0);
    bench_end(&all);
    bench_end(&sphere_only);
}

static void threads_do_not_change_the_mesh(void **state) {
    (void)state;
    const distance_fn shapes[] = {torus, gyroid, random_signs};
    bench one, four;
    bench_start(&one, 1);
    bench_start(&four, 4);
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        assert_int_equal(bench_run(&one, shapes[i]), NSDF_OK);
        assert_int_equal(bench_run(&four, shapes[i]), NSDF_OK);
        assert_true(one.mesh.triangle_count > 1000);
        assert_same_mesh(&one.mesh, &four.mesh);
    }
    bench_end(&one);
    bench_end(&four);
}

static void meshes_are_closed_at_every_resolution_and_in_every_domain(void **state) {
    (void)state;
    const distance_fn shapes[] = {sphere, box, gyroid, waves, random_signs, everywhere};
    const float domains[][3] = {{0.5f, 0.5f, 0.5f}, {0.5f, 0.31f, 0.123f}, {0.07f, 0.5f, 0.001f}};
    bench b;
    bench_start(&b, 1);
    for (uint32_t resolution = 2; resolution <= 40; resolution++) {
        for (size_t d = 0; d < sizeof domains / sizeof *domains; d++) {
            for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
                double area, volume;
                b.job.resolution = resolution;
                b.job.dense = resolution % 2 == 0;
                for (int a = 0; a < 3; a++)
                    b.job.domain_max[a] = -(b.job.domain_min[a] = -domains[d][a]);
                assert_int_equal(bench_run(&b, shapes[i]), NSDF_OK);
                assert_closed_manifold(&b.mesh);
                measure(&b.mesh, &area, &volume);
                if (b.mesh.triangle_count > 0 && shapes[i] != random_signs)
                    assert_true(volume > 0);
                if (shapes[i] == everywhere)
                    assert_true(b.mesh.triangle_count > 0);
            }
        }
    }
    bench_end(&b);
}

/* A field that is negative throughout gives the domain's box, with flat sides and outward normals. */
static void surfaces_that_leave_the_domain_are_closed_at_its_border(void **state) {
    (void)state;
    double area, volume;
    bench b;
    bench_start(&b, 1);
    b.job.domain_min[1] = -0.29f;
    assert_int_equal(bench_run(&b, everywhere), NSDF_OK);
    assert_int_equal(assert_closed_manifold(&b.mesh), 2);
    measure(&b.mesh, &area, &volume);
    assert_true(fabs(volume / 0.79 - 1) < 0.01);
    for (uint32_t i = 0; i < b.mesh.vertex_count; i++) {
        const float *x = b.mesh.positions + 3 * (size_t)i, *n = b.mesh.normals + 3 * (size_t)i;
        double nearest = 1, outward = 0;
        for (int a = 0; a < 3; a++) {
            nearest = fmin(nearest, (double)fminf(x[a] - b.job.domain_min[a], b.job.domain_max[a] - x[a]));
            outward += (double)x[a] * (double)n[a];
        }
        assert_true(nearest >= 0 && nearest < 0.01 / 32);
        assert_true(outward > 0);
    }
    bench_end(&b);
}

/* The bound is a promise of the file; where it is broken parts may be missed, but what is found is closed. */
static void broken_bounds_still_give_closed_meshes(void **state) {
    (void)state;
    const float bounds[] = {0.5f, 0.2f, 0.05f, 0.01f};
    uint32_t found = 0;
    bench b;
    bench_start(&b, 2);
    for (size_t i = 0; i < sizeof bounds / sizeof *bounds; i++) {
        b.job.bound = bounds[i];
        for (b.job.resolution = 24; b.job.resolution < 60; b.job.resolution += 5) {
            assert_int_equal(bench_run(&b, torus), NSDF_OK);
            assert_closed_manifold(&b.mesh);
            assert_int_equal(bench_run(&b, waves), NSDF_OK);
            assert_closed_manifold(&b.mesh);
            found += b.mesh.triangle_count > 0;
        }
    }
    assert_true(found > 0);
    bench_end(&b);
}

/* With signs that follow from values, and with all corners evaluated at once. */
static void surfaces_are_followed_into_bricks_without_cells(void **state) {
    (void)state;
    bench sparse, dense;
    bench_start(&sparse, 2);
    bench_start(&dense, 2);
    dense.job.dense = 1;
    assert_int_equal(bench_run(&dense, steep_slab), NSDF_OK);
    for (sparse.job.field.jumps = 0; sparse.job.field.jumps < 2; sparse.job.field.jumps++) {
        assert_int_equal(bench_run(&sparse, steep_slab), NSDF_OK);
        assert_same_mesh(&sparse.mesh, &dense.mesh);
    }
    bench_end(&sparse);
    bench_end(&dense);
}

static void no_surface_gives_an_empty_mesh(void **state) {
    (void)state;
    bench b;
    bench_start(&b, 1);
    assert_int_equal(bench_run(&b, sphere), NSDF_OK);
    for (b.job.dense = 0; b.job.dense < 2; b.job.dense++) {
        assert_int_equal(bench_run(&b, nowhere), NSDF_OK);
        assert_int_equal(b.mesh.vertex_count, 0);
        assert_int_equal(b.mesh.triangle_count, 0);
    }
    bench_end(&b);
}

static void values_that_are_not_numbers_are_outside(void **state) {
    (void)state;
    bench b;
    bench_start(&b, 1);
    for (b.job.dense = 0; b.job.dense < 2; b.job.dense++) {
        assert_int_equal(bench_run(&b, not_a_number), NSDF_OK);
        assert_true(b.mesh.triangle_count > 0);
        assert_closed_manifold(&b.mesh);
        for (uint32_t i = 0; i < 3 * b.mesh.vertex_count; i++) {
            assert_true(isfinite(b.mesh.positions[i]));
            assert_true(fabsf(b.mesh.normals[i]) <= 1.0001f);
        }
    }
    bench_end(&b);
}

static void positions_are_in_world_units(void **state) {
    (void)state;
    bench plain, world;
    bench_start(&plain, 1);
    bench_start(&world, 1);
    world.job.scale = 250;
    world.job.centre[0] = -1000;
    world.job.centre[2] = 7;
    plain.job.normals = world.job.normals = 0;
    assert_int_equal(bench_run(&plain, torus), NSDF_OK);
    assert_int_equal(bench_run(&world, torus), NSDF_OK);
    assert_false(world.mesh.has_normals);
    assert_int_equal(plain.mesh.vertex_count, world.mesh.vertex_count);
    for (uint32_t i = 0; i < 3 * plain.mesh.vertex_count; i++) {
        const double expected = (double)plain.mesh.positions[i] * 250 + world.job.centre[i % 3];
        assert_true(fabs((double)world.mesh.positions[i] - expected) < 1e-4);
    }
    bench_end(&plain);
    bench_end(&world);
}

static void storage_and_scratch_are_used_again(void **state) {
    (void)state;
    bench b, fresh;
    bench_start(&b, 1);
    bench_start(&fresh, 1);
    b.job.resolution = 48;
    assert_int_equal(bench_run(&b, gyroid), NSDF_OK);
    b.job.resolution = 32;
    const uint64_t held = b.memory.used;
    const float *positions = b.mesh.positions;
    assert_int_equal(bench_run(&b, torus), NSDF_OK);
    assert_int_equal(bench_run(&fresh, torus), NSDF_OK);
    assert_int_equal(b.memory.used, held);
    assert_ptr_equal(b.mesh.positions, positions);
    assert_same_mesh(&b.mesh, &fresh.mesh);
    bench_end(&b);
    bench_end(&fresh);
}

typedef struct failing_heap {
    int left; /* allocations until the failure */
} failing_heap;

static void *failing_allocate(void *user, size_t size) {
    failing_heap *heap = user;
    return heap->left-- > 0 ? malloc(size) : NULL;
}

static void failing_release(void *user, void *pointer) {
    (void)user;
    free(pointer);
}

static nsdf_status run_on_heap(failing_heap *heap) {
    bench b;
    memset(&b, 0, sizeof b);
    bench_start(&b, 1);
    bench_end(&b);
    const nsdf_allocator hook = {heap, failing_allocate, failing_release};
    nsdf_memory_init(&b.memory, &hook, (uint64_t)1 << 30);
    nsdf_status status = nsdf_tasks_create(&b.memory, 1, NULL, &b.tasks);
    if (status == NSDF_OK)
        status = nsdf_mesher_create(&b.memory, b.tasks, &b.mesher);
    if (status == NSDF_OK)
        status = bench_run(&b, torus);
    if (status == NSDF_OK) {
        assert_closed_manifold(&b.mesh);
    } else {
        assert_int_equal(b.mesh.vertex_count, 0);
        assert_int_equal(b.mesh.triangle_count, 0);
    }
    bench_end(&b);
    return status;
}

static void every_failing_allocation_is_reported_and_nothing_leaks(void **state) {
    (void)state;
    int k = 0;
    for (nsdf_status status = NSDF_NO_MEMORY; status != NSDF_OK; k++) {
        failing_heap heap = {k};
        status = run_on_heap(&heap);
        assert_true(status == NSDF_OK || status == NSDF_NO_MEMORY);
    }
    assert_true(k > 15);
}

static void the_memory_limit_is_kept(void **state) {
    (void)state;
    bench b;
    bench_start(&b, 1);
    b.job.resolution = 256;
    b.job.dense = 1;
    b.memory.limit = 8 << 20;
    assert_int_equal(bench_run(&b, sphere), NSDF_LIMIT);
    assert_int_equal(b.mesh.vertex_count, 0);
    assert_true(b.memory.peak <= 8 << 20);
    b.job.resolution = 16;
    assert_int_equal(bench_run(&b, sphere), NSDF_OK); /* still of use */
    bench_end(&b);
}

static int cancel_after(void *user) {
    int *left = user;
    return (*left)-- == 0;
}

static void cancelling_leaves_an_empty_mesh(void **state) {
    (void)state;
    nsdf_status status = NSDF_CANCELLED;
    int asked = 0;
    bench b;
    bench_start(&b, 1);
    assert_int_equal(bench_run(&b, sphere), NSDF_OK);
    for (; status == NSDF_CANCELLED; asked++) {
        int left = asked;
        b.job.cancel = cancel_after;
        b.job.cancel_user = &left;
        status = bench_run(&b, torus);
        if (status == NSDF_CANCELLED)
            assert_int_equal(b.mesh.vertex_count, 0);
    }
    assert_int_equal(status, NSDF_OK);
    assert_true(asked > 5);
    assert_closed_manifold(&b.mesh);
    bench_end(&b);
}

static void jobs_without_a_domain_are_refused(void **state) {
    (void)state;
    bench b;
    bench_start(&b, 1);
    b.job.resolution = 1;
    assert_int_equal(bench_run(&b, sphere), NSDF_INVALID_ARGUMENT);
    b.job.resolution = 4097;
    assert_int_equal(bench_run(&b, sphere), NSDF_INVALID_ARGUMENT);
    b.job.resolution = 16;
    b.job.domain_max[1] = NAN;
    assert_int_equal(bench_run(&b, sphere), NSDF_INVALID_ARGUMENT);
    b.job.domain_max[1] = -1;
    assert_int_equal(bench_run(&b, sphere), NSDF_INVALID_ARGUMENT);
    for (int a = 0; a < 3; a++)
        b.job.domain_max[a] = b.job.domain_min[a];
    assert_int_equal(bench_run(&b, sphere), NSDF_INVALID_ARGUMENT);
    bench_end(&b);
}

/* Only the neighbourhood of the surface is evaluated. */
static size_t evaluated;
static void counting_field(void *user, uint32_t worker, size_t count, const float *const xyz[3], float *value,
                           float *const grad[3]) {
    evaluated += count;
    evaluate_field(user, worker, count, xyz, value, grad);
}

static void sparse_extraction_evaluates_a_fraction(void **state) {
    (void)state;
    bench b;
    bench_start(&b, 1);
    b.job.resolution = 128;
    b.f = sphere;
    b.job.field.user = &b.f;
    b.job.field.evaluate = counting_field;
    evaluated = 0;
    assert_int_equal(nsdf_mesher_run(b.mesher, &b.job, &b.memory, &b.mesh), NSDF_OK);
    assert_true(evaluated < 129u * 129u * 129u / 10);
    /* corners beside the surface, of which the centres found some; not all of the cells at it */
    assert_true(nsdf_mesher_get_stats(b.mesher).corner_points < 2 * (uint64_t)b.mesh.vertex_count);
    bench_end(&b);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shapes_have_their_area_volume_and_euler_number),
        cmocka_unit_test(vertices_end_on_the_zero_set_with_its_normals),
        cmocka_unit_test(no_vertex_moves_further_than_half_a_cell),
        cmocka_unit_test(sparse_equals_dense_for_distances),
        cmocka_unit_test(pieces_below_the_smallest_are_left_out),
        cmocka_unit_test(threads_do_not_change_the_mesh),
        cmocka_unit_test(meshes_are_closed_at_every_resolution_and_in_every_domain),
        cmocka_unit_test(surfaces_that_leave_the_domain_are_closed_at_its_border),
        cmocka_unit_test(broken_bounds_still_give_closed_meshes),
        cmocka_unit_test(surfaces_are_followed_into_bricks_without_cells),
        cmocka_unit_test(no_surface_gives_an_empty_mesh),
        cmocka_unit_test(values_that_are_not_numbers_are_outside),
        cmocka_unit_test(positions_are_in_world_units),
        cmocka_unit_test(storage_and_scratch_are_used_again),
        cmocka_unit_test(every_failing_allocation_is_reported_and_nothing_leaks),
        cmocka_unit_test(the_memory_limit_is_kept),
        cmocka_unit_test(cancelling_leaves_an_empty_mesh),
        cmocka_unit_test(jobs_without_a_domain_are_refused),
        cmocka_unit_test(sparse_extraction_evaluates_a_fraction),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
