/* Poses and polynomials of the blocks at one time.  In double, so that machines agree but for the last rounding. */
#include "blocks.h"
#include "blocks_read.h"
#include "compose.h"

#include <math.h>
#include <string.h>

/* ---- Storage ----------------------------------------------------------------------------------------------- */

static uint64_t rounded_up(uint64_t bytes) {
    return (bytes + 63) / 64 * 64;
}

uint64_t nsdf_blocks_storage(const nsdf_blocks_desc *desc) {
    const uint64_t k = desc->block_count;
    const uint32_t groups = nsdf_block_groups(desc->block_count);
    return rounded_up(k * sizeof(nsdf_block)) + rounded_up(k * sizeof(float[NSDF_BLOCK_TERMS])) +
           rounded_up(groups * sizeof(nsdf_block_group)) +
           rounded_up(nsdf_block_groups(groups) * sizeof(nsdf_group_balls)) +
           rounded_up(groups * sizeof(nsdf_block_boxes)) +
           rounded_up(nsdf_block_groups(groups) * sizeof(nsdf_block_boxes)) +
           rounded_up(12 * sizeof(double) * (uint64_t)desc->bone_count);
}

static void *cut(char **storage, uint64_t bytes) {
    void *piece = *storage;
    *storage += rounded_up(bytes);
    return piece;
}

static float largest_radius(const nsdf_blocks *b) {
    const float *radii = b->values + nsdf_block_offset(b->desc, NSDF_BLOCK_RADII);
    float largest = 0.0f;
    for (uint32_t k = 0; k < b->desc->block_count; k++)
        largest = radii[k] > largest ? radii[k] : largest;
    return largest;
}

/* ---- Polynomials ------------------------------------------------------------------------------------------- */

/* phi = P_a(x) P_b(y) P_c(z) with P_0 = 1, P_1 = x, P_2 = x^2 - 1/9, P_3 = x^3 - 3/11 x: nearly orthogonal under the
 * weight (1 - |u|^2)^2.  Coefficients are stored in the order of the terms (nsdf_block_term), so that each is its own
 * monomial's, and some of them add to a lower one. */
static const struct {
    uint8_t from, to;
    double factor;
} lower_terms[] = {{4, 0, -1.0 / 9.0},   {7, 0, -1.0 / 9.0},  {9, 0, -1.0 / 9.0},  {10, 1, -3.0 / 11.0},
                   {11, 2, -1.0 / 9.0},  {12, 3, -1.0 / 9.0}, {13, 1, -1.0 / 9.0}, {15, 1, -1.0 / 9.0},
                   {16, 2, -3.0 / 11.0}, {17, 3, -1.0 / 9.0}, {18, 2, -1.0 / 9.0}, {19, 3, -3.0 / 11.0}};

enum { LOWER_TERMS = sizeof lower_terms / sizeof *lower_terms };

/* The coefficients of each degree at one time. */
typedef struct {
    nsdf_blend of[NSDF_MAX_DEGREE + 1];
} coefficients_at;

static void blend_coefficients(const nsdf_blocks *b, double u, coefficients_at *at) {
    for (uint32_t d = 0; d <= b->desc->degree; d++) {
        const uint32_t tensor = NSDF_BLOCK_COEFFICIENTS + d;
        nsdf_blend_tensor(&at->of[d], &b->desc->list.tensors[tensor], b->values + nsdf_block_offset(b->desc, tensor),
                          u);
    }
}

/* Of as many blocks as a group has at most, together. */
static void make_terms(const nsdf_blocks *b, const coefficients_at *at, uint32_t first, uint32_t count) {
    double terms[NSDF_BLOCK_GROUP][NSDF_BLOCK_TERMS] = {{0.0}}, rows[NSDF_BLOCK_GROUP * NSDF_BLOCK_TERMS];
    const uint32_t degree = b->desc->degree;
    for (uint32_t d = 0; d <= degree; d++) {
        const uint32_t begin = nsdf_block_term(d, 0, 0), cols = at->of[d].cols;
        nsdf_blend_rows(&at->of[d], first, count, rows);
        for (uint32_t k = 0; k < count; k++)
            memcpy(terms[k] + begin, rows + (size_t)k * cols, cols * sizeof **terms);
    }
    for (uint32_t k = 0; k < count; k++) {
        for (uint32_t i = 0; i < LOWER_TERMS; i++)
            terms[k][lower_terms[i].to] += terms[k][lower_terms[i].from] * lower_terms[i].factor;
        for (uint32_t i = 0; i < NSDF_BLOCK_TERMS; i++)
            b->own_terms[first + k][i] = (float)terms[k][i];
    }
}

static uint32_t group_size(const nsdf_blocks *b, uint32_t group) {
    const uint32_t left = b->desc->block_count - group * NSDF_BLOCK_GROUP;
    return left < NSDF_BLOCK_GROUP ? left : NSDF_BLOCK_GROUP;
}

