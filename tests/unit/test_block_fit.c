/* Fitting blocks: basis and poses with their slopes, first coefficients, fitting, rounding. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "block_batch.h"
#include "block_fit.h"
#include "block_fixture.h"
#include "block_pose.h"
#include "block_stage.h"
#include "block_start.h"
#include "fit_samples.h"

/* ---- Basis ----------------------------------------------------------------------------------------------- */

static void test_basis_is_products_of_polynomials(void **state) {
    nsdf_random random = nsdf_random_start(2, 2);
    (void)state;
    for (uint32_t degree = 0; degree <= 3; degree++)
        for (int point = 0; point < 20; point++) {
            float u[3], basis[20];
            random_point(&random, 1.0f, u);
            nsdf_block_basis(degree, u, basis);
            assert_true(basis[0] == 1.0f && (degree < 1 || (basis[1] == u[0] && basis[2] == u[1] && basis[3] == u[2])));
            if (degree < 2)
                continue;
            assert_true(fabsf(basis[4] - (u[0] * u[0] - 1.0f / 9)) < 1e-6f && fabsf(basis[6] - u[0] * u[2]) < 1e-6f);
            assert_true(degree < 3 || fabsf(basis[19] - (u[2] * u[2] * u[2] - 3.0f / 11 * u[2])) < 1e-6f);
            assert_true(degree < 3 || fabsf(basis[14] - u[0] * u[1] * u[2]) < 1e-6f);
        }
}

/* Monomials give the value that the basis gives; a gradient goes back by the transposed map. */
static void test_monomials_stand_for_the_basis(void **state) {
    (void)state;
    for (uint32_t degree = 0; degree <= 3; degree++) {
        fixture x = two_balls(20, 2, degree);
        nsdf_block_model *m = &x.model;
        float *values = random_floats(m->value_count, 1.0f, 4), monomials[20], powers[20], basis[20];
        float *gradient = calloc(m->value_count, sizeof *gradient);
        const float u[3] = {0.3f, -0.5f, 0.4f};
        uint32_t n = 0;
        double by_basis = 0.0, by_monomials = 0.0;
        nsdf_block_get_monomials(m, values, 7, monomials);
        nsdf_block_basis(degree, u, basis);
        for (uint32_t d = 0; d <= degree; d++)
            for (uint32_t rest = 0; rest <= d; rest++)
                for (uint32_t c = 0; c <= rest; c++, n++) {
                    powers[n] = powf(u[0], (float)(d - rest)) * powf(u[1], (float)(rest - c)) * powf(u[2], (float)c);
                    by_monomials += (double)(monomials[n] * powers[n]);
                }
        /* of the value with respect to monomials: the powers; with respect to coefficients: the basis */
        nsdf_block_add_gradient(m, 7, powers, gradient);
        n = 0;
        for (uint32_t d = 0; d <= degree; d++)
            for (uint32_t i = 0; i < nsdf_degree_terms(d); i++, n++) {
                const size_t at = nsdf_block_degree_offset(m, 7, d) + i;
                by_basis += (double)(values[at] * basis[n]);
                assert_true(fabsf(gradient[at] - basis[n]) < 1e-5f);
            }
        assert_true(fabs(by_basis - by_monomials) < 1e-5);
        free(values);
        free(gradient);
        free_fixture(&x);
    }
}

/* ---- One time -------------------------------------------------------------------------------------------- */

static void test_maps_are_the_inverse_of_poses(void **state) {
    fixture x = two_balls(60, 3, 1);
    (void)state;
    for (int time = 0; time <= 10; time++) {
        nsdf_block_frame_compose(&x.frame, &x.model, x.model.values, 0.1 * time);
        for (uint32_t k = 0; k < x.model.desc.block_count; k++) {
            const float *map = x.frame.map[k], *pose = x.frame.pose[k];
            const float r = values_of(&x.model, NSDF_BLOCK_RADII)[k];
            for (int row = 0; row < 3; row++) {
                float at = map[4 * row + 3];
                for (int column = 0; column < 3; column++) {
                    float sum = 0.0f;
                    for (int i = 0; i < 3; i++)
                        sum += map[4 * row + i] * pose[4 * i + column] * r;
                    assert_true(fabsf(sum - (row == column ? 1.0f : 0.0f)) < 1e-5f);
                    at += map[4 * row + column] * pose[4 * column + 3];
                }
                assert_true(fabsf(at) < 2e-5f);
            }
        }
    }
    free_fixture(&x);
}

