/* Batches of points and the passes over them: hits, values, loss, gradients; batches that are kept between steps. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "block_cache.h"
#include "block_fixture.h"

/* Random points, and what working on them needs. */
typedef struct {
    nsdf_sample_set samples;
    nsdf_block_batch batch;
    nsdf_block_work work;
} batch_fixture;

static void make_samples(nsdf_sample_set *set, uint32_t count, float range, uint64_t seed) {
    nsdf_random random = nsdf_random_start(seed, 7);
    float **arrays[] = {&set->x, &set->y, &set->z, &set->d};
    for (int i = 0; i < 4; i++)
        assert_non_null(*arrays[i] = malloc(count * sizeof(float)));
    for (uint32_t i = 0; i < count; i++) {
        float p[3];
        random_point(&random, range, p);
        set->x[i] = p[0];
        set->y[i] = p[1];
        set->z[i] = p[2];
        set->d[i] = 0.02f * (2.0f * nsdf_random_unit(&random) - 1.0f);
    }
    set->count = count;
}

/* Random coefficients, at a time of which there is no frame. */
static void set_noise(fixture *x) {
    float *noise = random_floats(x->model.term_count, 0.1f, 3);
    memcpy(x->model.values + x->model.term_offset, noise, x->model.term_count * sizeof *noise);
    nsdf_block_frame_compose(&x->frame, &x->model, x->model.values, 0.3);
    free(noise);
}

/* All points, with candidates found at the frame's time. */
static batch_fixture make_batch(const fixture *x, uint32_t count, float margin) {
    const uint32_t blocks = x->model.desc.block_count;
    batch_fixture b;
    make_samples(&b.samples, count, 0.5f, 7);
    assert_int_equal(nsdf_block_work_create(&b.work, count, blocks, &x->frame), 0);
    assert_int_equal(nsdf_block_batch_create(&b.batch, count, blocks, &x->frame), 0);
    nsdf_block_batch_fill(&b.batch, &b.work, &x->frame, &b.samples, 0, 1, count);
    assert_int_equal(nsdf_block_batch_list(&b.batch, &b.work, nsdf_block_passes_select(), &x->frame,
                                           (const float(*)[12])x->frame.map, (const float(*)[6])x->frame.reach, NULL,
                                           blocks, margin),
                     0);
    return b;
}

static void free_batch(batch_fixture *b) {
    nsdf_sample_set_free(&b->samples);
    nsdf_block_batch_free(&b->batch);
    nsdf_block_work_free(&b->work);
}

static void pass_forward(const nsdf_block_passes *passes, const fixture *x, nsdf_block_work *work,
                         const nsdf_block_batch *batch) {
    const nsdf_block_model *m = &x->model;
    assert_int_equal(nsdf_block_batch_forward(work, batch, passes, &x->frame,
                                              (const float(*)[NSDF_BLOCK_MOST_TERMS])x->frame.terms,
                                              m->desc.block_count, m->desc.degree),
                     0);
}

/* Those of the sorted points that the block's ball holds, 0 or 1. */
static void mark_hits(const nsdf_block_work *w, uint32_t block, uint32_t count, uint8_t *hit) {
    memset(hit, 0, count);
    assert_true(w->first[block] % NSDF_HIT_LANES == 0 && w->first[block + 1] % NSDF_HIT_LANES == 0);
    for (uint32_t i = w->first[block]; i < w->first[block + 1]; i++)
        if (w->point[i] < count) {
            assert_false(hit[w->point[i]]);
            hit[w->point[i]] = 1;
        }
}

static uint32_t check_hits(const fixture *x, const batch_fixture *b, uint32_t block) {
    uint8_t *hit = malloc(b->batch.count);
    uint32_t found = 0;
    assert_non_null(hit);
    mark_hits(&b->work, block, b->batch.count, hit);
    for (uint32_t i = 0; i < b->batch.count; i++) {
        float u[3];
        const double root = to_ball(&x->frame, block, b->batch.point[i], u);
        if (fabs(root - 1e-4) > 1e-5)
            assert_true(hit[i] == (root > 1e-4));
        found += hit[i];
    }
    free(hit);
    return found;
}