void nsdf_blocks_init(nsdf_blocks *blocks, const nsdf_blocks_desc *desc, const float *values, void *storage) {
    const uint64_t k = desc->block_count;
    const uint32_t groups = nsdf_block_groups(desc->block_count);
    char *rest = storage;
    memset(blocks, 0, sizeof *blocks);
    blocks->desc = desc;
    blocks->values = values;
    blocks->blocks = cut(&rest, k * sizeof(nsdf_block));
    blocks->own_terms = cut(&rest, k * sizeof(float[NSDF_BLOCK_TERMS]));
    blocks->groups = cut(&rest, groups * sizeof(nsdf_block_group));
    blocks->balls = cut(&rest, nsdf_block_groups(groups) * sizeof(nsdf_group_balls));
    blocks->boxes = cut(&rest, groups * sizeof(nsdf_block_boxes));
    blocks->group_boxes = cut(&rest, nsdf_block_groups(groups) * sizeof(nsdf_block_boxes));
    blocks->bones = cut(&rest, 12 * sizeof(double) * (uint64_t)desc->bone_count);
    blocks->largest_radius = largest_radius(blocks);
    memset(blocks->blocks, 0, k * sizeof(nsdf_block));
    blocks->moving = 0;
    for (uint32_t d = 0; d <= desc->degree; d++)
        blocks->moving |= desc->list.tensors[NSDF_BLOCK_COEFFICIENTS + d].kind != NSDF_TENSOR_CONSTANT;
    coefficients_at at;
    blend_coefficients(blocks, 0.0, &at);
    for (uint32_t g = 0; g < groups; g++)
        make_terms(blocks, &at, g * NSDF_BLOCK_GROUP, group_size(blocks, g));
    nsdf_blocks_clear_groups(blocks);
}

/* ---- One time ---------------------------------------------------------------------------------------------- */

/* M and the position of the centre, from [extent * M | position]. */
static void compose_bones(nsdf_blocks *b, double u) {
    const nsdf_tensor_desc *tensor = &b->desc->list.tensors[NSDF_BLOCK_POSES];
    const float *anchors = b->values + nsdf_block_offset(b->desc, NSDF_BLOCK_ANCHORS);
    nsdf_blend blend;
    nsdf_blend_tensor(&blend, tensor, b->values + nsdf_block_offset(b->desc, NSDF_BLOCK_POSES), u);
    for (uint32_t i = 0; i < b->desc->bone_count; i++) {
        double *bone = b->bones + 12 * (size_t)i, inverse = 1.0 / (double)anchors[4 * (size_t)i + 3];
        nsdf_blend_row(&blend, i, bone);
        for (int n = 0; n < 12; n++)
            bone[n] *= n % 4 == 3 ? 1.0 : inverse;
    }
}

/* Everything that a time has in common for all blocks, and their parameters. */
typedef struct block_moment {
    nsdf_blocks *blocks;
    double u;
    const float *centres, *radii, *lives, *bones, *weights, *anchors;
    coefficients_at coefficients; /* where they move */
} block_moment;

/* Linear blend of the bones: pose[3][4] maps x - centre at rest to the position at this time. */
static void blend_pose(const block_moment *m, uint32_t k, double pose[12]) {
    const uint32_t influences = m->blocks->desc->influences;
    const float *centre = m->centres + 3 * (size_t)k;
    memset(pose, 0, 12 * sizeof *pose);
    for (size_t at = (size_t)k * influences, end = at + influences; at < end; at++) {
        const size_t number = (size_t)m->bones[at];
        const double *bone = m->blocks->bones + 12 * number, w = (double)m->weights[at];
        for (int row = 0; row < 3; row++) {
            double moved = bone[4 * row + 3];
            for (int axis = 0; axis < 3; axis++) {
                pose[4 * row + axis] += w * bone[4 * row + axis];
                moved += bone[4 * row + axis] * ((double)centre[axis] - (double)m->anchors[4 * number + (size_t)axis]);
            }
            pose[4 * row + 3] += w * moved;
        }
    }
}

/* How much of a block is there: it fades in and out inside its life, but for lives that reach the segment's ends. */
static double life_at(const float life[2], double fade, double u) {
    const double from = (double)life[0], to = (double)life[1];
    if (u < from || u > to)
        return 0.0;
    double in = from > 0.0 && fade > 0.0 ? (u - from) / fade : 1.0;
    double out = to < 1.0 && fade > 0.0 ? (to - u) / fade : 1.0;
    in = in < out ? in : out;
    return in < 1.0 ? in : 1.0;
}

