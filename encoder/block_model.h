/* The block part being fitted: its description, its parameters, and the blocks at one time. */
#ifndef NSDF_BLOCK_MODEL_H
#define NSDF_BLOCK_MODEL_H

#include "blocks_write.h"
#include "bones.h"

enum { NSDF_BLOCK_MOST_TERMS = 20 };

/* What one bone does to a block. */
typedef struct nsdf_block_influence {
    uint32_t bone;
    float weight, scaled, per_extent; /* scaled = weight / extent; per_extent = 1 / extent */
    float lever[4]; /* of the block's centre from the bone's anchor, in extents, and 1; with per_extent all 0 where the
                       weight is */
} nsdf_block_influence;

typedef struct nsdf_block_model {
    nsdf_blocks_desc desc;
    float *values; /* parameters in the order of the file */
    size_t value_count;
    size_t pose_offset, pose_count;   /* of the poses among the values: [knots][bone][12] */
    size_t level_offset, level_count; /* of the coefficients of degree 0 that move: [level_knots][block]; or none */
    size_t term_offset, term_count;   /* of the coefficients that do not move: [degree][block][terms of the degree] */
    uint32_t terms;                   /* of a block, all degrees */
    uint32_t knots, level_knots;      /* of the poses and of the levels; 0 = they do not move */
    float radius;                     /* of all blocks at first */
    nsdf_block_influence *influences; /* [block][desc.influences], see nsdf_block_model_set_influences */
} nsdf_block_model;

typedef struct nsdf_block_steps {
    double pose, coefficient; /* quantiser steps, normalised */
} nsdf_block_steps;

/* Shapes the part for bones found in a motion, with a control point every `knot_spacing` of the u's frames, and one
 * of the coefficients of degree 0 every `level_spacing` (0 = none, they do not move), and fills all values but the
 * coefficients, which are 0.  Values at rest, which are all but poses and coefficients, are rounded as the file will
 * hold them.  u[frame_count] ascends from 0 to 1.  Returns 0, or -1 when memory ran out. */
int nsdf_block_model_create(nsdf_block_model *model, const nsdf_motion *motion, const nsdf_bones *bones,
                            const double *u, uint32_t degree, double knot_spacing, double level_spacing,
                            const nsdf_block_steps *steps);
void nsdf_block_model_free(nsdf_block_model *model);

/* Returns 0, or -1 when memory ran out. */
int nsdf_block_model_copy(nsdf_block_model *copy, const nsdf_block_model *model);

/* Changes the quantisers' steps; the values stay. */
void nsdf_block_model_set_steps(nsdf_block_model *model, const nsdf_block_steps *steps);

/* After weights or centres have changed: the influences that follow from them. */
void nsdf_block_model_set_influences(nsdf_block_model *model);

/* Rounds weights, centres and radii to their steps, with what follows from them.  The weights of a block sum to 1. */
void nsdf_block_model_round_rest(nsdf_block_model *model);

/* values with poses and coefficients rounded to their steps. */
void nsdf_block_model_round(const nsdf_block_model *model, const float *values, float *rounded);

/* Whether a block is there at time u, be it in part. */
int nsdf_block_alive(const nsdf_block_model *model, uint32_t block, double u);

/* The life of a block that is there in frames first..last of those at u[frames] and in no other. */
void nsdf_block_life(const double *u, uint32_t frames, uint32_t first, uint32_t last, float life[2]);

/* Lives as the file will hold them. */
void nsdf_block_model_round_lives(nsdf_block_model *model);

/* Where a block's coefficients of a degree lie among the values; those of degree 0 at the first control point. */
static inline size_t nsdf_block_degree_offset(const nsdf_block_model *model, uint32_t block, uint32_t degree) {
    const size_t blocks = model->desc.block_count;
    const size_t below = degree * (degree + 1) * (degree + 2) / 6; /* terms of lower degrees */
    const size_t levels =
        degree > 0 && model->level_count > 0 ? model->level_count - blocks : 0; /* more than one each */
    return model->level_offset + levels + blocks * below + (size_t)block * nsdf_degree_terms(degree);
}

/* A block's coefficients, for products of P_0 to P_3 (decoder/blocks_compose.c), to those of monomials, both by degree
 * and within it in the order of the file; and a gradient the other way. */
void nsdf_block_get_monomials(const nsdf_block_model *model, const float *values, uint32_t block, float *monomials);
void nsdf_block_add_gradient(const nsdf_block_model *model, uint32_t block, const float *monomials, float *gradient);

/* Where coefficients of degree 0 (levels) move, the two above leave them out; these add those of one time to all
 * blocks' monomials ([block]), and a time's gradient of the monomials to that of the values. */
void nsdf_block_add_levels(const nsdf_block_model *model, const float *values, double u,
                           float (*monomials)[NSDF_BLOCK_MOST_TERMS]);
void nsdf_block_scatter_levels(const nsdf_block_model *model, double u, const float (*monomials)[NSDF_BLOCK_MOST_TERMS],
                               float *gradient);

/* ---- One time -------------------------------------------------------------------------------------------- */

/* Blocks at one time, in single precision, and a grid of cells for points. */
typedef struct nsdf_block_frame {
    float (*map)[12];                      /* [block]: u = U x + v, rows of U and v */
    float (*pose)[12];                     /* [block]: rows of the affine map and the centre's position */
    float (*terms)[NSDF_BLOCK_MOST_TERMS]; /* [block]: coefficients of monomials */
    float (*reach)[6];                     /* [block]: box of the ball: low, high */
    uint8_t *alive;                        /* [block] */
    float *bones;                          /* [bone][12]: rows */
    float (*columns)[4][4];                /* [bone]: the same as columns; the last of each is 0 */
    float low[3], inverse_cell;
    uint32_t cells[3];
} nsdf_block_frame;

int nsdf_block_frame_create(nsdf_block_frame *frame, const nsdf_block_model *model, const float domain_min[3],
                            const float domain_max[3]);
void nsdf_block_frame_free(nsdf_block_frame *frame);
void nsdf_block_frame_compose(nsdf_block_frame *frame, const nsdf_block_model *model, const float *values, double u);
/* The same but for the terms, which do not depend on time. */
void nsdf_block_frame_pose(nsdf_block_frame *frame, const nsdf_block_model *model, const float *values, double u);

/* Basis functions at u, in the order of the coefficients. */
void nsdf_block_basis(uint32_t degree, const float u[3], float *basis);

#endif
