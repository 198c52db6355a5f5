/* How surfaces move: small linear systems, rotations, blocks that follow vertices, and bones that move blocks. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "bones.h"
#include "dense_solve.h"
#include "motion_samples.h"
#include "register_nodes.h"
#include "rotation.h"

/* ---- Linear systems -------------------------------------------------------------------------------------- */

static void test_systems_are_solved(void **state) {
    nsdf_random random = nsdf_random_start(3, 1);
    (void)state;
    for (size_t n = 1; n <= 12; n++)
        for (size_t m = 1; m <= 3; m++) {
            double g[144], a[144] = {0}, x[36], b[36] = {0};
            for (size_t i = 0; i < n * n; i++)
                g[i] = (double)nsdf_random_normal(&random);
            for (size_t i = 0; i < n * m; i++)
                x[i] = (double)nsdf_random_normal(&random);
            for (size_t i = 0; i < n * n; i++)
                for (size_t k = 0; k < n; k++)
                    a[i] += g[i / n * n + k] * g[i % n * n + k] + (i / n == i % n ? 1.0 / (double)n : 0.0);
            for (size_t i = 0; i < n * m; i++)
                for (size_t k = 0; k < n; k++)
                    b[i] += a[i / m * n + k] * x[k * m + i % m];
            nsdf_solve_positive(a, n, b, m);
            for (size_t i = 0; i < n * m; i++)
                assert_true(fabs(b[i] - x[i]) < 1e-10);
        }
}

/* The inverse of Hilbert's matrix has whole numbers. */
static void test_hilbert_matrix_is_inverted(void **state) {
    static const double inverse[16] = {16,  -120,  240,  -140,  -120, 1200, -2700, 1680,
                                       240, -2700, 6480, -4200, -140, 1680, -4200, 2800};
    double a[16], b[16];
    (void)state;
    for (int i = 0; i < 16; i++) {
        a[i] = 1.0 / (i / 4 + i % 4 + 1);
        b[i] = i % 5 == 0;
    }
    nsdf_solve_positive(a, 4, b, 4);
    for (int i = 0; i < 16; i++)
        assert_true(fabs(b[i] - inverse[i]) < 1e-8 * fabs(inverse[i]));
}

static void test_singular_systems_stay_finite(void **state) {
    double a[9] = {1, 1, 0, 1, 1, 0, 0, 0, 0}, b[3] = {2, 2, 0};
    (void)state;
    nsdf_solve_positive(a, 3, b, 1);
    assert_true(fabs(b[0] + b[1] - 2.0) < 1e-9 && b[2] == 0.0);
}

/* ---- Rotations ------------------------------------------------------------------------------------------- */

/* rotation * stretch, the stretch along axes of its own. */
static void stretched(const double r[9], const double stretch[3], const sample_map *axes, double a[9]) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            a[3 * i + j] = 0.0;
            for (int k = 0; k < 3; k++)
                for (int l = 0; l < 3; l++)
                    a[3 * i + j] += r[3 * i + k] * axes->linear[3 * k + l] * stretch[l] * axes->linear[3 * j + l];
        }
}