/* U = M^-1 / radius by cofactors.  Returns whether all of it, and of U c, is finite as floats. */
static int invert_pose(const double p[12], double radius, double map[9]) {
    const double cofactor[9] = {p[5] * p[10] - p[6] * p[9], p[2] * p[9] - p[1] * p[10], p[1] * p[6] - p[2] * p[5],
                                p[6] * p[8] - p[4] * p[10], p[0] * p[10] - p[2] * p[8], p[2] * p[4] - p[0] * p[6],
                                p[4] * p[9] - p[5] * p[8],  p[1] * p[8] - p[0] * p[9],  p[0] * p[5] - p[1] * p[4]};
    const double scale = 1.0 / ((p[0] * cofactor[0] + p[1] * cofactor[3] + p[2] * cofactor[6]) * radius);
    int finite = 1;
    for (int row = 0; row < 3; row++) {
        double offset = 0.0;
        for (int axis = 0; axis < 3; axis++) {
            const double entry = cofactor[3 * row + axis] * scale;
            map[3 * row + axis] = entry;
            offset -= entry * p[4 * axis + 3];
            finite &= isfinite((float)entry) != 0;
        }
        finite &= isfinite((float)offset) != 0;
    }
    return finite;
}

/* The box of { c + radius M v, |v| <= 1 }, a little larger for rounding. */
static void box_of(const double p[12], double radius, float box[6]) {
    for (int row = 0; row < 3; row++) {
        const double half =
            1.0001 * radius *
            sqrt(p[4 * row] * p[4 * row] + p[4 * row + 1] * p[4 * row + 1] + p[4 * row + 2] * p[4 * row + 2]);
        box[row] = (float)(p[4 * row + 3] - half);
        box[3 + row] = (float)(p[4 * row + 3] + half);
    }
}

/* The length of the longest M v, by the largest sum of a row of |M M^T|, a little larger for rounding. */
static float reach_of(const double p[12], double radius) {
    double most = 0.0;
    for (int i = 0; i < 3; i++) {
        double sum = 0.0;
        for (int j = 0; j < 3; j++)
            sum += fabs(p[4 * i] * p[4 * j] + p[4 * i + 1] * p[4 * j + 1] + p[4 * i + 2] * p[4 * j + 2]);
        most = fmax(most, sum);
    }
    return (float)(1.0001 * radius * sqrt(most));
}

/* Which monomial of second degree d_a d_b is. */
static const uint8_t quadratic_of[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};

/* The quadratic form q of u = U d, as one of d: U^T H U with q's matrix H. */
static void turn_quadratic(const double map[9], const double q[6], double out[6]) {
    double half[3][3]; /* H U */
    for (int i = 0; i < 3; i++)
        for (int b = 0; b < 3; b++) {
            half[i][b] = 0.0;
            for (int j = 0; j < 3; j++)
                half[i][b] += (i == j ? q[quadratic_of[i][j]] : 0.5 * q[quadratic_of[i][j]]) * map[3 * j + b];
        }
    for (int a = 0; a < 3; a++)
        for (int b = a; b < 3; b++) {
            const double sum = map[a] * half[0][b] + map[3 + a] * half[1][b] + map[6 + a] * half[2][b];
            out[quadratic_of[a][b]] = a == b ? sum : 2.0 * sum;
        }
}

/* Which monomial of third degree d_a times the quadratic monomial q is. */
static const uint8_t cubic_of[3][6] = {{0, 1, 2, 3, 4, 5}, {1, 3, 4, 6, 7, 8}, {2, 4, 5, 7, 8, 9}};

/* The cubic form, u_x (c[0] to c[5]) + u_y (c[6] to c[8]) + u_z c[9] with quadratic ones. */
static void turn_cubic(const double map[9], const double c[10], double out[10]) {
    const double factor[3][6] = {
        {c[0], c[1], c[2], c[3], c[4], c[5]}, {0, 0, 0, c[6], c[7], c[8]}, {0, 0, 0, 0, 0, c[9]}};
    memset(out, 0, 10 * sizeof *out);
    for (int i = 0; i < 3; i++) {
        double turned[6];
        turn_quadratic(map, factor[i], turned);
        for (int a = 0; a < 3; a++)
            for (int q = 0; q < 6; q++)
                out[cubic_of[a][q]] += map[3 * i + a] * turned[q];
    }
}

/* So far below the largest number that what it is multiplied by a weight of 0 with is finite. */
static float limited(double value) {
    const float most = 1e18f, single = (float)value;
    return !(single > -most) ? -most : single < most ? single : most;
}