/* The first model already moves its blocks as the surface moves. */
static void test_blocks_start_where_the_surface_is(void **state) {
    fixture x = two_balls(60, 2, 1);
    (void)state;
    for (uint32_t f = 0; f < SAMPLE_FRAMES; f++) {
        nsdf_block_frame_compose(&x.frame, &x.model, x.model.values, x.u[f]);
        for (uint32_t k = 0; k < x.model.desc.block_count; k++) {
            const float *c = values_of(&x.model, NSDF_BLOCK_CENTRES) + 3 * (size_t)k;
            const sample_map map = sample_rigid(f, c[0] > 0.0f);
            const double centre[3] = {(double)c[0], (double)c[1], (double)c[2]};
            double moved[3];
            sample_apply(&map, centre, moved);
            for (int row = 0; row < 3; row++)
                assert_true(fabs((double)x.frame.pose[k][4 * row + 3] - moved[row]) < 5e-3);
        }
    }
    free_fixture(&x);
}

/* How far the model's blocks are from where the motion has them, at worst. */
static double start_miss(const nsdf_block_model *model, const nsdf_motion *motion, const double *u) {
    nsdf_block_frame frame;
    double worst = 0.0;
    assert_int_equal(nsdf_block_frame_create(&frame, model, low, high), 0);
    for (uint32_t f = 0; f < motion->frame_count; f++) {
        nsdf_block_frame_compose(&frame, model, model->values, u[f]);
        for (uint32_t k = 0; k < motion->block_count; k++)
            for (int row = 0; row < 3; row++)
                worst = fmax(worst, fabs((double)frame.pose[k][4 * row + 3] -
                                         motion->poses[(size_t)f * motion->block_count + k].position[row]));
    }
    nsdf_block_frame_free(&frame);
    return worst;
}

static void test_rounded_weights_sum_to_1(void **state) {
    const nsdf_block_steps steps = {1e-3, 2e-3};
    double u[9];
    nsdf_motion motion = sample_bending_rod();
    nsdf_workers *workers = nsdf_workers_create(1);
    nsdf_bones bones;
    nsdf_block_model model;
    uint32_t blended = 0;
    (void)state;
    for (int f = 0; f < 9; f++)
        u[f] = f / 8.0;
    assert_int_equal(nsdf_bones_fit(&bones, &motion, 5, workers), 0);
    assert_int_equal(nsdf_block_model_create(&model, &motion, &bones, u, 1, 1.0, 0.0, &steps), 0);
    const float *w = values_of(&model, NSDF_BLOCK_WEIGHTS);
    for (uint32_t k = 0; k < motion.block_count; k++) {
        assert_true(w[4 * k] + w[4 * k + 1] + w[4 * k + 2] + w[4 * k + 3] == 1.0f);
        for (uint32_t i = 0; i < 4; i++)
            assert_true(fabs((double)w[4 * k + i] - bones.weight[k][i]) < 0.05);
        blended += w[4 * k + 2] > 0.0f;
    }
    assert_true(blended > 5);
    assert_true(start_miss(&model, &motion, u) < 0.01);
    nsdf_block_model_free(&model);
    nsdf_bones_free(&bones);
    nsdf_workers_free(workers);
    nsdf_motion_free(&motion);
}

/* L = sum over blocks of g . pose: linear in the poses, and so in their control points. */
static double linear_loss(fixture *x, const float (*g)[12], double u) {
    double sum = 0.0;
    nsdf_block_frame_compose(&x->frame, &x->model, x->model.values, u);
    for (uint32_t k = 0; k < x->model.desc.block_count; k++)
        for (int i = 0; i < 12; i++)
            sum += (double)g[k][i] * (double)x->frame.pose[k][i];
    return sum;
}

