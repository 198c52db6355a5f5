/* Blocks at one time for fitting: what decoder/blocks_compose.c does, in single precision, and the way back for
 * gradients. */
#include "block_model.h"
#include "spline.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_CELLS = 64 };

int nsdf_block_frame_create(nsdf_block_frame *frame, const nsdf_block_model *model, const float domain_min[3],
                            const float domain_max[3]) {
    const size_t k = model->desc.block_count;
    memset(frame, 0, sizeof *frame);
    float cell = 0.75f * model->radius;
    for (int axis = 0; axis < 3; axis++)
        cell = fmaxf(cell, (domain_max[axis] - domain_min[axis]) / MOST_CELLS);
    frame->inverse_cell = 1.0f / cell;
    for (int axis = 0; axis < 3; axis++) {
        frame->low[axis] = domain_min[axis];
        frame->cells[axis] = 1 + (uint32_t)((domain_max[axis] - domain_min[axis]) * frame->inverse_cell);
    }
    frame->map = calloc(k, sizeof *frame->map);
    frame->pose = calloc(k, sizeof *frame->pose);
    frame->terms = calloc(k, sizeof *frame->terms);
    frame->bones = calloc(12 * (size_t)model->desc.bone_count, sizeof *frame->bones);
    frame->reach = calloc(k, sizeof *frame->reach);
    frame->alive = calloc(k, sizeof *frame->alive);
    if (frame->alive && frame->map && frame->pose && frame->terms && frame->bones && frame->reach)
        return 0;
    nsdf_block_frame_free(frame);
    return -1;
}

void nsdf_block_frame_free(nsdf_block_frame *frame) {
    free(frame->map);
    free(frame->pose);
    free(frame->terms);
    free(frame->bones);
    free(frame->reach);
    free(frame->alive);
    memset(frame, 0, sizeof *frame);
}

/* ---- Poses ----------------------------------------------------------------------------------------------- */

/* Control points that count at u, and their weights. */
typedef struct {
    size_t first, count;
    float weight[4];
} knots_at;

static knots_at find_knots(uint32_t knots, double u) {
    knots_at k = {0, 1, {1.0f, 0.0f, 0.0f, 0.0f}};
    if (knots > 0) {
        k.first = nsdf_spline_weights(u, knots, k.weight);
        k.count = 4;
    }
    return k;
}

static void compose_bones(nsdf_block_frame *frame, const nsdf_block_model *m, const float *values, double u) {
    const size_t plane = 12 * (size_t)m->desc.bone_count;
    const knots_at k = find_knots(m->knots, u);
    memset(frame->bones, 0, plane * sizeof *frame->bones);
    for (size_t j = 0; j < k.count; j++) {
        const float *control = values + m->pose_offset + (k.first + j) * plane;
        for (size_t i = 0; i < plane; i++)
            frame->bones[i] += k.weight[j] * control[i];
    }
}

static void blend_pose(const nsdf_block_frame *frame, const nsdf_block_model *m, size_t block, float pose[12]) {
    memset(pose, 0, 12 * sizeof *pose);
    for (size_t i = 0; i < m->desc.influences; i++) {
        const nsdf_block_influence *f = &m->influences[block * m->desc.influences + i];
        const float *bone = frame->bones + 12 * (size_t)f->bone;
        for (int row = 0; row < 3 && f->weight != 0.0f; row++) {
            const float *b = bone + 4 * row;
            for (int k = 0; k < 3; k++)
                pose[4 * row + k] += f->scaled * b[k];
            pose[4 * row + 3] += f->weight * (b[3] + b[0] * f->offset[0] + b[1] * f->offset[1] + b[2] * f->offset[2]);
        }
    }
}

