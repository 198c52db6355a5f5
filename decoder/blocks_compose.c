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
    return rounded_up(k * sizeof(nsdf_block)) + rounded_up(groups * sizeof(nsdf_block_group)) +
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

/* phi = P_a(x) P_b(y) P_c(z) with P_0 = 1, P_1 = x, P_2 = x^2 - 1/9, P_3 = x^3 - 3/11 x: nearly orthogonal under the
 * weight (1 - |u|^2)^2.  Adds coefficient * phi to the monomials. */
static void add_product(const uint32_t degree[3], double coefficient, double terms[NSDF_BLOCK_TERMS]) {
    static const double lower[4] = {0.0, 0.0, -1.0 / 9.0, -3.0 / 11.0}; /* of x^(n - 2) */
    for (uint32_t choice = 0; choice < 8; choice++) {
        uint32_t power[3];
        double factor = coefficient;
        for (int axis = 0; axis < 3; axis++) {
            const uint32_t low = choice >> axis & 1;
            factor *= low ? lower[degree[axis]] : 1.0;
            power[axis] = degree[axis] - (low && degree[axis] >= 2 ? 2 : 0);
        }
        if (factor != 0.0)
            terms[nsdf_block_term(power[0], power[1], power[2])] += factor;
    }
}

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

/* Terms of a degree are stored with a, then b, descending. */
static void make_terms(const nsdf_blocks *b, const coefficients_at *at, uint32_t k, float out[NSDF_BLOCK_TERMS]) {
    double terms[NSDF_BLOCK_TERMS] = {0.0};
    for (uint32_t d = 0; d <= b->desc->degree; d++) {
        double row[(NSDF_MAX_DEGREE + 1) * (NSDF_MAX_DEGREE + 2) / 2], *c = row;
        nsdf_blend_row(&at->of[d], k, row);
        for (uint32_t rest = 0; rest <= d; rest++)
            for (uint32_t z = 0; z <= rest; z++) {
                const uint32_t degree[3] = {d - rest, rest - z, z};
                add_product(degree, *c++, terms);
            }
    }
    for (int i = 0; i < NSDF_BLOCK_TERMS; i++)
        out[i] = (float)terms[i];
}

void nsdf_blocks_init(nsdf_blocks *blocks, const nsdf_blocks_desc *desc, const float *values, void *storage) {
    const uint64_t k = desc->block_count;
    const uint32_t groups = nsdf_block_groups(desc->block_count);
    char *rest = storage;
    memset(blocks, 0, sizeof *blocks);
    blocks->desc = desc;
    blocks->values = values;
    blocks->blocks = cut(&rest, k * sizeof(nsdf_block));
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
    for (uint32_t i = 0; i < desc->block_count; i++)
        make_terms(blocks, &at, i, blocks->blocks[i].terms);
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

/* Linear blend of the bones: pose[3][4] maps x - centre at rest to the position at this time. */
static void blend_pose(const nsdf_blocks *b, uint32_t k, double pose[12]) {
    const nsdf_blocks_desc *desc = b->desc;
    const float *centre = b->values + nsdf_block_offset(desc, NSDF_BLOCK_CENTRES) + 3 * (size_t)k;
    const float *anchors = b->values + nsdf_block_offset(desc, NSDF_BLOCK_ANCHORS);
    const size_t at = (size_t)k * desc->influences;
    const float *bones = b->values + nsdf_block_offset(desc, NSDF_BLOCK_BONES) + at;
    const float *weights = b->values + nsdf_block_offset(desc, NSDF_BLOCK_WEIGHTS) + at;
    memset(pose, 0, 12 * sizeof *pose);
    for (uint32_t i = 0; i < desc->influences; i++) {
        const size_t number = (size_t)bones[i];
        const double *bone = b->bones + 12 * number, w = (double)weights[i];
        for (int row = 0; row < 3; row++) {
            double moved = bone[4 * row + 3];
            for (int axis = 0; axis < 3; axis++) {
                pose[4 * row + axis] += w * bone[4 * row + axis];
                moved += bone[4 * row + axis] * ((double)centre[axis] - (double)anchors[4 * number + (size_t)axis]);
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

/* U = M^-1 / radius by cofactors, v = -U c.  Returns whether all is finite. */
static int invert_pose(const double p[12], double radius, float map[12]) {
    const double cofactor[9] = {p[5] * p[10] - p[6] * p[9], p[2] * p[9] - p[1] * p[10], p[1] * p[6] - p[2] * p[5],
                                p[6] * p[8] - p[4] * p[10], p[0] * p[10] - p[2] * p[8], p[2] * p[4] - p[0] * p[6],
                                p[4] * p[9] - p[5] * p[8],  p[1] * p[8] - p[0] * p[9],  p[0] * p[5] - p[1] * p[4]};
    const double scale = 1.0 / ((p[0] * cofactor[0] + p[1] * cofactor[3] + p[2] * cofactor[6]) * radius);
    int finite = 1;
    for (int row = 0; row < 3; row++) {
        double offset = 0.0;
        for (int axis = 0; axis < 3; axis++) {
            const double entry = cofactor[3 * row + axis] * scale;
            map[4 * row + axis] = (float)entry;
            offset -= entry * p[4 * axis + 3];
            finite &= isfinite(map[4 * row + axis]) != 0;
        }
        map[4 * row + 3] = (float)offset;
        finite &= isfinite(map[4 * row + 3]) != 0;
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

/* At rest the block stands for the area pi r^2 / 5 across the slope g of its polynomial's linear part; the map M = U^-1
 * / r takes the area vector n A to det(M) M^-T n A = U^T n A / (r^2 det U).  Over 4 pi. */
static void place_block(nsdf_blocks *blocks, uint32_t k, const double pose[12]) {
    const nsdf_block *block = &blocks->blocks[k];
    float centre[3], dipole[3], box[6];
    const float *m = block->map, *g = block->terms + 1;
    const float length = sqrtf(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
    const float det =
        m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]);
    const float scale = length > 0.0f ? block->life / (20.0f * length * det) : 0.0f;
    for (int axis = 0; axis < 3; axis++) {
        dipole[axis] = scale * (m[axis] * g[0] + m[4 + axis] * g[1] + m[8 + axis] * g[2]);
        centre[axis] = (float)pose[4 * axis + 3];
    }
    box_of(pose, (double)block->radius, box);
    nsdf_blocks_set_place(blocks, k, centre, dipole, reach_of(pose, (double)block->radius), box);
}

void nsdf_blocks_compose(nsdf_blocks *blocks, double u) {
    const nsdf_blocks_desc *desc = blocks->desc;
    const float *lives = blocks->values + nsdf_block_offset(desc, NSDF_BLOCK_LIVES);
    const float *radii = blocks->values + nsdf_block_offset(desc, NSDF_BLOCK_RADII);
    coefficients_at at;
    compose_bones(blocks, u);
    if (blocks->moving)
        blend_coefficients(blocks, u, &at);
    for (uint32_t k = 0; k < desc->block_count; k++) {
        nsdf_block *block = &blocks->blocks[k];
        double pose[12];
        block->life = (float)life_at(lives + 2 * (size_t)k, (double)desc->fade, u);
        block->radius = 0.0f;
        nsdf_blocks_remove_place(blocks, k);
        if (!(block->life > 0.0f))
            continue;
        blend_pose(blocks, k, pose);
        if (!invert_pose(pose, (double)radii[k], block->map))
            continue;
        block->radius = radii[k];
        if (blocks->moving)
            make_terms(blocks, &at, k, block->terms);
        place_block(blocks, k, pose);
    }
    nsdf_blocks_bound_groups(blocks);
}