static void refine_cells(nsdf_block_frame *frame, uint32_t times) {
    frame->inverse_cell *= (float)times;
    for (int axis = 0; axis < 3; axis++)
        frame->cells[axis] *= times;
}

/* Whatever the margin of the candidates and the size of the cells, and by all instruction sets. */
static void test_balls_find_their_points(void **state) {
    const nsdf_block_passes *sets[] = {nsdf_block_passes_generic(), nsdf_block_passes_select()};
    fixture x = two_balls(60, 2, 1);
    (void)state;
    nsdf_block_frame_compose(&x.frame, &x.model, x.model.values, 0.3);
    for (int run = 0; run < 6; run++) {
        uint32_t found = 0;
        if (run == 4)
            refine_cells(&x.frame, 16); /* rows of cells are then longer than the spans that batches know */
        batch_fixture b = make_batch(&x, 500, run < 2 ? 0.0f : 0.3f);
        pass_forward(sets[run % 2], &x, &b.work, &b.batch);
        for (uint32_t k = 0; k < x.model.desc.block_count; k++)
            found += check_hits(&x, &b, k);
        assert_true(found > 100);
        free_batch(&b);
    }
    free_fixture(&x);
}

static void test_batches_hold_every_so_many_samples_in_the_order_of_cells(void **state) {
    fixture x = two_balls(30, 2, 1);
    batch_fixture b = make_batch(&x, 500, 0.0f);
    const uint32_t wanted[] = {100, 40};
    (void)state;
    for (int i = 0; i < 2; i++) {
        nsdf_block_batch_fill(&b.batch, &b.work, &x.frame, &b.samples, 3, 5, wanted[i]);
        assert_int_equal(b.batch.count, wanted[i]);
        for (uint32_t n = 0; n < wanted[i]; n++) {
            uint32_t found = 0;
            for (uint32_t p = 0; p < b.batch.count; p++)
                found += b.batch.point[p][0] == b.samples.x[3 + 5 * n] &&
                         b.batch.point[p][1] == b.samples.y[3 + 5 * n] &&
                         b.batch.point[p][2] == b.samples.z[3 + 5 * n] && b.batch.point[p][3] == b.samples.d[3 + 5 * n];
            assert_int_equal(found, 1);
        }
        for (uint32_t p = 1; p < b.batch.count; p++) { /* cells ascend along z first */
            const float cell = 1.0f / x.frame.inverse_cell;
            assert_true(b.batch.point[p][2] > b.batch.point[p - 1][2] - cell);
        }
    }
    free_batch(&b);
    free_fixture(&x);
}

/* The loss sum of f over the points, whose gradient the passes give. */
static double sum_of_values(fixture *x, const nsdf_block_batch *b) {
    double sum = 0.0;
    uint32_t hits;
    nsdf_block_frame_compose(&x->frame, &x->model, x->model.values, 0.3);
    for (uint32_t i = 0; i < b->count; i++) {
        const double f = field_at(&x->frame, &x->model, b->point[i], &hits);
        sum += hits > 0 ? f : 0.0;
    }
    return sum;
}

/* Gradients of that sum. */
static void run_passes(const nsdf_block_passes *passes, fixture *x, batch_fixture *b, nsdf_block_gradient *sums) {
    const uint32_t degree = x->model.desc.degree;
    pass_forward(passes, x, &b->work, &b->batch);
    for (uint32_t i = 0; i < b->batch.count; i++) {
        float *sum = b->work.sum[i];
        sum[1] = sum[0] > 0.0f ? sum[1] / sum[0] : 0.0f;
        sum[0] = sum[0] > 0.0f ? 1.0f / sum[0] : 0.0f;
    }
    for (uint32_t k = 0; k < x->model.desc.block_count; k++)
        passes->backward(&b->work, k, degree, x->frame.terms[k], &sums[k]);
}

