/* Moving blocks in the decoder, against the definition evaluated in double. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "block_kernels.h"
#include "block_samples.h"
#include "cpu.h"
#include "mesher.h"
#include "nsdf/decoder.h"
#include "segment_field.h"

static const float low[3] = {-0.5f, -0.5f, -0.5f}, high[3] = {0.5f, 0.5f, 0.5f};

typedef struct {
    nsdf_blocks blocks;
    void *storage;
} opened;

/* Storage of exactly the size asked for, so that ASan sees any access beyond. */
static opened open_blocks(const sample_blocks *s) {
    opened o;
    o.storage = aligned_alloc(64, (size_t)nsdf_blocks_storage(&s->desc));
    assert_non_null(o.storage);
    nsdf_blocks_init(&o.blocks, &s->desc, s->values, o.storage);
    return o;
}

static float value_at(const nsdf_blocks *b, float x, float y, float z) {
    const float xyz[3] = {x, y, z};
    float value = 0.0f;
    nsdf_blocks_evaluate(b, nsdf_block_kernels_c(), 1, 1, xyz, &value, NULL);
    return value;
}

/* All tables that this machine runs, plain C first. */
typedef struct {
    const nsdf_block_kernels *list[3];
    int count;
} tables;

static tables find_tables(void) {
    tables t = {{nsdf_block_kernels_c()}, 1};
    const uint32_t features = nsdf_cpu_features();
    if ((features & NSDF_CPU_AVX2) && nsdf_block_kernels_avx2())
        t.list[t.count++] = nsdf_block_kernels_avx2();
    if ((features & NSDF_CPU_AVX512) && nsdf_block_kernels_avx512())
        t.list[t.count++] = nsdf_block_kernels_avx512();
    return t;
}

/* ---- Against the definition ------------------------------------------------------------------------------ */

typedef struct {
    int inside, outside, beyond, negative; /* beyond enough, and inside the surface, of those outside the balls */
} tally;

/* Central differences of the definition; returns whether all points around are of the same, safe case. */
static int reference_gradient(const sample_blocks *s, double t, const double x[3], double gradient[3]) {
    const double h = 1e-6;
    int delicate, inside, fine = 1;
    for (int k = 0; k < 3; k++) {
        double p[3] = {x[0], x[1], x[2]};
        p[k] = x[k] + h;
        gradient[k] = reference_blocks(s, t, p, &delicate, &inside) / (2.0 * h);
        fine &= !delicate;
        p[k] = x[k] - h;
        gradient[k] -= reference_blocks(s, t, p, &delicate, &inside) / (2.0 * h);
        fine &= !delicate;
    }
    return fine;
}

static void compare_at(const sample_blocks *s, const nsdf_blocks *b, double t, const float at[3], tally *n) {
    const double x[3] = {(double)at[0], (double)at[1], (double)at[2]};
    double slope[3];
    int delicate, inside;
    float value = 0.0f, gradient[3] = {0.0f, 0.0f, 0.0f};
    const double expected = reference_blocks(s, t, x, &delicate, &inside);
    if (delicate || !reference_gradient(s, t, x, slope))
        return;
    nsdf_blocks_evaluate(b, nsdf_block_kernels_c(), 1, 1, at, &value, gradient);
    assert_true(fabs((double)value - expected) < 2e-6);
    for (int k = 0; k < 3; k++)
        assert_true(fabs((double)gradient[k] - slope[k]) < 2e-4 * (1.0 + fabs(slope[k])));
    *(inside ? &n->inside : &n->outside) += 1;
    n->negative += !inside && expected < 0.0;
}

static void compare_everywhere(const sample_blocks *s, uint64_t random, tally *n) {
    opened o = open_blocks(s);
    for (int time = 0; time < 5; time++) {
        nsdf_blocks_compose(&o.blocks, 0.25 * time, NULL);
        for (int point = 0; point < 80; point++) {
            const float x[3] = {sample_between(&random, -0.35, 0.35), sample_between(&random, -0.35, 0.35),
                                sample_between(&random, -0.35, 0.35)};
            compare_at(s, &o.blocks, 0.25 * time, x, n);
        }
    }
    free(o.storage);
}

static void test_values_and_gradients_are_those_of_the_definition(void **state) {
    static const sample_shape shapes[] = {{1, 1, 1, 0, 0},  {9, 3, 2, 1, 0},  {20, 4, 3, 2, 6},
                                          {20, 5, 4, 3, 4}, {60, 7, 8, 3, 9}, {200, 7, 2, 2, 5}};
    (void)state;
    tally n = {0, 0, 0, 0};
    for (uint64_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        sample_blocks s = sample_random(shapes[i], i + 1);
        compare_everywhere(&s, 50 + i, &n);
        sample_free(&s);
    }
    sample_blocks shell = sample_shell(400);
    compare_everywhere(&shell, 60, &n);
    sample_free(&shell);
    assert_true(n.inside > 400 && n.outside > 400 && n.negative > 20);
}