static void test_rotations_are_recovered(void **state) {
    static const double stretches[][3] = {{1, 1, 1}, {2, 1, 0.5}, {1e-4, 2e-4, 3e-4}, {1, 0.5, 0} /* a plane */};
    nsdf_random random = nsdf_random_start(4, 1);
    (void)state;
    for (int round = 0; round < 200; round++) {
        double v[3], length = 0.0, a[9], found[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
        for (int k = 0; k < 3; k++) {
            v[k] = (double)nsdf_random_normal(&random);
            length += v[k] * v[k];
        }
        for (int k = 0; k < 3; k++)
            v[k] /= sqrt(length);
        const sample_map turn = sample_turn(v, 1.2 * (double)nsdf_random_unit(&random), 0, 0, 0);
        const double other[3] = {v[1], v[2], v[0]};
        const sample_map axes = sample_turn(other, 2.0, 0, 0, 0);
        stretched(turn.linear, stretches[round % 4], &axes, a);
        for (int call = 0; call < 5; call++) { /* unequal stretches take more steps */
            nsdf_extract_rotation(a, found);
            for (int i = 0; i < 9; i++)
                assert_true(fabs(found[i] - turn.linear[i]) < (call < 4 ? 0.02 : 1e-6));
        }
    }
    double none[9] = {0}, kept[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    nsdf_extract_rotation(none, kept);
    assert_true(kept[0] == 1.0 && kept[4] == 1.0 && kept[8] == 1.0 && kept[1] == 0.0);
}

/* ---- Tracking -------------------------------------------------------------------------------------------- */

static nsdf_motion track(const nsdf_frames *frames, uint32_t blocks, uint32_t threads) {
    nsdf_workers *workers = nsdf_workers_create(threads);
    nsdf_motion motion = sample_motion(frames, blocks, workers);
    nsdf_workers_free(workers);
    assert_true(motion.block_count == blocks && motion.frame_count == frames->count);
    for (uint32_t k = 0; k < blocks; k++)
        assert_true(motion.lives[k][0] == 0 && motion.lives[k][1] == frames->count - 1);
    return motion;
}

/* Whether a block's pose is this map: the centre's position, and the linear part within `linear`. */
static int follows(const nsdf_motion *m, uint32_t frame, uint32_t block, const sample_map *map, double linear) {
    const nsdf_pose *p = &m->poses[(size_t)frame * m->block_count + block];
    const double centre[3] = {(double)m->centres[block][0], (double)m->centres[block][1], (double)m->centres[block][2]};
    double moved[3], worst = 0.0;
    sample_apply(map, centre, moved);
    for (int i = 0; i < 9; i++)
        worst = fmax(worst, fabs(p->linear[i] - map->linear[i]));
    for (int k = 0; k < 3; k++)
        worst = fmax(worst, fabs(p->position[k] - moved[k]) < 5e-5 ? 0.0 : INFINITY);
    return worst < linear;
}

static void assert_follows_rigid(const nsdf_frames *frames, uint32_t blocks) {
    nsdf_motion m = track(frames, blocks, 2);
    for (uint32_t f = 0; f < m.frame_count; f++)
        for (uint32_t k = 0; k < m.block_count; k++) {
            const sample_map map = sample_rigid(f, 0);
            assert_true(follows(&m, f, k, &map, 3e-3));
        }
    nsdf_motion_free(&m);
}

static void test_rigid_motion_is_followed(void **state) {
    nsdf_surface closed = shape_sphere(0.3, 16, 32), open = shape_empty();
    (void)state;
    nsdf_surface unwelded = shape_unwelded(&closed);
    shape_add_sphere(&open, 0.3, 16, 32, 0, 5);
    nsdf_surface *surfaces[] = {&closed, &unwelded, &open};
    for (int i = 0; i < 3; i++) {
        nsdf_frames frames = sample_frames(surfaces[i], SAMPLE_FRAMES, UINT32_MAX, sample_rigid);
        assert_follows_rigid(&frames, 60);
        assert_follows_rigid(&frames, 1);
        sample_frames_free(&frames);
    }
}

static void test_balls_cover_the_surface(void **state) {
    nsdf_surface rest = shape_sphere(0.3, 16, 32);
    nsdf_frames frames = sample_frames(&rest, 3, UINT32_MAX, sample_still);
    nsdf_motion m = track(&frames, 60, 1);
    const nsdf_surface *s = &frames.frames[1].surface;
    double hits = 0.0;
    (void)state;
    assert_int_equal(m.block_count, 60);
    assert_true(fabs((double)m.radius - sqrt(5.0 * 4.0 * 0.09 / 60.0)) < 0.02 * (double)m.radius);
    for (uint32_t v = 0; v < s->vertex_count; v++) {
        int count = 0;
        for (uint32_t k = 0; k < m.block_count; k++) {
            const nsdf_vec3 d =
                nsdf_vec3_sub(nsdf_vec3_load(s->positions + 3 * (size_t)v), nsdf_vec3_load(m.centres[k]));
            count += nsdf_vec3_length(d) < (double)m.radius;
        }
        assert_true(count >= 2);
        hits += count / (double)s->vertex_count;
    }
    assert_true(hits > 4.0 && hits < 7.0);
    nsdf_motion_free(&m);
    sample_frames_free(&frames);
}

/* A piece of a surface says little of the map along its normal: what lies along the surface must fit. */
static void test_sheared_surface_is_followed(void **state) {
    nsdf_surface rest = shape_sphere(0.3, 30, 60);
    nsdf_frames frames = sample_frames(&rest, SAMPLE_FRAMES, UINT32_MAX, sample_shear);
    nsdf_motion m = track(&frames, 200, 2);
    double worst = 0.0, sheared = 0.0;
    (void)state;
    for (uint32_t f = 0; f < SAMPLE_FRAMES; f++)
        for (uint32_t k = 0; k < m.block_count; k++) {
            const sample_map map = sample_shear(f, 0);
            const nsdf_pose *p = &m.poses[(size_t)f * m.block_count + k];
            const nsdf_vec3 c = nsdf_vec3_load(m.centres[k]), side = {c.y, -c.x, 0.0};
            const double centre[3] = {c.x, c.y, c.z}, length = nsdf_vec3_length(side);
            const double t[3] = {side.x / length, side.y / length, 0.0};
            double moved[3];
            sample_apply(&map, centre, moved);
            for (int i = 0; i < 3 && length > 0.01; i++) {
                double along = 0.0, expected = 0.0;
                for (int j = 0; j < 3; j++) {
                    along += p->linear[3 * i + j] * t[j];
                    expected += map.linear[3 * i + j] * t[j];
                }
                worst = fmax(worst, fabs(along - expected));
                sheared = fmax(sheared, fabs(expected - t[i]));
                assert_true(fabs(p->position[i] - moved[i]) < 2e-3);
            }
        }
    assert_true(sheared > 0.15 && worst < 0.02);
    nsdf_motion_free(&m);
    sample_frames_free(&frames);
}

static void test_parts_that_nearly_touch_move_apart(void **state) {
    uint32_t second = 0;
    nsdf_surface rest = sample_two_balls(&second);
    nsdf_frames frames = sample_frames(&rest, SAMPLE_FRAMES, second, sample_rigid);
    nsdf_motion m = track(&frames, 120, 2);
    (void)state;
    for (uint32_t f = 0; f < m.frame_count; f++)
        for (uint32_t k = 0; k < m.block_count; k++) {
            const sample_map map = sample_rigid(f, m.centres[k][0] > 0.0f);
            assert_true(follows(&m, f, k, &map, 3e-3));
        }
    nsdf_motion_free(&m);
    sample_frames_free(&frames);
}

/* ---- Without correspondences ----------------------------------------------------------------------------- */

/* Nodes of frames whose triangles say nothing of each other. */
static nsdf_nodes register_nodes(const nsdf_frames *frames, uint32_t rest, uint32_t count, uint32_t threads) {
    nsdf_workers *workers = nsdf_workers_create(threads);
    nsdf_nodes nodes;
    assert_int_equal(nsdf_nodes_place(&nodes, frames, rest, count, 1), 0);
    assert_int_equal(nsdf_nodes_register(&nodes, frames, 1, workers), 0);
    assert_int_equal(nsdf_nodes_find_support(&nodes, frames, workers), 0);
    nsdf_workers_free(workers);
    return nodes;
}

/* A cube that turns and moves: only its edges and corners tell how. */
static void test_nodes_follow_an_unknown_motion(void **state) {
    nsdf_surface rest = shape_cube(0.2);
    nsdf_frames frames = sample_frames(&rest, SAMPLE_FRAMES, UINT32_MAX, sample_slow_turn);
    nsdf_nodes n = register_nodes(&frames, SAMPLE_REST, 500, 2);
    double sum = 0.0, moved_sum = 0.0;
    (void)state;
    for (uint32_t f = 0; f < SAMPLE_FRAMES; f++)
        for (uint32_t i = 0; i < n.count; i++) {
            const sample_map map = sample_slow_turn(f, 0);
            const nsdf_vec3 at = nsdf_vec3_load(nsdf_node_at(&n, SAMPLE_REST, i));
            const double x[3] = {at.x, at.y, at.z};
            double moved[3], square = 0.0, far = 0.0;
            sample_apply(&map, x, moved);
            for (int k = 0; k < 3; k++) {
                square += pow((double)nsdf_node_at(&n, f, i)[k] - moved[k], 2.0);
                far += pow(x[k] - moved[k], 2.0);
            }
            sum += sqrt(square);
            moved_sum += sqrt(far);
        }
    assert_true(moved_sum / (SAMPLE_FRAMES * n.count) > 0.03);
    assert_true(sum < 0.15 * moved_sum);
    for (size_t i = 0; i < (size_t)SAMPLE_FRAMES * n.count; i++)
        assert_int_equal(n.support[i], 1);
    nsdf_nodes_free(&n);
    sample_frames_free(&frames);
}

static void test_registration_does_not_depend_on_threads(void **state) {
    nsdf_surface rest = shape_cube(0.2);
    nsdf_frames frames = sample_frames(&rest, SAMPLE_FRAMES, UINT32_MAX, sample_slow_turn);
    nsdf_nodes one = register_nodes(&frames, 1, 200, 1), three = register_nodes(&frames, 1, 200, 3);
    (void)state;
    assert_memory_equal(one.positions, three.positions, sizeof *one.positions * SAMPLE_FRAMES * one.count);
    nsdf_nodes_free(&one);
    nsdf_nodes_free(&three);
    sample_frames_free(&frames);
}

/* A ball on frame 0, and another one beside it from frame 2 on. */
static void test_new_surface_gets_nodes_and_blocks_with_lives(void **state) {
    nsdf_frames frames = {.frames = calloc(SAMPLE_FRAMES * 2, sizeof *frames.frames),
                          .count = SAMPLE_FRAMES * 2,
                          .capacity = SAMPLE_FRAMES * 2};
    nsdf_workers *workers = nsdf_workers_create(2);
    nsdf_motion motion;
    uint32_t born = 0, second = 0;
    (void)state;
    for (uint32_t f = 0; f < frames.count; f++)
        frames.frames[f].surface = f < SAMPLE_FRAMES ? shape_sphere(0.2, 14, 28) : sample_two_balls(&second);
    for (uint32_t f = 0; f < SAMPLE_FRAMES; f++)
        for (uint32_t v = 0; v < frames.frames[f].surface.vertex_count; v++)
            frames.frames[f].surface.positions[3 * (size_t)v] -= 0.201f;
    nsdf_nodes n = register_nodes(&frames, 0, 300, 2);
    assert_int_equal(nsdf_nodes_cover(&n, &frames, 1, workers), 0);
    assert_true(n.placed == 300 && n.count > 420);
    for (uint32_t i = n.placed; i < n.count; i++) {
        assert_true(nsdf_node_at(&n, SAMPLE_FRAMES, i)[0] > 0.0f);
        assert_true(n.support[(size_t)(SAMPLE_FRAMES + 1) * n.count + i]);
    }
    assert_int_equal(nsdf_motion_find(&motion, &n, 60, 0.5, 0.1f, workers), 0);
    for (uint32_t k = 0; k < motion.block_count; k++)
        born += motion.lives[k][0] == SAMPLE_FRAMES && motion.lives[k][1] == frames.count - 1;
    assert_true(born > 20);
    nsdf_motion_free(&motion);
    nsdf_nodes_free(&n);
    nsdf_workers_free(workers);
    sample_frames_free(&frames);
}

static void test_motion_does_not_depend_on_threads(void **state) {
    nsdf_surface rest = shape_sphere(0.3, 16, 32);
    nsdf_frames frames = sample_frames(&rest, SAMPLE_FRAMES, UINT32_MAX, sample_shear);
    nsdf_motion one = track(&frames, 50, 1), three = track(&frames, 50, 3);
    (void)state;
    assert_memory_equal(one.poses, three.poses, sizeof *one.poses * SAMPLE_FRAMES * one.block_count);
    assert_memory_equal(one.centres, three.centres, sizeof *one.centres * one.block_count);
    nsdf_motion_free(&one);
    nsdf_motion_free(&three);
    sample_frames_free(&frames);
}

static void test_frames_are_connected_when_their_triangles_are_the_same(void **state) {
    nsdf_surface rest = shape_sphere(0.3, 6, 8);
    nsdf_frames frames = sample_frames(&rest, 3, UINT32_MAX, sample_rigid);
    nsdf_surface *last = &frames.frames[2].surface;
    (void)state;
    assert_true(nsdf_frames_connected(&frames));
    (void)shape_vertex(last, 0, 0, 0);
    assert_false(nsdf_frames_connected(&frames));
    last->vertex_count--;
    last->triangle_count--;
    assert_false(nsdf_frames_connected(&frames));
    last->triangle_count++;
    const uint32_t first = last->indices[0];
    last->indices[0] = last->indices[1];
    last->indices[1] = first;
    assert_false(nsdf_frames_connected(&frames));
    frames.count = 2;
    assert_true(nsdf_frames_connected(&frames));
    frames.count = 1;
    assert_true(nsdf_frames_connected(&frames));
    frames.count = 3;
    sample_frames_free(&frames);
}

/* ---- Bones ----------------------------------------------------------------------------------------------- */

static nsdf_bones fit_bones(nsdf_motion *m, uint32_t count, uint32_t threads) {
    nsdf_workers *workers = nsdf_workers_create(threads);
    nsdf_bones bones;
    assert_int_equal(nsdf_bones_fit(&bones, m, count, workers), 0);
    nsdf_workers_free(workers);
    assert_true(bones.bone_count >= 1 && bones.bone_count <= count);
    for (uint32_t k = 0; k < bones.block_count; k++) {
        double sum = 0.0;
        for (int i = 0; i < NSDF_BONE_INFLUENCES; i++) {
            assert_true(bones.bone[k][i] < bones.bone_count && bones.weight[k][i] >= 0.0);
            sum += bones.weight[k][i];
        }
        assert_true(fabs(sum - 1.0) < 1e-9);
    }
    return bones;
}

/* Root mean square over blocks, frames and coordinates of where the bones put the blocks' centres. */
static double centre_error(const nsdf_bones *b, const nsdf_motion *m) {
    double sum = 0.0;
    for (uint32_t f = 0; f < m->frame_count; f++)
        for (uint32_t k = 0; k < m->block_count; k++)
            for (int row = 0; row < 3; row++) {
                double x = -m->poses[(size_t)f * m->block_count + k].position[row];
                for (int i = 0; i < NSDF_BONE_INFLUENCES; i++) {
                    const double *p = b->poses + 12 * ((size_t)f * b->bone_count + b->bone[k][i]) + 4 * row;
                    x += b->weight[k][i] * (p[3] + p[0] * (double)m->centres[k][0] + p[1] * (double)m->centres[k][1] +
                                            p[2] * (double)m->centres[k][2]);
                }
                sum += x * x;
            }
    return sqrt(sum / (3.0 * m->frame_count * m->block_count));
}

static void test_two_rigid_halves_do_not_share_bones(void **state) {
    uint32_t second = 0;
    nsdf_surface rest = sample_two_balls(&second);
    nsdf_frames frames = sample_frames(&rest, SAMPLE_FRAMES, second, sample_rigid);
    nsdf_motion m = track(&frames, 120, 2);
    (void)state;
    nsdf_bones one = fit_bones(&m, 1, 2), few = fit_bones(&m, 4, 2);
    uint8_t used[4] = {0}; /* by which half, as bits */
    assert_true(one.bone_count == 1 && few.bone_count == 4);
    assert_true(one.error > 0.05 && few.error < 3e-4 && centre_error(&few, &m) < 1e-4);
    for (uint32_t k = 0; k < m.block_count; k++)
        for (int i = 0; i < NSDF_BONE_INFLUENCES; i++)
            if (few.weight[k][i] > 0.05)
                used[few.bone[k][i]] |= m.centres[k][0] > 0.0f ? 2 : 1;
    for (int b = 0; b < 4; b++) /* halves do not share bones */
        assert_true(used[b] != 3);
    nsdf_bones_free(&one);
    nsdf_bones_free(&few);
    nsdf_motion_free(&m);
    sample_frames_free(&frames);
}

static void test_blends_of_bones_are_found(void **state) {
    nsdf_motion m = sample_bending_rod();
    nsdf_bones one = fit_bones(&m, 1, 1), two = fit_bones(&m, 2, 1), four = fit_bones(&m, 4, 1);
    uint32_t blended = 0;
    (void)state;
    assert_true(two.error < 0.05 * one.error && four.error < 0.05 * one.error);
    for (uint32_t k = 0; k < m.block_count; k++)
        blended += two.weight[k][1] > 0.05;
    assert_true(blended >= 10);
    const double before = centre_error(&two, &m);
    assert_int_equal(nsdf_bones_solve_poses(&two, &m), 0); /* nothing left to gain */
    assert_true(centre_error(&two, &m) <= before * 1.001 + 1e-9);
    nsdf_bones_free(&one);
    nsdf_bones_free(&two);
    nsdf_bones_free(&four);
    nsdf_motion_free(&m);
}

static void test_bones_do_not_depend_on_threads(void **state) {
    nsdf_motion m = sample_bending_rod();
    nsdf_bones one = fit_bones(&m, 3, 1), three = fit_bones(&m, 3, 3);
    (void)state;
    assert_true(one.bone_count == three.bone_count && one.error == three.error);
    assert_memory_equal(one.poses, three.poses, 12 * sizeof *one.poses * one.bone_count * one.frame_count);
    assert_memory_equal(one.weight, three.weight, sizeof *one.weight * one.block_count);
    nsdf_bones_free(&one);
    nsdf_bones_free(&three);
    nsdf_motion_free(&m);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_systems_are_solved),
        cmocka_unit_test(test_hilbert_matrix_is_inverted),
        cmocka_unit_test(test_singular_systems_stay_finite),
        cmocka_unit_test(test_rotations_are_recovered),
        cmocka_unit_test(test_rigid_motion_is_followed),
        cmocka_unit_test(test_balls_cover_the_surface),
        cmocka_unit_test(test_sheared_surface_is_followed),
        cmocka_unit_test(test_parts_that_nearly_touch_move_apart),
        cmocka_unit_test(test_nodes_follow_an_unknown_motion),
        cmocka_unit_test(test_registration_does_not_depend_on_threads),
        cmocka_unit_test(test_new_surface_gets_nodes_and_blocks_with_lives),
        cmocka_unit_test(test_motion_does_not_depend_on_threads),
        cmocka_unit_test(test_frames_are_connected_when_their_triangles_are_the_same),
        cmocka_unit_test(test_two_rigid_halves_do_not_share_bones),
        cmocka_unit_test(test_blends_of_bones_are_found),
        cmocka_unit_test(test_bones_do_not_depend_on_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