static void test_gradients_of_coefficients_are_those_of_the_field(void **state) {
    enum { COUNT = 400, BLOCKS = 40 };
    (void)state;
    for (uint32_t degree = 1; degree <= 3; degree++) {
        fixture x = two_balls(BLOCKS, 2, degree);
        nsdf_block_model *m = &x.model;
        nsdf_block_gradient sums[BLOCKS];
        float *gradient = calloc(m->value_count, sizeof *gradient);
        set_noise(&x);
        batch_fixture b = make_batch(&x, COUNT, 0.1f);
        run_passes(nsdf_block_passes_select(), &x, &b, sums);
        for (uint32_t k = 0; k < BLOCKS; k++)
            nsdf_block_add_gradient(m, k, sums[k].terms, gradient);
        for (size_t i = m->term_offset; i < m->value_count; i += 7) {
            const float kept = m->values[i];
            m->values[i] = kept + 0.01f;
            const double up = sum_of_values(&x, &b.batch);
            m->values[i] = kept - 0.01f;
            const double slope = (up - sum_of_values(&x, &b.batch)) / 0.02;
            m->values[i] = kept;
            assert_true(fabs(slope - (double)gradient[i]) < 2e-3 + 2e-3 * fabs(slope));
        }
        free(gradient);
        free_batch(&b);
        free_fixture(&x);
    }
}

/* The block's polynomial at u. */
static double polynomial_at(const nsdf_block_model *m, uint32_t block, const float u[3]) {
    float basis[NSDF_BLOCK_MOST_TERMS];
    double value = 0.0;
    uint32_t n = 0;
    nsdf_block_basis(m->desc.degree, u, basis);
    for (uint32_t d = 0; d <= m->desc.degree; d++)
        for (uint32_t i = 0; i < nsdf_degree_terms(d); i++)
            value += (double)m->values[nsdf_block_degree_offset(m, block, d) + i] * (double)basis[n++];
    return value;
}

/* dL/du of (1 - |u|^2)^2 (p(u) - f), times the share; polynomials of degree 3 are nearly straight over so short a way.
 */
static void point_gradient(const nsdf_block_model *m, uint32_t block, const float u[3], double root, const float sum[2],
                           double g[3]) {
    const double h = 0.01, away = polynomial_at(m, block, u) - (double)sum[1];
    for (int axis = 0; axis < 3; axis++) {
        float up[3] = {u[0], u[1], u[2]}, down[3] = {u[0], u[1], u[2]};
        up[axis] += (float)h;
        down[axis] -= (float)h;
        const double slope = (polynomial_at(m, block, up) - polynomial_at(m, block, down)) / (2.0 * h);
        g[axis] = (double)sum[0] * (root * root * slope - 4.0 * root * (double)u[axis] * away);
    }
}

static void check_pose_sums(const fixture *x, const batch_fixture *b, uint32_t block, const nsdf_block_gradient *sums) {
    double moment[12] = {0.0}, size = 0.0;
    for (uint32_t i = 0; i < b->batch.count; i++) {
        float u[3];
        double g[3];
        const double root = to_ball(&x->frame, block, b->batch.point[i], u);
        if (!(root > 1e-4))
            continue;
        point_gradient(&x->model, block, u, root, b->work.sum[i], g);
        for (int n = 0; n < 12; n++)
            moment[n] += g[n / 4] * (n % 4 < 3 ? (double)u[n % 4] : 1.0);
        for (int axis = 0; axis < 3; axis++)
            size += fabs(g[axis]);
    }
    for (int i = 0; i < 12; i++)
        assert_true(fabs((double)sums->moment[i / 4][i % 4] - moment[i]) < 1e-4 + 2e-3 * size);
}

/* Slopes and moments from the definition, in double. */
static void test_gradients_of_poses_are_those_of_the_sums(void **state) {
    enum { COUNT = 600, BLOCKS = 40 };
    (void)state;
    for (uint32_t degree = 1; degree <= 3; degree++) {
        fixture x = two_balls(BLOCKS, 2, degree);
        nsdf_block_gradient sums[BLOCKS];
        set_noise(&x);
        batch_fixture b = make_batch(&x, COUNT, 0.1f);
        run_passes(nsdf_block_passes_select(), &x, &b, sums);
        for (uint32_t k = 0; k < BLOCKS; k++)
            check_pose_sums(&x, &b, k, &sums[k]);
        free_batch(&b);
        free_fixture(&x);
    }
}

