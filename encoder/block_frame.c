/* Blocks at one time for fitting: what decoder/blocks_compose.c does, in single precision, and the way back for
 * gradients. */
#include "block_pose.h"

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
    frame->columns = calloc(model->desc.bone_count, sizeof *frame->columns);
    frame->reach = calloc(k, sizeof *frame->reach);
    frame->alive = calloc(k, sizeof *frame->alive);
    if (frame->alive && frame->map && frame->pose && frame->terms && frame->bones && frame->columns && frame->reach)
        return 0;
    nsdf_block_frame_free(frame);
    return -1;
}

void nsdf_block_frame_free(nsdf_block_frame *frame) {
    free(frame->map);
    free(frame->pose);
    free(frame->terms);
    free(frame->bones);
    free(frame->columns);
    free(frame->reach);
    free(frame->alive);
    memset(frame, 0, sizeof *frame);
}

/* ---- Polynomials ----------------------------------------------------------------------------------------- */

void nsdf_block_frame_compose(nsdf_block_frame *frame, const nsdf_block_model *model, const float *values, double u) {
    nsdf_block_frame_pose(frame, model, values, u);
    for (uint32_t k = 0; k < model->desc.block_count; k++)
        nsdf_block_get_monomials(model, values, k, frame->terms[k]);
    nsdf_block_add_levels(model, values, u, frame->terms);
}

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
    const nsdf_block_knots_at k = nsdf_block_find_knots(m->level_knots, u);
    for (size_t j = 0; m->level_knots > 0 && j < k.count; j++) {
        const float *control = values + m->level_offset + (k.first + j) * blocks;
        for (uint32_t b = 0; b < blocks; b++)
            monomials[b][0] += k.weight[j] * control[b];
    }
}

void nsdf_block_scatter_levels(const nsdf_block_model *m, double u, const float (*monomials)[NSDF_BLOCK_MOST_TERMS],
                               float *gradient) {
    const uint32_t blocks = m->desc.block_count;
    const nsdf_block_knots_at k = nsdf_block_find_knots(m->level_knots, u);
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
