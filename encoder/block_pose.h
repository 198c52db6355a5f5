/* Where blocks are at one time (block_frame.c holds the rest of a frame), and the way back for gradients. */
#ifndef NSDF_BLOCK_POSE_H
#define NSDF_BLOCK_POSE_H

#include "block_model.h"

/* Control points that count at a time, and their weights. */
typedef struct nsdf_block_knots_at {
    size_t first, count;
    float weight[4];
} nsdf_block_knots_at;

/* Of `knots` control points at u in 0..1; of a single one, which does not move, when knots is 0. */
nsdf_block_knots_at nsdf_block_find_knots(uint32_t knots, double u);

/* Gradient with respect to a block's pose (as frame->pose) from sums over its points of g u^T and g, where g = dL/du:
 * sums[k][j] = sum g_k u_j, sums[k][3] = sum g_k.  `map` as frame->map, `radius` of the ball. */
void nsdf_block_pose_gradient(const float map[12], float radius, const float sums[3][4], float pose[12]);

/* A gradient with respect to the blocks' poses ([block][12], as frame->pose) becomes one with respect to the bones
 * ([bone][12]), and that is added to the gradient of the values. */
void nsdf_block_sum_bones(const nsdf_block_model *model, const float (*gradient)[12], float *bones);
void nsdf_block_scatter_bones(const nsdf_block_model *model, double u, const float *bones, float *value_gradient);

/* Gradients with respect to a block's weights and its centre, where `pose` is that with respect to its pose at the
 * frame's time.  A weight of 0 has the gradient 0. */
void nsdf_block_weight_gradient(const nsdf_block_model *model, const nsdf_block_frame *frame, uint32_t block,
                                const float pose[12], float weight[NSDF_BONE_INFLUENCES]);
void nsdf_block_centre_gradient(const nsdf_block_frame *frame, uint32_t block, const float pose[12], float centre[3]);

/* How far outside of a ball as it was (`map` as frame->map) points can lie that are in it as it is (`pose` as
 * frame->pose), in radii of the ball as it was: an upper bound. */
float nsdf_block_moved(const float map[12], const float pose[12], float radius);

#endif
