/* Where blocks are at one time, and the way back for gradients.  A block's pose is the sum over its bones of w (B / e,
 * B (c - a) / e + b), with B and b of the bone, a its anchor, e its extent, c the block's centre: what
 * decoder/blocks_compose.c does, in single precision. */
#include "block_pose.h"

#include "row4.h"
#include "spline.h"

#include <math.h>

_Static_assert(NSDF_BONE_INFLUENCES == 4, "a block's bones are summed as four numbers at once");

/* ---- Control points -------------------------------------------------------------------------------------- */

nsdf_block_knots_at nsdf_block_find_knots(uint32_t knots, double u) {
    nsdf_block_knots_at k = {0, 1, {1.0f, 0.0f, 0.0f, 0.0f}};
    if (knots > 0) {
        k.first = nsdf_spline_weights(u, knots, k.weight);
        k.count = 4;
    }
    return k;
}

static void compose_bones(nsdf_block_frame *frame, const nsdf_block_model *m, const float *values, double u) {
    const size_t plane = 12 * (size_t)m->desc.bone_count;
    const nsdf_block_knots_at k = nsdf_block_find_knots(m->knots, u);
    memset(frame->bones, 0, plane * sizeof *frame->bones);
    for (size_t j = 0; j < k.count; j++) {
        const float *control = values + m->pose_offset + (k.first + j) * plane;
        for (size_t i = 0; i < plane; i++)
            frame->bones[i] += k.weight[j] * control[i];
    }
    for (size_t bone = 0; bone < m->desc.bone_count; bone++) {
        const float *b = frame->bones + 12 * bone;
        nsdf_row4 columns[4] = {nsdf_row4_load(b), nsdf_row4_load(b + 4), nsdf_row4_load(b + 8), {0}};
        nsdf_row4_transpose(columns);
        memcpy(frame->columns[bone], columns, sizeof columns);
    }
}

/* ---- Poses ----------------------------------------------------------------------------------------------- */

/* Columns of the affine map, and the centre's position. */
static void blend_pose(const nsdf_block_frame *frame, const nsdf_block_model *m, size_t block, nsdf_row4 pose[4]) {
    const nsdf_block_influence *f = &m->influences[block * NSDF_BONE_INFLUENCES];
    pose[0] = pose[1] = pose[2] = pose[3] = (nsdf_row4){0};
    for (size_t i = 0; i < NSDF_BONE_INFLUENCES; i++, f++) {
        const float(*b)[4] = (const float(*)[4])frame->columns[f->bone];
        const nsdf_row4 x = nsdf_row4_load(b[0]), y = nsdf_row4_load(b[1]), z = nsdf_row4_load(b[2]);
        const nsdf_row4 centre = nsdf_row4_load(b[3]) + x * f->lever[0] + y * f->lever[1] + z * f->lever[2];
        pose[0] += f->scaled * x;
        pose[1] += f->scaled * y;
        pose[2] += f->scaled * z;
        pose[3] += f->weight * centre;
    }
}

/* u = M^-1 (x - p) / radius; rows of the inverse are products of M's columns. */
static void invert_pose(const nsdf_row4 pose[4], float radius, float map[12]) {
    nsdf_row4 row[3];
    for (int i = 0; i < 3; i++)
        row[i] = nsdf_row4_cross(pose[(i + 1) % 3], pose[(i + 2) % 3]);
    const nsdf_row4 along = pose[0] * row[0];
    const float determinant = along[0] + along[1] + along[2];
    const float scale = 1.0f / ((fabsf(determinant) > 1e-9f ? determinant : 1e-9f) * radius);
    for (int i = 0; i < 3; i++)
        row[i] *= scale;
    const nsdf_row4 moved = nsdf_row4_sums(row[0] * pose[3], row[1] * pose[3], row[2] * pose[3], (nsdf_row4){0});
    for (int i = 0; i < 3; i++) {
        row[i][3] = -moved[i];
        nsdf_row4_store(map + 4 * i, row[i]);
    }
}

static void find_reach(const nsdf_row4 pose[4], float radius, float reach[6]) {
    const nsdf_row4 squares = pose[0] * pose[0] + pose[1] * pose[1] + pose[2] * pose[2];
    for (int axis = 0; axis < 3; axis++) {
        const float half = radius * sqrtf(squares[axis]);
        reach[axis] = pose[3][axis] - half;
        reach[3 + axis] = pose[3][axis] + half;
    }
}

static int is_alive(const float life[2], double u) {
    return (life[0] <= 0.0f || u > (double)life[0]) && (life[1] >= 1.0f || u < (double)life[1]);
}

int nsdf_block_alive(const nsdf_block_model *m, uint32_t block, double u) {
    return is_alive(m->values + nsdf_block_offset(&m->desc, NSDF_BLOCK_LIVES) + 2 * (size_t)block, u);
}

void nsdf_block_frame_pose(nsdf_block_frame *frame, const nsdf_block_model *model, const float *values, double u) {
    const float *radii = values + nsdf_block_offset(&model->desc, NSDF_BLOCK_RADII);
    const float *lives = model->values + nsdf_block_offset(&model->desc, NSDF_BLOCK_LIVES);
    compose_bones(frame, model, values, u);
    for (uint32_t k = 0; k < model->desc.block_count; k++) {
        nsdf_row4 pose[4];
        frame->alive[k] = (uint8_t)is_alive(lives + 2 * (size_t)k, u);
        blend_pose(frame, model, k, pose);
        invert_pose(pose, radii[k], frame->map[k]);
        find_reach(pose, radii[k], frame->reach[k]);
        nsdf_row4_transpose(pose);
        memcpy(frame->pose[k], pose, sizeof frame->pose[k]);
    }
}

