/* Few affine bones that move many blocks: linear blend skinning found from the motion (after SSDR: Le & Deng 2012, with
 * affine instead of rigid bones, for which both halves of the alternation are linear least squares). */
#ifndef NSDF_BONES_H
#define NSDF_BONES_H

#include "motion.h"

enum { NSDF_BONE_INFLUENCES = 4 };

typedef struct nsdf_bones {
    uint32_t bone_count, block_count, frame_count;
    uint32_t (*bone)[NSDF_BONE_INFLUENCES]; /* [block_count] */
    double (*weight)[NSDF_BONE_INFLUENCES]; /* [block_count]: >= 0, sum 1; unused ones are 0 */
    double *poses;                          /* [frame_count][bone_count][3][4]: x = M (X, 1) on positions at rest */
    double error; /* root mean square over blocks and frames of what the blend misses, normalised */
} nsdf_bones;

/* Finds up to `count` bones.  Poses of blocks on frames outside of their lives do not count and become those that the
 * bones give.  Returns 0, or -1 when memory ran out. */
int nsdf_bones_fit(nsdf_bones *bones, nsdf_motion *motion, uint32_t count, nsdf_workers *workers);
void nsdf_bones_free(nsdf_bones *bones);

/* With the weights as they are now, the best poses. */
int nsdf_bones_solve_poses(nsdf_bones *bones, const nsdf_motion *motion);

#endif