/* The block's polynomial and its weight as functions of x - centre. */
static void turn_block(nsdf_block *block, const float own[NSDF_BLOCK_TERMS], uint32_t degree, const double map[9]) {
    static const double unit[6] = {1, 0, 0, 1, 0, 1};
    const uint32_t terms = nsdf_block_term(degree + 1, 0, 0);
    double from[NSDF_BLOCK_TERMS] = {0}, shape[6], to[NSDF_BLOCK_TERMS];
    for (uint32_t i = 0; i < terms; i++)
        from[i] = (double)own[i];
    to[0] = from[0];
    for (int a = 0; a < 3; a++)
        to[1 + a] = map[a] * from[1] + map[3 + a] * from[2] + map[6 + a] * from[3];
    if (degree >= 2)
        turn_quadratic(map, from + 4, to + 4);
    if (degree >= 3)
        turn_cubic(map, from + 10, to + 10);
    turn_quadratic(map, unit, shape);
    for (uint32_t i = 0; i < terms; i++)
        block->terms[i] = limited(to[i]);
    for (int i = 0; i < 6; i++)
        block->shape[i] = limited(shape[i]);
}

/* At rest the block stands for the area pi r^2 / 5 across the slope g of its polynomial's linear part; the map M = U^-1
 * / r takes the area vector n A to det(M) M^-T n A = U^T n A / (r^2 det U), and U^T g is the slope here.  Over 4 pi. */
static void place_block(nsdf_blocks *blocks, uint32_t k, const double pose[12], const double m[9]) {
    nsdf_block *block = &blocks->blocks[k];
    float dipole[3], box[6];
    const float *g = blocks->own_terms[k] + 1;
    const float length = sqrtf(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
    const double det =
        m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) + m[2] * (m[3] * m[7] - m[4] * m[6]);
    const float scale = length > 0.0f ? block->life / (20.0f * length * (float)det) : 0.0f;
    for (int axis = 0; axis < 3; axis++) {
        block->centre[axis] = (float)pose[4 * axis + 3];
        dipole[axis] = scale * block->terms[1 + axis];
    }
    box_of(pose, (double)block->radius, box);
    nsdf_blocks_set_place(blocks, k, block->centre, dipole, reach_of(pose, (double)block->radius), box);
}

static void compose_block(const block_moment *m, uint32_t k) {
    nsdf_blocks *b = m->blocks;
    nsdf_block *block = &b->blocks[k];
    double pose[12], map[9];
    block->life = (float)life_at(m->lives + 2 * (size_t)k, (double)b->desc->fade, m->u);
    block->radius = 0.0f;
    if (block->life > 0.0f) {
        blend_pose(m, k, pose);
        if (invert_pose(pose, (double)m->radii[k], map))
            block->radius = m->radii[k];
    }
    if (block->radius > 0.0f) {
        turn_block(block, b->own_terms[k], b->desc->degree, map);
        place_block(b, k, pose, map);
    } else {
        nsdf_blocks_remove_place(b, k);
    }
}

enum { GROUPS_PER_TASK = 4 };

/* Groups that no other task writes to. */
static void compose_groups(void *data, uint32_t task, uint32_t worker) {
    const block_moment *m = data;
    const uint32_t groups = nsdf_block_groups(m->blocks->desc->block_count), first = task * GROUPS_PER_TASK;
    (void)worker;
    for (uint32_t g = first; g < first + GROUPS_PER_TASK && g < groups; g++) {
        const uint32_t begin = g * NSDF_BLOCK_GROUP, count = group_size(m->blocks, g);
        if (m->blocks->moving)
            make_terms(m->blocks, &m->coefficients, begin, count);
        for (uint32_t k = begin; k < begin + count; k++)
            compose_block(m, k);
        nsdf_blocks_bound_group(m->blocks, g);
    }
}

void nsdf_blocks_compose(nsdf_blocks *blocks, double u, nsdf_tasks *tasks) {
    const nsdf_blocks_desc *desc = blocks->desc;
    const uint32_t groups = nsdf_block_groups(desc->block_count);
    const uint32_t count = (groups + GROUPS_PER_TASK - 1) / GROUPS_PER_TASK;
    block_moment m = {.blocks = blocks,
                      .u = u,
                      .centres = blocks->values + nsdf_block_offset(desc, NSDF_BLOCK_CENTRES),
                      .radii = blocks->values + nsdf_block_offset(desc, NSDF_BLOCK_RADII),
                      .lives = blocks->values + nsdf_block_offset(desc, NSDF_BLOCK_LIVES),
                      .bones = blocks->values + nsdf_block_offset(desc, NSDF_BLOCK_BONES),
                      .weights = blocks->values + nsdf_block_offset(desc, NSDF_BLOCK_WEIGHTS),
                      .anchors = blocks->values + nsdf_block_offset(desc, NSDF_BLOCK_ANCHORS)};
    compose_bones(blocks, u);
    if (blocks->moving)
        blend_coefficients(blocks, u, &m.coefficients);
    if (tasks)
        nsdf_tasks_run(tasks, count, compose_groups, &m);
    for (uint32_t i = 0; !tasks && i < count; i++)
        compose_groups(&m, i, 0);
}