/* ---- Gradients ------------------------------------------------------------------------------------------- */

/* u = U (x - c), U = M^-1 / r: dL/dc = -U^T g and dL/dM = -U^T g (r u)^T for g = dL/du. */
void nsdf_block_pose_gradient(const float map[12], float radius, const float sums[3][4], float pose[12]) {
    const nsdf_row4 scale = {-radius, -radius, -radius, -1.0f};
    const nsdf_row4 s[3] = {scale * nsdf_row4_load(sums[0]), scale * nsdf_row4_load(sums[1]),
                            scale * nsdf_row4_load(sums[2])};
    for (int row = 0; row < 3; row++)
        nsdf_row4_store(pose + 4 * row, map[row] * s[0] + map[4 + row] * s[1] + map[8 + row] * s[2]);
}

/* dL/dB is (dL/dM) / e and what moving the centre does, by the arm that it is moved on. */
void nsdf_block_sum_bones(const nsdf_block_model *m, const float (*gradient)[12], float *bones) {
    const nsdf_block_influence *f = m->influences;
    memset(bones, 0, 12 * (size_t)m->desc.bone_count * sizeof *bones);
    for (size_t block = 0; block < m->desc.block_count; block++) {
        const float *g = gradient[block];
        const nsdf_row4 rows[3] = {nsdf_row4_load(g), nsdf_row4_load(g + 4), nsdf_row4_load(g + 8)};
        for (size_t i = 0; i < NSDF_BONE_INFLUENCES; i++, f++) {
            float *bone = bones + 12 * (size_t)f->bone;
            const nsdf_row4 scaled = {f->scaled, f->scaled, f->scaled, 0.0f};
            const nsdf_row4 lever = f->weight * nsdf_row4_load(f->lever);
            for (int row = 0; row < 3; row++)
                nsdf_row4_store(bone + 4 * row,
                                nsdf_row4_load(bone + 4 * row) + (scaled * rows[row] + rows[row][3] * lever));
        }
    }
}

void nsdf_block_scatter_bones(const nsdf_block_model *m, double u, const float *bones, float *value_gradient) {
    const size_t plane = 12 * (size_t)m->desc.bone_count;
    const nsdf_block_knots_at k = nsdf_block_find_knots(m->knots, u);
    for (size_t j = 0; j < k.count; j++) {
        float *control = value_gradient + m->pose_offset + (k.first + j) * plane;
        for (size_t i = 0; i < plane; i++)
            control[i] += k.weight[j] * bones[i];
    }
}

void nsdf_block_weight_gradient(const nsdf_block_model *m, const nsdf_block_frame *frame, uint32_t block,
                                const float pose[12], float weight[NSDF_BONE_INFLUENCES]) {
    const nsdf_block_influence *f = &m->influences[(size_t)block * NSDF_BONE_INFLUENCES];
    nsdf_row4 sums[NSDF_BONE_INFLUENCES];
    for (int i = 0; i < NSDF_BONE_INFLUENCES; i++, f++) {
        const float *bone = frame->bones + 12 * (size_t)f->bone, per_extent = f->per_extent;
        const nsdf_row4 scaled = {per_extent, per_extent, per_extent, 0.0f}, lever = nsdf_row4_load(f->lever);
        sums[i] = (nsdf_row4){0};
        for (int row = 0; row < 3; row++)
            sums[i] +=
                nsdf_row4_load(bone + 4 * row) * (scaled * nsdf_row4_load(pose + 4 * row) + pose[4 * row + 3] * lever);
    }
    nsdf_row4_store(weight, nsdf_row4_sums(sums[0], sums[1], sums[2], sums[3]));
}

void nsdf_block_centre_gradient(const nsdf_block_frame *frame, uint32_t block, const float pose[12], float centre[3]) {
    const float *placed = frame->pose[block];
    const nsdf_row4 sum =
        nsdf_row4_load(placed) * pose[3] + nsdf_row4_load(placed + 4) * pose[7] + nsdf_row4_load(placed + 8) * pose[11];
    for (int axis = 0; axis < 3; axis++)
        centre[axis] = sum[axis];
}

/* ---- How far a block has moved --------------------------------------------------------------------------- */

/* u0 = U0 x + v0 in a ball as it was is r U0 A u + (U0 c + v0) for u in the ball now: |u| < 1 gives |u0| < 1 + |r U0 A
 * - 1| + |U0 c + v0|. */
float nsdf_block_moved(const float map[12], const float pose[12], float radius) {
    const nsdf_row4 scale = {radius, radius, radius, 1.0f};
    const nsdf_row4 p[3] = {scale * nsdf_row4_load(pose), scale * nsdf_row4_load(pose + 4),
                            scale * nsdf_row4_load(pose + 8)};
    nsdf_row4 squares = {0};
    for (int row = 0; row < 3; row++) {
        const float *m = map + 4 * row;
        const nsdf_row4 same = {row == 0 ? 1.0f : 0.0f, row == 1 ? 1.0f : 0.0f, row == 2 ? 1.0f : 0.0f, -m[3]};
        const nsdf_row4 off = m[0] * p[0] + m[1] * p[1] + m[2] * p[2] - same;
        squares += off * off;
    }
    return sqrtf(squares[0] + squares[1] + squares[2]) + sqrtf(squares[3]);
}