static void invert_pose(const float p[12], float radius, float map[12]) {
    const float cofactor[9] = {p[5] * p[10] - p[6] * p[9], p[2] * p[9] - p[1] * p[10], p[1] * p[6] - p[2] * p[5],
                               p[6] * p[8] - p[4] * p[10], p[0] * p[10] - p[2] * p[8], p[2] * p[4] - p[0] * p[6],
                               p[4] * p[9] - p[5] * p[8],  p[1] * p[8] - p[0] * p[9],  p[0] * p[5] - p[1] * p[4]};
    const float determinant = p[0] * cofactor[0] + p[1] * cofactor[3] + p[2] * cofactor[6];
    const float scale = 1.0f / ((fabsf(determinant) > 1e-9f ? determinant : 1e-9f) * radius);
    for (int row = 0; row < 3; row++) {
        map[4 * row + 3] = 0.0f;
        for (int axis = 0; axis < 3; axis++) {
            map[4 * row + axis] = cofactor[3 * row + axis] * scale;
            map[4 * row + 3] -= map[4 * row + axis] * p[4 * axis + 3];
        }
    }
}

void nsdf_block_sum_bones(const nsdf_block_model *m, const float (*gradient)[12], float *bones) {
    memset(bones, 0, 12 * (size_t)m->desc.bone_count * sizeof *bones);
    for (size_t block = 0; block < m->desc.block_count; block++)
        for (size_t i = 0; i < m->desc.influences; i++) {
            const nsdf_block_influence *f = &m->influences[block * m->desc.influences + i];
            float *bone = bones + 12 * (size_t)f->bone;
            for (int row = 0; row < 3 && f->weight != 0.0f; row++) {
                const float *g = gradient[block] + 4 * row;
                for (int axis = 0; axis < 3; axis++)
                    bone[4 * row + axis] += f->scaled * g[axis] + f->weight * g[3] * f->offset[axis];
                bone[4 * row + 3] += f->weight * g[3];
            }
        }
}

void nsdf_block_scatter_bones(const nsdf_block_model *m, double u, const float *bones, float *value_gradient) {
    const size_t plane = 12 * (size_t)m->desc.bone_count;
    const knots_at k = find_knots(m->knots, u);
    for (size_t j = 0; j < k.count; j++) {
        float *control = value_gradient + m->pose_offset + (k.first + j) * plane;
        for (size_t i = 0; i < plane; i++)
            control[i] += k.weight[j] * bones[i];
    }
}

void nsdf_block_scatter_poses(const nsdf_block_model *m, double u, const float (*gradient)[12], float *bone_scratch,
                              float *value_gradient) {
    nsdf_block_sum_bones(m, gradient, bone_scratch);
    nsdf_block_scatter_bones(m, u, bone_scratch, value_gradient);
}

static void find_reach(const float pose[12], float radius, float reach[6]) {
    for (int axis = 0; axis < 3; axis++) {
        const float *row = pose + 4 * axis;
        const float half = radius * sqrtf(row[0] * row[0] + row[1] * row[1] + row[2] * row[2]);
        reach[axis] = row[3] - half;
        reach[3 + axis] = row[3] + half;
    }
}

int nsdf_block_alive(const nsdf_block_model *m, uint32_t block, double u) {
    const float *life = m->values + nsdf_block_offset(&m->desc, NSDF_BLOCK_LIVES) + 2 * (size_t)block;
    return (life[0] <= 0.0f || u > (double)life[0]) && (life[1] >= 1.0f || u < (double)life[1]);
}

void nsdf_block_frame_pose(nsdf_block_frame *frame, const nsdf_block_model *model, const float *values, double u) {
    const float *radii = values + nsdf_block_offset(&model->desc, NSDF_BLOCK_RADII);
    compose_bones(frame, model, values, u);
    for (uint32_t k = 0; k < model->desc.block_count; k++) {
        frame->alive[k] = (uint8_t)nsdf_block_alive(model, k, u);
        blend_pose(frame, model, k, frame->pose[k]);
        invert_pose(frame->pose[k], radii[k], frame->map[k]);
        find_reach(frame->pose[k], radii[k], frame->reach[k]);
    }
}

void nsdf_block_frame_compose(nsdf_block_frame *frame, const nsdf_block_model *model, const float *values, double u) {
    nsdf_block_frame_pose(frame, model, values, u);
    for (uint32_t k = 0; k < model->desc.block_count; k++)
        nsdf_block_get_monomials(model, values, k, frame->terms[k]);
    nsdf_block_add_levels(model, values, u, frame->terms);
}