static void test_values_are_added_in_strided_rows(void **state) {
    enum { COUNT = 5, STRIDE = 8 };
    float xyz[3 * STRIDE], value[STRIDE], slope[3 * STRIDE];
    sample_blocks s = sample_random((sample_shape){20, 2, 2, 2, 4}, 5);
    opened o = open_blocks(&s);
    uint64_t random = 4;
    (void)state;
    for (int i = 0; i < 3 * STRIDE; i++) {
        xyz[i] = sample_between(&random, -0.4, 0.4);
        slope[i] = 2.0f;
        value[i % STRIDE] = 1.0f;
    }
    nsdf_blocks_compose(&o.blocks, 0.3, NULL);
    nsdf_blocks_evaluate(&o.blocks, nsdf_block_kernels_c(), COUNT, STRIDE, xyz, value, slope);
    for (int i = 0; i < STRIDE; i++) {
        const float one[3] = {xyz[i], xyz[STRIDE + i], xyz[2 * STRIDE + i]};
        float f = 1.0f, g[3] = {2.0f, 2.0f, 2.0f};
        if (i < COUNT)
            nsdf_blocks_evaluate(&o.blocks, nsdf_block_kernels_c(), 1, 1, one, &f, g);
        assert_true(value[i] == f);
        for (int k = 0; k < 3; k++)
            assert_true(slope[k * STRIDE + i] == g[k]);
    }
    free(o.storage);
    sample_free(&s);
}

static void test_terms_stand_by_degree_then_falling_powers(void **state) {
    uint32_t n = 0;
    (void)state;
    for (int d = 0; d <= 3; d++)
        for (int a = d; a >= 0; a--)
            for (int b = d - a; b >= 0; b--)
                assert_int_equal(nsdf_block_term((uint32_t)a, (uint32_t)b, (uint32_t)(d - a - b)), n++);
    assert_int_equal(n, NSDF_BLOCK_TERMS);
}

/* ---- Rules ----------------------------------------------------------------------------------------------- */

/* Two balls in one place, constant 1 and 3: their mean tells the second one's life. */
static void assert_life(const sample_blocks *s, double u, double life) {
    opened o = open_blocks(s);
    nsdf_blocks_compose(&o.blocks, u, NULL);
    assert_true(fabs((double)value_at(&o.blocks, 0.01f, 0.02f, 0.03f) - (1.0 + 3.0 * life) / (1.0 + life)) < 1e-6);
    free(o.storage);
}

static void test_blocks_fade_in_and_out_inside_their_life(void **state) {
    sample_blocks s = sample_resting((sample_shape){2, 1, 1, 0, 0}, 0.25f);
    float *life = sample_tensor_values(&s, NSDF_BLOCK_LIVES) + 2;
    (void)state;
    sample_tensor_values(&s, NSDF_BLOCK_COEFFICIENTS)[0] = 1.0f;
    sample_tensor_values(&s, NSDF_BLOCK_COEFFICIENTS)[1] = 3.0f;
    life[0] = 0.25f;
    life[1] = 0.75f;
    s.desc.fade = 0.125f;
    static const double expected[][2] = {{0.0, 0.0},    {0.2499, 0.0}, {0.25, 0.0},   {0.28125, 0.25},
                                         {0.3125, 0.5}, {0.375, 1.0},  {0.5, 1.0},    {0.625, 1.0},
                                         {0.6875, 0.5}, {0.75, 0.0},   {0.7501, 0.0}, {1.0, 0.0}};
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++)
        assert_life(&s, expected[i][0], expected[i][1]);
    s.desc.fade = 0.0f; /* whole at both ends of the life, and not there beyond */
    assert_life(&s, 0.25, 1.0);
    assert_life(&s, 0.75, 1.0);
    assert_life(&s, 0.2499, 0.0);
    s.desc.fade = 1.0f; /* a life shorter than both fades never is whole */
    assert_life(&s, 0.5, 0.25);
    life[0] = 0.0f; /* lives that reach the segment's ends do not fade there */
    assert_life(&s, 0.0, 0.75);
    life[1] = 1.0f;
    assert_life(&s, 0.0, 1.0);
    assert_life(&s, 1.0, 1.0);
    sample_free(&s);
}