static void test_pose_gradients_reach_the_control_points(void **state) {
    fixture x = two_balls(40, 4, 1);
    const nsdf_block_model *m = &x.model;
    float(*g)[12] = (float(*)[12])(void *)random_floats(12 * (size_t)m->desc.block_count, 1.0f, 3);
    float *scratch = calloc(12 * (size_t)m->desc.bone_count, sizeof *scratch);
    float *gradient = calloc(m->value_count, sizeof *gradient);
    (void)state;
    for (int time = 0; time < 3; time++) {
        const double u = 0.45 * time;
        memset(gradient, 0, m->value_count * sizeof *gradient);
        nsdf_block_sum_bones(m, (const float(*)[12])g, scratch);
        nsdf_block_scatter_bones(m, u, scratch, gradient);
        for (size_t i = 0; i < m->value_count; i++) {
            if (i < m->pose_offset || i >= m->pose_offset + m->pose_count) {
                assert_true(gradient[i] == 0.0f);
                continue;
            }
            const float kept = m->values[i];
            m->values[i] = kept + 0.25f;
            double slope = linear_loss(&x, (const float(*)[12])g, u);
            m->values[i] = kept - 0.25f;
            slope = (slope - linear_loss(&x, (const float(*)[12])g, u)) / 0.5;
            m->values[i] = kept;
            assert_true(fabs(slope - (double)gradient[i]) < 1e-3 + 1e-3 * fabs(slope));
        }
    }
    free(g);
    free(scratch);
    free(gradient);
    free_fixture(&x);
}

/* ---- First coefficients ---------------------------------------------------------------------------------- */

/* Greatest error of the field near the surface, over all frames; `distance` is of a point at rest, points of which are
 * taken within `half` of the origin, then lifted along z. */
static double worst_error(fixture *x, double (*distance)(const double p[3]), float half, float lift,
                          sample_mover move) {
    nsdf_random random = nsdf_random_start(5, 5);
    double worst = 0.0;
    uint32_t seen = 0, hits;
    for (uint32_t f = 0; f < SAMPLE_FRAMES; f++) {
        const sample_map map = move(f, 0);
        nsdf_block_frame_compose(&x->frame, &x->model, x->model.values, x->u[f]);
        for (int i = 0; i < 4000; i++) {
            float p[3], q[3];
            double moved[3];
            random_point(&random, half, p);
            p[2] += lift;
            const double rest[3] = {(double)p[0], (double)p[1], (double)p[2]}, d = distance(rest);
            if (fabs(d) > 0.02)
                continue;
            sample_apply(&map, rest, moved);
            for (int k = 0; k < 3; k++)
                q[k] = (float)moved[k];
            worst = fmax(worst, fabs(field_at(&x->frame, &x->model, q, &hits) - d));
            seen += hits > 0;
        }
    }
    assert_true(seen > 500);
    return worst;
}

static double sphere_distance(const double p[3]) {
    return sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) - 0.3;
}

/* The upper side of a cube, away from its rim. */
static double plane_distance(const double p[3]) {
    return p[2] - 0.2;
}

static nsdf_surface fine_cube(void) {
    nsdf_surface s = shape_empty(), cube = shape_cube(0.2);
    enum { N = 16 };
    for (uint32_t t = 0; t < cube.triangle_count; t++) {
        const nsdf_vec3 a = shape_corner(&cube, t, 0), b = shape_corner(&cube, t, 1), c = shape_corner(&cube, t, 2);
        uint32_t row[N + 1][N + 1];
        for (uint32_t i = 0; i <= N; i++)
            for (uint32_t j = 0; i + j <= N; j++) {
                const double v = (double)i / N, w = (double)j / N, u = 1.0 - v - w;
                row[i][j] = shape_vertex(&s, u * a.x + v * b.x + w * c.x, u * a.y + v * b.y + w * c.y,
                                         u * a.z + v * b.z + w * c.z);
            }
        for (uint32_t i = 0; i < N; i++)
            for (uint32_t j = 0; i + j < N; j++) {
                shape_triangle(&s, row[i][j], row[i + 1][j], row[i][j + 1]);
                if (i + j + 1 < N)
                    shape_triangle(&s, row[i + 1][j], row[i + 1][j + 1], row[i][j + 1]);
            }
    }
    nsdf_surface_free(&cube);
    return s;
}

static void test_a_sphere_is_started_well(void **state) {
    double worst[3];
    (void)state;
    for (uint32_t degree = 1; degree <= 3; degree++) {
        fixture x = make_fixture(shape_sphere(0.3, 30, 60), UINT32_MAX, sample_rigid, 200, 2, degree);
        start(&x);
        worst[degree - 1] = worst_error(&x, sphere_distance, 0.35f, 0.0f, sample_rigid);
        free_fixture(&x);
    }
    assert_true(worst[0] < 1e-2 && worst[1] < 2.5e-3 && worst[2] < 2e-3);
}