/* f and dL/df / weight of a point, by the definition in block_fit.c. */
static void check_loss(const nsdf_block_loss *loss, const float before[2], float d, const float after[2]) {
    if (!(before[0] > 0.0f)) {
        assert_true(after[0] == 0.0f && after[1] == 0.0f);
        return;
    }
    const float f = before[1] / before[0], size = fabsf(d), side = d < 0.0f ? -f : f;
    const float weight = side < loss->safe_share * size ? 1.0f : loss->weight_distance / (loss->weight_distance + size);
    const float share = (f > d ? 1.0f : -1.0f) * loss->scale * weight / before[0];
    assert_true(after[1] == f && fabsf(after[0] - share) <= 1e-6f * fabsf(share));
}

static void test_the_loss_is_differentiated(void **state) {
    const nsdf_block_passes *sets[] = {nsdf_block_passes_generic(), nsdf_block_passes_select()};
    const nsdf_block_loss loss = {0.001f, 0.005f, 0.25f, 0.01f};
    fixture x = two_balls(60, 2, 2);
    (void)state;
    set_noise(&x);
    for (int t = 0; t < 2; t++) {
        batch_fixture b = make_batch(&x, 700, 0.0f);
        pass_forward(sets[t], &x, &b.work, &b.batch);
        float(*before)[2] = malloc(sizeof *before * b.batch.count);
        double error = 0.0;
        uint64_t near = 0, held = 0;
        memcpy(before, b.work.sum, sizeof *before * b.batch.count);
        const nsdf_block_loss_sums sums = sets[t]->differentiate(&b.work, &b.batch, &loss);
        for (uint32_t i = 0; i < b.batch.count; i++) {
            const float d = b.batch.point[i][3];
            check_loss(&loss, before[i], d, b.work.sum[i]);
            held += before[i][0] > 0.0f;
            near += before[i][0] > 0.0f && fabsf(d) < 0.01f;
            error += before[i][0] > 0.0f && fabsf(d) < 0.01f ? fabs((double)(b.work.sum[i][1] - d)) : 0.0;
        }
        assert_true(sums.count == held && held > 50 && held < b.batch.count && sums.near_count == near && near > 20);
        assert_true(fabs(sums.near_error - error) < 1e-5 * error);
        free(before);
        free_batch(&b);
    }
    free_fixture(&x);
}

static void test_passes_of_all_instruction_sets_give_the_same_bits(void **state) {
    enum { COUNT = 1000, BLOCKS = 60 };
    const nsdf_block_passes *sets[3] = {nsdf_block_passes_generic(), NULL, nsdf_block_passes_select()};
    (void)state;
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2"))
        sets[1] = nsdf_block_passes_avx2();
#endif
    for (uint32_t degree = 0; degree <= 3; degree++) {
        fixture x = two_balls(BLOCKS, 2, degree);
        set_noise(&x);
        batch_fixture b = make_batch(&x, COUNT, 0.1f);
        nsdf_block_gradient one[BLOCKS], other[BLOCKS];
        run_passes(sets[0], &x, &b, one);
        for (int t = 1; t < 3; t++) {
            if (!sets[t])
                continue;
            uint16_t *near = malloc(b.batch.first[BLOCKS] * sizeof *near);
            memcpy(near, b.batch.near, b.batch.first[BLOCKS] * sizeof *near);
            assert_int_equal(nsdf_block_batch_list(&b.batch, &b.work, sets[t], &x.frame,
                                                   (const float(*)[12])x.frame.map, (const float(*)[6])x.frame.reach,
                                                   NULL, BLOCKS, 0.1f),
                             0);
            assert_memory_equal(near, b.batch.near, b.batch.first[BLOCKS] * sizeof *near);
            run_passes(sets[t], &x, &b, other);
            assert_memory_equal(one, other, sizeof one);
            free(near);
        }
        free_batch(&b);
        free_fixture(&x);
    }
}

/* ---- Batches that are kept ------------------------------------------------------------------------------- */

/* How often the most and the least moved of the blocks were found anew. */
static void stamp_range(const nsdf_block_reference *r, uint32_t blocks, uint32_t range[2]) {
    range[0] = UINT32_MAX;
    range[1] = 0;
    for (uint32_t k = 0; k < blocks; k++) {
        range[0] = r->stamp[k] < range[0] ? r->stamp[k] : range[0];
        range[1] = r->stamp[k] > range[1] ? r->stamp[k] : range[1];
    }
}