static void test_a_pose_without_inverse_takes_its_block_away(void **state) {
    sample_blocks s = sample_resting((sample_shape){2, 2, 1, 0, 0}, 0.25f);
    float *poses = sample_tensor_values(&s, NSDF_BLOCK_POSES);
    (void)state;
    sample_tensor_values(&s, NSDF_BLOCK_COEFFICIENTS)[0] = 1.0f;
    sample_tensor_values(&s, NSDF_BLOCK_COEFFICIENTS)[1] = 3.0f;
    sample_tensor_values(&s, NSDF_BLOCK_BONES)[1] = 1.0f;
    assert_life(&s, 0.5, 1.0);
    poses[12 + 10] = 0.0f; /* bone 1 is flat */
    assert_life(&s, 0.5, 0.0);
    poses[12 + 10] = 0.5f;
    poses[12 + 8] = poses[12 + 4] = 0.5f;                                  /* rows 2 and 3 ... */
    poses[12 + 9] = poses[12 + 5] = poses[12 + 6] = poses[12 + 10] = 0.5f; /* ... are the same */
    assert_life(&s, 0.5, 0.0);
    for (int i = 0; i < 24; i++)
        poses[i] = 0.0f;
    opened o = open_blocks(&s);
    nsdf_blocks_compose(&o.blocks, 0.5, NULL);
    assert_true(value_at(&o.blocks, 0.0f, 0.0f, 0.0f) == 64.0f);
    free(o.storage);
    sample_free(&s);
}

static void assert_far(const nsdf_blocks *b, const float x[3], double size, double slope_x) {
    float value = 0.0f, slope[3] = {0.0f, 0.0f, 0.0f};
    nsdf_blocks_evaluate(b, nsdf_block_kernels_c(), 1, 1, x, &value, slope);
    assert_true(fabs((double)value - size) < 1e-6 * (1.0 + size));
    assert_true(fabs((double)slope[0] - slope_x) < 1e-6);
}

static void test_far_from_all_balls_the_nearest_centre_counts(void **state) {
    sample_blocks s = sample_resting((sample_shape){2, 2, 1, 0, 0}, 0.125f);
    float *poses = sample_tensor_values(&s, NSDF_BLOCK_POSES);
    (void)state;
    sample_tensor_values(&s, NSDF_BLOCK_CENTRES)[0] = -0.25f;
    sample_tensor_values(&s, NSDF_BLOCK_CENTRES)[3] = 0.25f;
    sample_tensor_values(&s, NSDF_BLOCK_RADII)[1] = 0.0625f;
    sample_tensor_values(&s, NSDF_BLOCK_BONES)[1] = 1.0f;
    opened o = open_blocks(&s);
    nsdf_blocks_compose(&o.blocks, 0.0, NULL);
    assert_far(&o.blocks, (float[3]){-0.0625f, 0.0f, 0.0f}, 0.1875 - 0.0625, 1.0);
    assert_far(&o.blocks, (float[3]){0.0625f, 0.0f, 0.0f}, 0.1875 - 0.03125, -1.0);
    assert_far(&o.blocks, (float[3]){0.0f, 0.0f, 0.0f}, 0.25 - 0.0625, 1.0); /* equally near: the first */
    assert_far(&o.blocks, (float[3]){0.25f, 0.0f, 63.9f}, 63.9 - 0.03125, 0.0);
    assert_true(value_at(&o.blocks, 0.25f, 0.0f, 64.2f) == 64.0f);
    assert_true(value_at(&o.blocks, 1e30f, 0.0f, 0.0f) == 64.0f);
    for (int i = 0; i < 11; i++)
        poses[12 + i] *= 0.25f; /* the second ball ends at a quarter of its radius, half way to the first one's place */
    nsdf_blocks_compose(&o.blocks, 0.0, NULL);
    const float x = 0.0625f + 0.02f; /* its centre moves to 0.0625 */
    assert_far(&o.blocks, (float[3]){x, 0.0f, 0.0f}, 0.015625, 0.0);
    assert_far(&o.blocks, (float[3]){x + 0.04f, 0.0f, 0.0f}, 0.06 - 0.03125, 1.0);
    free(o.storage);
    sample_free(&s);
}

static void test_blocks_around_a_point_make_it_negative(void **state) {
    sample_blocks s = sample_shell(100);
    float *slope = sample_tensor_values(&s, NSDF_BLOCK_COEFFICIENTS + 1);
    float *life = sample_tensor_values(&s, NSDF_BLOCK_LIVES);
    const double size = sample_shell_radius * (1.0 - 0.5 * sqrt(0.2));
    (void)state;
    opened o = open_blocks(&s);
    nsdf_blocks_compose(&o.blocks, 0.5, NULL);
    assert_true(fabs((double)value_at(&o.blocks, 0.0f, 0.0f, 0.0f) + size) < 1e-6);
    assert_true(value_at(&o.blocks, 0.4f, 0.0f, 0.0f) > 0.0f);
    for (size_t k = 0; k < 100; k++)
        life[2 * k] = 0.25f;
    s.desc.fade = 0.5f; /* they all are half there: one half in all, but for rounding */
    nsdf_blocks_compose(&o.blocks, 0.48, NULL);
    assert_true(value_at(&o.blocks, 0.0f, 0.0f, 0.0f) > 0.0f);
    nsdf_blocks_compose(&o.blocks, 0.52, NULL);
    assert_true(value_at(&o.blocks, 0.0f, 0.0f, 0.0f) < 0.0f);
    free(o.storage);
    for (size_t i = 0; i < 300; i++)
        slope[i] = 0.0f; /* without a direction they stand for nothing */
    o = open_blocks(&s);
    nsdf_blocks_compose(&o.blocks, 1.0, NULL);
    assert_true(fabs((double)value_at(&o.blocks, 0.0f, 0.0f, 0.0f) - size) < 1e-6);
    free(o.storage);
    sample_free(&s);
}