static void test_a_plane_is_started_exactly(void **state) {
    fixture x = make_fixture(fine_cube(), UINT32_MAX, sample_still, 300, 1, 1);
    (void)state;
    start(&x);
    assert_true(worst_error(&x, plane_distance, 0.06f, 0.2f, sample_still) < 1e-4);
    free_fixture(&x);
}

/* ---- Fitting --------------------------------------------------------------------------------------------- */

/* Mean error of the samples near the surface. */
static double sample_error(fixture *x, const fit_fixture *fit) {
    double sum = 0.0;
    uint32_t count = 0, hits;
    for (uint32_t f = 0; f < SAMPLE_FRAMES; f++) {
        const nsdf_sample_set *set = &fit->sets[f];
        nsdf_block_frame_compose(&x->frame, &x->model, x->model.values, x->u[f]);
        for (size_t i = 0; i < set->count; i++) {
            const float p[3] = {set->x[i], set->y[i], set->z[i]};
            const double f_at = field_at(&x->frame, &x->model, p, &hits);
            if (hits == 0 || fabsf(set->d[i]) > 0.01f)
                continue;
            sum += fabs(f_at - (double)set->d[i]);
            count++;
        }
    }
    assert_true(count > 1000);
    return sum / count;
}

/* Errors for fitting to remove. */
static void spoil(nsdf_block_model *m) {
    float *noise = random_floats(m->term_count, 0.005f, 3);
    for (size_t i = 0; i < m->term_count; i++)
        m->values[m->term_offset + i] += noise[i];
    free(noise);
}

static void test_fitting_lowers_the_error_the_same_with_any_threads(void **state) {
    double before = 0.0, after[2] = {0.0, 0.0};
    float *values[2];
    size_t count = 0;
    (void)state;
    for (int run = 0; run < 2; run++) {
        fixture x = make_fixture(shape_sphere(0.3, 30, 60), UINT32_MAX, sample_shear, 100, 3, 2);
        fit_fixture fit;
        nsdf_fit_result result;
        start(&x);
        nsdf_workers_free(x.workers);
        x.workers = nsdf_workers_create(run ? 3 : 1);
        make_fit(&fit, &x, 400);
        spoil(&x.model);
        before = sample_error(&x, &fit);
        assert_int_equal(nsdf_block_fit_run(&fit.job, &x.model, &result), 0);
        after[run] = sample_error(&x, &fit);
        assert_true(result.steps == 400 && !result.diverged && !result.aborted && result.samples > 100000);
        assert_true(result.near_error > 0.0 && result.near_error < 0.01);
        values[run] = x.model.values;
        count = x.model.value_count;
        x.model.values = NULL;
        free_fit(&fit);
        free_fixture(&x);
    }
    assert_true(after[0] < 0.5 * before && after[0] == after[1]);
    assert_memory_equal(values[0], values[1], count * sizeof(float));
    free(values[0]);
    free(values[1]);
}

static void test_rounded_values_are_what_a_reader_has(void **state) {
    fixture x = two_balls(40, 3, 2);
    nsdf_block_model *m = &x.model;
    float *rounded = malloc(m->value_count * sizeof *rounded);
    int32_t q;
    (void)state;
    start(&x);
    m->values[m->term_offset] = -1e-9f; /* becomes 0, not -0 */
    nsdf_block_model_round(m, m->values, rounded);
    for (uint32_t t = 0; t < m->desc.list.count; t++) {
        const nsdf_array_desc *a = &m->desc.list.tensors[t].arrays[0];
        const size_t at = nsdf_block_offset(&m->desc, t);
        for (size_t i = at; i < at + (size_t)nsdf_array_size(a); i++) {
            assert_int_equal(nsdf_quantise(&rounded[i], 1, a->step, a->offset, &q), 0);
            const float read = nsdf_dequantise(q, a->step, a->offset);
            assert_memory_equal(&read, &rounded[i], sizeof read);
            assert_true(fabsf(rounded[i] - m->values[i]) <= (t < NSDF_BLOCK_POSES ? 0.0f : 0.51f * a->step));
        }
    }
    assert_true(rounded[m->term_offset] == 0.0f && !signbit(rounded[m->term_offset]));
    free(rounded);
    free_fixture(&x);
}