/* While blocks move on, a little or a lot, kept batches find what batches made anew find, bit for bit. */
static void test_kept_batches_find_what_new_ones_find(void **state) {
    enum { FRAMES = 2, BLOCKS = 60, WANTED = 300 };
    fixture x = two_balls(BLOCKS, 2, 2);
    const nsdf_block_passes *passes = nsdf_block_passes_select();
    const float *radii = values_of(&x.model, NSDF_BLOCK_RADII);
    nsdf_sample_set sets[FRAMES];
    nsdf_block_cache kept, none;
    nsdf_block_work works[2];
    nsdf_block_batch own[2];
    uint32_t stamps[2][2] = {{0}, {0}};
    (void)state;
    for (uint32_t f = 0; f < FRAMES; f++)
        make_samples(&sets[f], 1000 + 400 * f, 0.5f, f);
    assert_int_equal(nsdf_block_cache_create(&kept, sets, FRAMES, WANTED, BLOCKS, &x.frame, 1u << 24), 0);
    assert_int_equal(nsdf_block_cache_create(&none, sets, FRAMES, WANTED, BLOCKS, &x.frame, 1000), 0);
    assert_true(kept.batches && !none.batches);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(nsdf_block_work_create(&works[i], WANTED, BLOCKS, &x.frame), 0);
        assert_int_equal(nsdf_block_batch_create(&own[i], WANTED, BLOCKS, &x.frame), 0);
    }
    for (uint32_t step = 0; step < 40; step++) {
        const uint32_t frame = step % FRAMES, batches = nsdf_block_cache_batches(&kept, frame);
        nsdf_block_frame_compose(&x.frame, &x.model, x.model.values,
                                 0.3 + 0.4 * frame + (step < 30 ? 1e-4 : 1e-2) * step);
        const nsdf_block_batch *a = nsdf_block_cache_take(&kept, frame, step / 2 % batches, step % 7 != 6, &x.frame,
                                                          radii, passes, &works[0], &own[0]);
        const nsdf_block_batch *b =
            nsdf_block_cache_take(&none, frame, step / 2 % batches, 1, &x.frame, radii, passes, &works[1], &own[1]);
        assert_true(batches == 3 + frame && a && b && b == &own[1] && (a == &own[0]) == (step % 7 == 6));
        pass_forward(passes, &x, &works[0], a);
        pass_forward(passes, &x, &works[1], b);
        assert_memory_equal(works[0].first, works[1].first, (BLOCKS + 1) * sizeof(uint32_t));
        assert_true(works[0].first[BLOCKS] > 100);
        assert_memory_equal(works[0].point, works[1].point, works[0].first[BLOCKS] * sizeof(uint32_t));
        for (int i = 0; i < NSDF_HIT_ARRAYS; i++)
            assert_memory_equal(works[0].hit[i], works[1].hit[i], works[0].first[BLOCKS] * sizeof(float));
        stamp_range(&kept.references[0], BLOCKS, stamps[step >= 30]);
    }
    /* Small moves need no new candidates, large ones do, of the blocks that move most. */
    assert_true(stamps[0][0] == 1 && stamps[0][1] == 1);
    assert_true(stamps[1][1] > 1 && stamps[1][0] < stamps[1][1]);
    for (int i = 0; i < 2; i++) {
        nsdf_block_work_free(&works[i]);
        nsdf_block_batch_free(&own[i]);
        nsdf_sample_set_free(&sets[i]);
    }
    nsdf_block_cache_free(&kept);
    nsdf_block_cache_free(&none);
    free_fixture(&x);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_balls_find_their_points),
        cmocka_unit_test(test_batches_hold_every_so_many_samples_in_the_order_of_cells),
        cmocka_unit_test(test_gradients_of_coefficients_are_those_of_the_field),
        cmocka_unit_test(test_gradients_of_poses_are_those_of_the_sums),
        cmocka_unit_test(test_the_loss_is_differentiated),
        cmocka_unit_test(test_passes_of_all_instruction_sets_give_the_same_bits),
        cmocka_unit_test(test_kept_batches_find_what_new_ones_find),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