/* ---- Tables and tiles ------------------------------------------------------------------------------------ */

enum { TILE_FLOATS = 3 * NSDF_TILE };

/* Points within `reach` of one of the domain's, rows of NSDF_TILE. */
static void make_tile(uint64_t *random, double reach, float *xyz) {
    for (int axis = 0; axis < 3; axis++) {
        const double middle = (double)sample_between(random, -0.45, 0.45);
        for (int p = 0; p < NSDF_TILE; p++)
            xyz[axis * NSDF_TILE + p] = sample_between(random, middle - reach, middle + reach);
    }
}

typedef struct {
    float value[NSDF_TILE], slope[TILE_FLOATS];
} tile_result;

static tile_result evaluate_tile(const nsdf_blocks *b, const nsdf_block_kernels *kernels, const float *xyz) {
    tile_result r;
    float alone[NSDF_TILE] = {0.0f};
    memset(&r, 0, sizeof r);
    nsdf_blocks_evaluate(b, kernels, NSDF_TILE, NSDF_TILE, xyz, r.value, r.slope);
    nsdf_blocks_evaluate(b, kernels, NSDF_TILE, NSDF_TILE, xyz, alone, NULL);
    assert_memory_equal(alone, r.value, sizeof alone);
    return r;
}

static void assert_point(const tile_result *r, int p, float value, const float *slope, size_t stride) {
    assert_memory_equal(&r->value[p], &value, sizeof value);
    for (size_t axis = 0; axis < 3; axis++)
        assert_memory_equal(&r->slope[axis * NSDF_TILE + (size_t)p], &slope[axis * stride], sizeof *slope);
}

/* Every point by itself, and in a tile with corners of the domain, whose box may meet more balls than are listed. */
static void assert_company_does_not_matter(const nsdf_blocks *b, const nsdf_block_kernels *kernels, const float *xyz,
                                           const tile_result *expected) {
    float wide[TILE_FLOATS];
    memcpy(wide, xyz, sizeof wide);
    for (int axis = 0; axis < 3; axis++) {
        wide[axis * NSDF_TILE] = low[axis];
        wide[axis * NSDF_TILE + 1] = high[axis];
    }
    const tile_result scattered = evaluate_tile(b, kernels, wide);
    for (int p = 0; p < NSDF_TILE; p++) {
        const float one[3] = {xyz[p], xyz[NSDF_TILE + p], xyz[2 * NSDF_TILE + p]};
        float value = 0.0f, slope[3] = {0.0f, 0.0f, 0.0f};
        nsdf_blocks_evaluate(b, kernels, 1, 1, one, &value, slope);
        assert_point(expected, p, value, slope, 1);
        if (p >= 2)
            assert_point(expected, p, scattered.value[p], scattered.slope + p, NSDF_TILE);
    }
}

static void assert_tables_agree(const sample_blocks *s) {
    static const double reaches[] = {0.0, 0.02, 0.1, 0.5};
    const tables t = find_tables();
    opened o = open_blocks(s);
    uint64_t random = 3;
    for (int round = 0; round < 48; round++) {
        float xyz[TILE_FLOATS];
        nsdf_blocks_compose(&o.blocks, round / 47.0, NULL);
        make_tile(&random, reaches[round % 4], xyz);
        const tile_result expected = evaluate_tile(&o.blocks, t.list[0], xyz);
        for (int i = 0; i < t.count; i++) {
            const tile_result r = evaluate_tile(&o.blocks, t.list[i], xyz);
            assert_memory_equal(&r, &expected, sizeof r);
            assert_company_does_not_matter(&o.blocks, t.list[i], xyz, &expected);
        }
    }
    free(o.storage);
}

static void test_all_tables_and_tiles_give_the_same_bits(void **state) {
    (void)state;
    for (uint32_t degree = 0; degree <= 3; degree++) {
        sample_blocks s = sample_random((sample_shape){200, 5, 3, degree, 5}, 11 + degree);
        assert_tables_agree(&s);
        sample_free(&s);
    }
    sample_blocks shell = sample_shell(300);
    assert_tables_agree(&shell);
    sample_free(&shell);
}

/* More balls than are listed for points that are far apart, then for any points. */
static void test_results_do_not_depend_on_how_many_balls_are_near(void **state) {
    (void)state;
    sample_blocks many = sample_random((sample_shape){1500, 6, 3, 2, 5}, 2);
    assert_tables_agree(&many);
    float *radii = sample_tensor_values(&many, NSDF_BLOCK_RADII);
    for (int k = 0; k < 1500; k++)
        radii[k] *= 0.1f;
    radii[7] = 10.0f; /* one holds everything */
    assert_tables_agree(&many);
    for (int k = 0; k < NSDF_NEAR_MOST; k++)
        radii[5 * k] = 10.0f;
    assert_tables_agree(&many);
    sample_free(&many);
}