static void test_coded_blocks_read_back_as_they_were(void **state) {
    fixture x = two_balls(40, 3, 2);
    nsdf_coded_segment segment;
    nsdf_part_ref parts[NSDF_MAX_PARTS];
    nsdf_blocks_desc back;
    uint32_t count = 0;
    size_t coded = 0;
    (void)state;
    memset(&segment, 0, sizeof segment);
    start(&x);
    float *values = calloc(x.model.value_count, sizeof *values), *rounded = calloc(x.model.value_count, sizeof *values);
    const double step = (double)x.model.desc.list.tensors[NSDF_BLOCK_COEFFICIENTS].arrays[0].step;
    for (size_t i = 0; i < x.model.term_count; i++) /* unrounded, and about half of them ties */
        x.model.values[x.model.term_offset + i] = (float)(((double)i + (i % 2 ? 0.5 : 0.3)) * step);
    nsdf_block_model_round(&x.model, x.model.values, rounded);
    assert_int_equal(nsdf_code_blocks(&x.model, &segment), 0);
    assert_int_equal(nsdf_read_parts(segment.payload.data, segment.payload.size, parts, &count, NULL), NSDF_PARSE_OK);
    assert_int_equal(nsdf_read_blocks_desc(parts[0].data, parts[0].size, &back, &coded, NULL), NSDF_PARSE_OK);
    void *scratch = malloc(nsdf_parameter_scratch_size(&back.list) + 1);
    assert_int_equal(nsdf_read_parameters(parts[0].data, parts[0].size, coded, &back.list, scratch, NULL, values, NULL),
                     NSDF_PARSE_OK);
    assert_memory_equal(values, rounded, x.model.value_count * sizeof *values);
    assert_int_equal(nsdf_check_blocks(&back, values, NULL), NSDF_PARSE_OK);
    assert_true(segment.hash == nsdf_hash_floats(NSDF_HASH_START, values, x.model.value_count));
    free(scratch);
    free(rounded);
    free(values);
    nsdf_buffer_free(&segment.payload);
    free_fixture(&x);
}

/* Short sequences have steps of fewer frames with as many points, and visit as many frames in all. */
static void test_steps_suit_the_length_of_the_sequence(void **state) {
    const struct { uint32_t frames, in_step; } cases[] = {{1, 8}, {7, 8}, {10, 10}, {24, 24}, {500, 24}};
    nsdf_encoder_options o;
    (void)state;
    nsdf_encoder_options_init(&o, NSDF_PRESET_MEDIUM);
    assert_int_equal(o.block_frames, 24);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const nsdf_encoder_options b = nsdf_block_options(&o, cases[i].frames);
        const uint64_t visits = b.steps * b.batch_frames, points = (uint64_t)b.batch_frames * b.batch_points;
        assert_int_equal(b.batch_frames, cases[i].in_step);
        assert_true(visits >= o.block_visits && visits < o.block_visits + b.batch_frames);
        assert_true(points <= 24u * o.block_points && points > 24u * o.block_points - b.batch_frames);
    }
    o.block_steps = 77;
    o.block_frames = 3;
    o.block_points = 60000;
    assert_int_equal(nsdf_block_options(&o, 10).steps, 77);
    assert_int_equal(nsdf_block_options(&o, 10).batch_frames, 3);
    o.block_frames = 4000;
    assert_int_equal(nsdf_block_options(&o, 10).batch_points, NSDF_BATCH_MOST_POINTS);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_basis_is_products_of_polynomials),
        cmocka_unit_test(test_monomials_stand_for_the_basis),
        cmocka_unit_test(test_maps_are_the_inverse_of_poses),
        cmocka_unit_test(test_blocks_start_where_the_surface_is),
        cmocka_unit_test(test_rounded_weights_sum_to_1),
        cmocka_unit_test(test_pose_gradients_reach_the_control_points),
        cmocka_unit_test(test_a_sphere_is_started_well),
        cmocka_unit_test(test_a_plane_is_started_exactly),
        cmocka_unit_test(test_fitting_lowers_the_error_the_same_with_any_threads),
        cmocka_unit_test(test_rounded_values_are_what_a_reader_has),
        cmocka_unit_test(test_coded_blocks_read_back_as_they_were),
        cmocka_unit_test(test_steps_suit_the_length_of_the_sequence),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
