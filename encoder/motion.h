/* How pieces of a surface move: an affine map for each block and frame. */
#ifndef NSDF_MOTION_H
#define NSDF_MOTION_H

#include "nodes.h"
#include "nsdf/encoder.h"
#include "workers.h"

/* x = linear (X - centre) + position, X at rest. */
typedef struct nsdf_pose {
    double linear[9]; /* row by row */
    double position[3];
} nsdf_pose;

typedef struct nsdf_motion {
    uint32_t block_count, frame_count;
    float (*centres)[3];  /* [block_count]: at rest, normalised */
    float (*normals)[3];  /* [block_count]: at rest, outward */
    uint32_t (*lives)[2]; /* [block_count]: first and last frame on which the block has surface */
    nsdf_pose *poses;     /* [frame_count][block_count] */
    float radius;         /* of the balls at rest, normalised */
} nsdf_motion;

/* Radius of the balls at rest: the options', or such that the blocks cover each point of `area` as often as they say.
 */
double nsdf_block_radius(const nsdf_encoder_options *options, double area);

/* Balls that are flattened or drawn out too much are no balls: the nodes around them do not belong together. */
int nsdf_pose_keeps_ball(const nsdf_pose *pose);

void nsdf_motion_free(nsdf_motion *motion);

/* Balls of a radius on nodes, about `blocks` of them on a surface of `area`, and how
 * the nodes around each centre move it (along the surface, so that parts that only touch stay apart): a least-squares
 * affine map, drawn towards the rigid one where the nodes lie in a plane.  A block lives while its nodes have support;
 * where it comes and goes more than once, there are as many blocks.  Returns 0, or -1 when memory ran out. */
int nsdf_motion_find(nsdf_motion *motion, const nsdf_nodes *nodes, uint32_t blocks, double area, float radius,
                     nsdf_workers *workers);

#endif