/* ---- Workers --------------------------------------------------------------------------------------------- */

/* Of blocks that are not there only that they are not counts. */
static void assert_same_blocks(const nsdf_blocks *a, const nsdf_blocks *b) {
    const uint32_t groups = nsdf_block_groups(a->desc->block_count), sets = nsdf_block_groups(groups);
    for (uint32_t k = 0; k < a->desc->block_count; k++) {
        assert_true(a->blocks[k].radius == b->blocks[k].radius);
        if (a->blocks[k].radius > 0.0f)
            assert_memory_equal(&a->blocks[k], &b->blocks[k], sizeof *a->blocks);
    }
    assert_memory_equal(a->groups, b->groups, groups * sizeof *a->groups);
    assert_memory_equal(a->boxes, b->boxes, groups * sizeof *a->boxes);
    assert_memory_equal(a->balls, b->balls, sets * sizeof *a->balls);
    assert_memory_equal(a->group_boxes, b->group_boxes, sets * sizeof *a->group_boxes);
}

/* What blocks are at a time is the same for any number of workers, and after other times. */
static void test_composing_does_not_depend_on_the_workers(void **state) {
    static const uint32_t counts[] = {1, 64, 65, 400};
    nsdf_memory memory;
    nsdf_tasks *tasks = NULL;
    (void)state;
    nsdf_memory_init(&memory, NULL, (uint64_t)1 << 30);
    assert_int_equal(nsdf_tasks_create(&memory, 3, NULL, &tasks), NSDF_OK);
    for (size_t n = 0; n < sizeof counts / sizeof *counts; n++) {
        sample_blocks s = sample_random((sample_shape){counts[n], 5, 3, 3, 5}, 30 + n);
        opened alone = open_blocks(&s), shared = open_blocks(&s);
        nsdf_blocks_compose(&shared.blocks, 0.9, tasks);
        for (int time = 0; time < 5; time++) {
            nsdf_blocks_compose(&alone.blocks, 0.2 * time, NULL);
            nsdf_blocks_compose(&shared.blocks, 0.2 * time, tasks);
            assert_same_blocks(&alone.blocks, &shared.blocks);
        }
        free(alone.storage);
        free(shared.storage);
        sample_free(&s);
    }
    nsdf_tasks_free(&tasks);
    assert_int_equal(memory.used, 0);
}

/* ---- Searches by groups ---------------------------------------------------------------------------------- */

static void assert_nearest(const nsdf_blocks *b, const nsdf_block_kernels *kernels, const float x[3]) {
    const uint32_t count = b->desc->block_count, groups = nsdf_block_groups(count);
    float least = 64.0f * 64.0f, square = 64.0f * 64.0f;
    uint32_t expected = groups * NSDF_BLOCK_GROUP;
    for (uint32_t k = 0; k < count; k++) {
        float d = 0.0f;
        for (int axis = 0; axis < 3; axis++) {
            const float along = b->groups[k / NSDF_BLOCK_GROUP].centre[axis][k % NSDF_BLOCK_GROUP] - x[axis];
            d += along * along;
        }
        expected = d < least ? k : expected;
        least = d < least ? d : least;
    }
    assert_int_equal(kernels->find_nearest(b->groups, b->balls, groups, x, &square), expected);
    assert_true(square == least);
}

/* Blocks within reach of a tile's box, and the nearest ones to its points among them, asked one by one. */
static void assert_listed(const nsdf_blocks *b, const nsdf_block_kernels *kernels, const float x[3][NSDF_TILE],
                          float reach) {
    const uint32_t groups = nsdf_block_groups(b->desc->block_count), none = 100000;
    float low_side[3], high_side[3];
    nsdf_near_blocks list;
    for (int axis = 0; axis < 3; axis++) {
        low_side[axis] = high_side[axis] = x[axis][0];
        for (int p = 1; p < NSDF_TILE; p++) {
            low_side[axis] = fminf(low_side[axis], x[axis][p]);
            high_side[axis] = fmaxf(high_side[axis], x[axis][p]);
        }
    }
    if (!kernels->list_centres(b->groups, b->balls, groups, low_side, high_side, reach, &list))
        return;
    for (uint32_t i = 1; i < list.count; i++)
        assert_true(list.number[i - 1] < list.number[i]);
    nsdf_blocks_describe(b, &list);
    for (int p = 0; p < NSDF_TILE; p++) {
        const float point[3] = {x[0][p], x[1][p], x[2][p]};
        float square = reach * reach, of_all = square;
        const uint32_t nearest = kernels->find_nearest(b->groups, b->balls, groups, point, &of_all);
        const uint32_t listed = kernels->nearest_listed(&list, none, point, &square);
        assert_int_equal(listed, nearest == groups * NSDF_BLOCK_GROUP ? none : nearest);
        assert_true(square == of_all);
    }
}