/* ---- Polynomials ----------------------------------------------------------------------------------------- */

/* P_2 = x^2 - 1/9 and P_3 = x^3 - 3/11 x: what a product of them takes from a monomial of lower degree. */
static const struct {
    uint8_t of, from;
    float factor;
} lower[] = {{4, 0, -1.0f / 9},   {7, 0, -1.0f / 9},  {9, 0, -1.0f / 9},  {10, 1, -3.0f / 11},
             {11, 2, -1.0f / 9},  {12, 3, -1.0f / 9}, {13, 1, -1.0f / 9}, {15, 1, -1.0f / 9},
             {16, 2, -3.0f / 11}, {17, 3, -1.0f / 9}, {18, 2, -1.0f / 9}, {19, 3, -3.0f / 11}};

void nsdf_block_get_monomials(const nsdf_block_model *m, const float *values, uint32_t block, float *monomials) {
    uint32_t n = 0;
    for (uint32_t d = 0; d <= m->desc.degree; d++)
        for (uint32_t i = 0; i < nsdf_degree_terms(d); i++)
            monomials[n++] = d == 0 && m->level_knots > 0 ? 0.0f : values[nsdf_block_degree_offset(m, block, d) + i];
    for (size_t i = 0; i < sizeof lower / sizeof *lower && lower[i].of < n; i++)
        monomials[lower[i].from] += lower[i].factor * monomials[lower[i].of];
}

void nsdf_block_add_gradient(const nsdf_block_model *m, uint32_t block, const float *monomials, float *gradient) {
    float g[NSDF_BLOCK_MOST_TERMS];
    memcpy(g, monomials, m->terms * sizeof *g);
    for (size_t i = 0; i < sizeof lower / sizeof *lower && lower[i].of < m->terms; i++)
        g[lower[i].of] += lower[i].factor * g[lower[i].from];
    uint32_t n = m->level_knots > 0 ? 1 : 0;
    for (uint32_t d = n; d <= m->desc.degree; d++)
        for (uint32_t i = 0; i < nsdf_degree_terms(d); i++)
            gradient[nsdf_block_degree_offset(m, block, d) + i] += g[n++];
}

void nsdf_block_add_levels(const nsdf_block_model *m, const float *values, double u,
                           float (*monomials)[NSDF_BLOCK_MOST_TERMS]) {
    const uint32_t blocks = m->desc.block_count;
    const knots_at k = find_knots(m->level_knots, u);
    for (size_t j = 0; m->level_knots > 0 && j < k.count; j++) {
        const float *control = values + m->level_offset + (k.first + j) * blocks;
        for (uint32_t b = 0; b < blocks; b++)
            monomials[b][0] += k.weight[j] * control[b];
    }
}

void nsdf_block_scatter_levels(const nsdf_block_model *m, double u, const float (*monomials)[NSDF_BLOCK_MOST_TERMS],
                               float *gradient) {
    const uint32_t blocks = m->desc.block_count;
    const knots_at k = find_knots(m->level_knots, u);
    for (size_t j = 0; m->level_knots > 0 && j < k.count; j++) {
        float *control = gradient + m->level_offset + (k.first + j) * blocks;
        for (uint32_t b = 0; b < blocks; b++)
            control[b] += k.weight[j] * monomials[b][0];
    }
}

void nsdf_block_basis(uint32_t degree, const float u[3], float *basis) {
    float p[3][4];
    for (int axis = 0; axis < 3; axis++) {
        const float x = u[axis];
        p[axis][0] = 1.0f;
        p[axis][1] = x;
        p[axis][2] = x * x - 1.0f / 9;
        p[axis][3] = x * (x * x - 3.0f / 11);
    }
    uint32_t n = 0;
    for (uint32_t d = 0; d <= degree; d++)
        for (uint32_t rest = 0; rest <= d; rest++)
            for (uint32_t c = 0; c <= rest; c++)
                basis[n++] = p[0][d - rest] * p[1][rest - c] * p[2][c];
}