/* Which balls' boxes a tile's box meets, asked one by one. */
static void assert_met(const nsdf_blocks *b, const nsdf_block_kernels *kernels, const float x[3][NSDF_TILE]) {
    uint32_t list[1000 + 2 * NSDF_BLOCK_GROUP], count = 0;
    const uint32_t groups = nsdf_block_groups(b->desc->block_count);
    const float *const points[3] = {x[0], x[1], x[2]};
    const uint32_t met = kernels->meet(b->boxes, b->group_boxes, groups, points, NSDF_TILE, 1000, list);
    for (uint32_t k = 0; k < b->desc->block_count; k++) {
        int apart = !(b->blocks[k].radius > 0.0f);
        for (int axis = 0; axis < 3; axis++) {
            float low_side = x[axis][0], high_side = x[axis][0];
            for (int p = 1; p < NSDF_TILE; p++) {
                low_side = fminf(low_side, x[axis][p]);
                high_side = fmaxf(high_side, x[axis][p]);
            }
            const nsdf_block_boxes *boxes = &b->boxes[k / NSDF_BLOCK_GROUP];
            apart |= boxes->low[axis][k % NSDF_BLOCK_GROUP] > high_side;
            apart |= boxes->high[axis][k % NSDF_BLOCK_GROUP] < low_side;
        }
        if (!apart)
            assert_true(count < met && list[count++] == k);
    }
    assert_int_equal(count, met);
    if (met > 0) {
        assert_int_equal(kernels->meet(b->boxes, b->group_boxes, groups, points, NSDF_TILE, met, list), met);
        assert_int_equal(kernels->meet(b->boxes, b->group_boxes, groups, points, NSDF_TILE, met - 1, list), met);
    }
}

/* Of many groups, of one that is not full, and with blocks that are not there. */
static void test_searches_by_groups_leave_nothing_out(void **state) {
    static const uint32_t counts[] = {1, 15, 16, 17, 200, 600};
    const tables t = find_tables();
    uint64_t random = 77;
    (void)state;
    for (size_t n = 0; n < sizeof counts / sizeof *counts; n++) {
        sample_blocks s = sample_random((sample_shape){counts[n], 5, 3, 1, 5}, 5 + n);
        opened o = open_blocks(&s);
        for (int round = 0; round < 30; round++) {
            const float size = round % 3 == 0 ? 0.02f : round % 3 == 1 ? 0.3f : 3.0f;
            float x[3][NSDF_TILE], point[3];
            nsdf_blocks_compose(&o.blocks, round / 29.0, NULL);
            for (int axis = 0; axis < 3; axis++) {
                point[axis] = (float)sample_between(&random, -0.6, 0.6);
                for (int p = 0; p < NSDF_TILE; p++)
                    x[axis][p] = point[axis] + size * (float)sample_between(&random, -0.5, 0.5);
            }
            for (int i = 0; i < t.count; i++) {
                assert_nearest(&o.blocks, t.list[i], point);
                assert_met(&o.blocks, t.list[i], (const float(*)[NSDF_TILE])x);
                assert_listed(&o.blocks, t.list[i], (const float(*)[NSDF_TILE])x, round % 2 ? 0.05f : 0.5f);
            }
        }
        free(o.storage);
        sample_free(&s);
    }
}

/* Halves the way from the middle of a shell to a point outside until no float lies between the two sides: there the
 * winding number is 1/2 but for rounding. */
static void test_tables_agree_about_winding_numbers_of_a_half(void **state) {
    const tables t = find_tables();
    sample_blocks s = sample_shell(300);
    opened o = open_blocks(&s);
    const uint32_t groups = nsdf_block_groups(o.blocks.desc->block_count);
    uint64_t random = 11;
    (void)state;
    nsdf_blocks_compose(&o.blocks, 0.0, NULL);
    for (int way = 0; way < 100; way++) {
        float in[3] = {0.0f, 0.0f, 0.0f}, out[3], middle[3];
        for (int axis = 0; axis < 3; axis++)
            out[axis] = (float)sample_between(&random, 0.55, 0.9) * (way >> axis & 1 ? -1.0f : 1.0f);
        assert_true(t.list[0]->is_wound(o.blocks.groups, groups, in));
        assert_false(t.list[0]->is_wound(o.blocks.groups, groups, out));
        for (int step = 0; step < 30; step++) {
            for (int axis = 0; axis < 3; axis++)
                middle[axis] = 0.5f * (in[axis] + out[axis]);
            const int wound = t.list[0]->is_wound(o.blocks.groups, groups, middle);
            for (int i = 1; i < t.count; i++)
                assert_int_equal(t.list[i]->is_wound(o.blocks.groups, groups, middle), wound);
            memcpy(wound ? in : out, middle, sizeof middle);
        }
    }
    free(o.storage);
    sample_free(&s);
}

static void assert_measure(const sample_blocks *s, const nsdf_blocks *b, double u, const float *xyz, float enough,
                           tally *n) {
    const tables t = find_tables();
    const tile_result r = evaluate_tile(b, t.list[0], xyz);
    for (int i = 0; i < t.count; i++) {
        float size[NSDF_TILE];
        uint8_t exact[NSDF_TILE];
        nsdf_blocks_measure(b, t.list[i], NSDF_TILE, NSDF_TILE, xyz, enough, size, exact);
        for (size_t p = 0; p < NSDF_TILE; p++) {
            const double x[3] = {(double)xyz[p], (double)xyz[NSDF_TILE + p], (double)xyz[2 * NSDF_TILE + p]};
            int delicate, inside;
            reference_blocks(s, u, x, &delicate, &inside);
            if (delicate)
                continue;
            const int beyond = !inside && fabsf(r.value[p]) > enough;
            assert_int_equal(exact[p], inside);
            assert_true(beyond ? size[p] > enough : size[p] == (inside ? r.value[p] : fabsf(r.value[p])));
            *(inside ? &n->inside : beyond ? &n->beyond : &n->outside) += 1;
            n->negative += !inside && r.value[p] < 0.0f;
        }
    }
}

static void test_measures_are_values_without_the_sign_outside(void **state) {
    sample_blocks samples[] = {sample_random((sample_shape){60, 5, 3, 3, 5}, 4), sample_shell(100)};
    uint64_t random = 2;
    tally n = {0, 0, 0, 0};
    (void)state;
    for (int i = 0; i < 2; i++) {
        opened o = open_blocks(&samples[i]);
        for (int round = 0; round < 20; round++) {
            float xyz[TILE_FLOATS];
            nsdf_blocks_compose(&o.blocks, round / 19.0, NULL);
            make_tile(&random, round % 2 ? 0.05 : 0.4, xyz);
            assert_measure(&samples[i], &o.blocks, round / 19.0, xyz, round % 3 ? 1.0f : 0.01f, &n);
        }
        free(o.storage);
        sample_free(&samples[i]);
    }
    const int kinds = find_tables().count;
    assert_true(n.inside > 60 * kinds && n.outside > 60 * kinds && n.negative > 15 * kinds && n.beyond > 20 * kinds);
}

/* ---- Meshes ---------------------------------------------------------------------------------------------- */

typedef struct {
    nsdf_memory memory;
    nsdf_tasks *tasks;
    nsdf_mesher *mesher;
    nsdf_mesh_storage quick, full;
} bench;

static void run_mesher(bench *b, const nsdf_field *field, float bound, nsdf_mesh_storage *mesh) {
    nsdf_mesher_job job;
    memset(&job, 0, sizeof job);
    job.field = *field;
    memcpy(job.domain_min, low, sizeof low);
    memcpy(job.domain_max, high, sizeof high);
    job.resolution = 70;
    job.bound = bound;
    job.normals = 1;
    job.projection = 2;
    job.scale = 1.0;
    assert_int_equal(nsdf_mesher_run(b->mesher, &job, &b->memory, mesh), NSDF_OK);
}

static void assert_measuring_changes_nothing(bench *b, nsdf_field field, float bound) {
    assert_non_null(field.measure);
    run_mesher(b, &field, bound, &b->quick);
    field.measure = NULL;
    run_mesher(b, &field, bound, &b->full);
    assert_true(b->full.triangle_count > 1000);
    assert_int_equal(b->quick.vertex_count, b->full.vertex_count);
    assert_int_equal(b->quick.triangle_count, b->full.triangle_count);
    const size_t vertices = (size_t)3 * b->full.vertex_count * sizeof(float);
    assert_memory_equal(b->quick.positions, b->full.positions, vertices);
    assert_memory_equal(b->quick.normals, b->full.normals, vertices);
    assert_memory_equal(b->quick.indices, b->full.indices, (size_t)3 * b->full.triangle_count * sizeof(uint32_t));
}

static void mesh_blocks(bench *b, const sample_blocks *s, float bound) {
    opened o = open_blocks(s);
    const tables t = find_tables();
    nsdf_segment_part part = {.kind = NSDF_PART_BLOCKS};
    const nsdf_segment segment = {.part_count = 1, .parts = &part};
    nsdf_blocks_compose(&o.blocks, 0.5, NULL);
    part.at.blocks = o.blocks;
    for (int i = 0; i < t.count; i++) {
        nsdf_segment_field field = {.segments = {&segment}, .share = {1.0f}, .block_kernels = t.list[i]};
        assert_measuring_changes_nothing(b, nsdf_segment_field_view(&field), bound);
    }
    free(o.storage);
}

static void test_the_mesh_is_the_same_without_measuring(void **state) {
    bench b;
    (void)state;
    memset(&b, 0, sizeof b);
    nsdf_memory_init(&b.memory, NULL, (uint64_t)1 << 30);
    assert_int_equal(nsdf_tasks_create(&b.memory, 2, NULL, &b.tasks), NSDF_OK);
    assert_int_equal(nsdf_mesher_create(&b.memory, b.tasks, &b.mesher), NSDF_OK);
    sample_blocks shell = sample_shell(200), random = sample_random((sample_shape){60, 5, 3, 3, 5}, 4);
    mesh_blocks(&b, &shell, 1.25f);
    mesh_blocks(&b, &random, 8.0f); /* its slopes are not those of a distance */
    sample_free(&shell);
    sample_free(&random);
    nsdf_mesh_storage_free(&b.memory, &b.quick);
    nsdf_mesh_storage_free(&b.memory, &b.full);
    nsdf_mesher_free(&b.mesher);
    nsdf_tasks_free(&b.tasks);
    assert_int_equal(b.memory.used, 0);
}

/* ---- Hostile parts --------------------------------------------------------------------------------------- */

/* Balls that are small at rest and that their bones blow up to hold the whole domain, in numbers that are not listed.
 */
static void test_all_balls_count_where_they_are_too_many_to_list(void **state) {
    enum { COUNT = 700 };
    (void)state;
    sample_blocks s = sample_resting((sample_shape){COUNT, 1, 1, 0, 0}, 0x1p-10f);
    float *poses = sample_tensor_values(&s, NSDF_BLOCK_POSES);
    double mean = 0.0;
    for (int k = 0; k < 3; k++)
        poses[5 * k] = 2048.0f;
    for (int k = 0; k < COUNT; k++) {
        sample_tensor_values(&s, NSDF_BLOCK_COEFFICIENTS)[k] = 0.001f * (float)k;
        mean += 0.001 * k / COUNT;
    }
    opened o = open_blocks(&s);
    for (int time = 0; time < 3; time++) {
        nsdf_blocks_compose(&o.blocks, 0.5 * time, NULL);
        assert_true(fabs((double)value_at(&o.blocks, 0.4f, -0.4f, 0.1f) - mean) < 1e-5);
    }
    free(o.storage);
    sample_free(&s);
}

/* The largest and smallest numbers there are in every place: nothing but values may go wrong. */
static void test_extreme_numbers_do_no_harm(void **state) {
    static const float extremes[] = {3.4e38f, -3.4e38f, 1e-45f, -1e-45f, 0.0f, 1.0f, 1e-20f, 1e20f};
    (void)state;
    uint64_t random = 6;
    for (uint64_t round = 0; round < 300; round++) {
        sample_blocks s = sample_random((sample_shape){12, 3, 2, 3, 4}, round);
        const size_t count = (size_t)nsdf_parameter_count(&s.desc.list);
        for (size_t i = 0; i < 1 + round % 40; i++)
            s.values[make_random(&random) % count] = extremes[make_random(&random) % 8];
        if (nsdf_check_blocks(&s.desc, s.values, NULL) == NSDF_PARSE_OK) {
            opened o = open_blocks(&s);
            for (int i = 0; i < 20; i++) {
                const float x[3] = {sample_between(&random, -0.5, 0.5), 0.0f, extremes[make_random(&random) % 8]};
                float value = 0.0f, slope[3] = {0.0f, 0.0f, 0.0f};
                nsdf_blocks_compose(&o.blocks, 0.25 * (i % 5), NULL);
                nsdf_blocks_evaluate(&o.blocks, nsdf_block_kernels_c(), 1, 1, x, &value, slope);
            }
            free(o.storage);
        }
        sample_free(&s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_values_and_gradients_are_those_of_the_definition),
        cmocka_unit_test(test_values_are_added_in_strided_rows),
        cmocka_unit_test(test_terms_stand_by_degree_then_falling_powers),
        cmocka_unit_test(test_blocks_fade_in_and_out_inside_their_life),
        cmocka_unit_test(test_a_pose_without_inverse_takes_its_block_away),
        cmocka_unit_test(test_far_from_all_balls_the_nearest_centre_counts),
        cmocka_unit_test(test_blocks_around_a_point_make_it_negative),
        cmocka_unit_test(test_all_tables_and_tiles_give_the_same_bits),
        cmocka_unit_test(test_results_do_not_depend_on_how_many_balls_are_near),
        cmocka_unit_test(test_composing_does_not_depend_on_the_workers),
        cmocka_unit_test(test_searches_by_groups_leave_nothing_out),
        cmocka_unit_test(test_tables_agree_about_winding_numbers_of_a_half),
        cmocka_unit_test(test_measures_are_values_without_the_sign_outside),
        cmocka_unit_test(test_the_mesh_is_the_same_without_measuring),
        cmocka_unit_test(test_all_balls_count_where_they_are_too_many_to_list),
        cmocka_unit_test(test_extreme_numbers_do_no_harm),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
