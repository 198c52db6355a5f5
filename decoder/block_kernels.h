/* The inner loops of block evaluation, one table per instruction set.
 *
 * Points within balls are worked on in sixteens, others one by one with blocks side by side.  The tables are compiled
 * from the same C (block_kernels_impl.h) without fused multiply and add, and every lane gets the same operations in the
 * same order: all tables give the same bits. */
#ifndef NSDF_BLOCK_KERNELS_H
#define NSDF_BLOCK_KERNELS_H

#include "blocks.h"
#include "net_kernels.h"

enum {
    NSDF_BLOCK_POINTS = 16,
    NSDF_NEAR_MOST = 256,
    NSDF_NEAR_ROOM = NSDF_NEAR_MOST + 2 * NSDF_BLOCK_GROUP /* groups are listed whole before they are counted */
};

/* Blocks that may hold some of a run's points, ascending; filled up to a multiple of 16 with centres far away. */
typedef struct nsdf_near_blocks {
    uint32_t count, number[NSDF_NEAR_ROOM];
    float centre[3][NSDF_NEAR_MOST], reach[NSDF_NEAR_MOST];
} nsdf_near_blocks;

/* Sums over the balls that hold a point; the slopes are derivatives with respect to x. */
typedef struct nsdf_block_sums {
    float weight[NSDF_BLOCK_POINTS], value[NSDF_BLOCK_POINTS];
    float weight_slope[3][NSDF_BLOCK_POINTS], value_slope[3][NSDF_BLOCK_POINTS];
} nsdf_block_sums;

typedef struct nsdf_block_kernels {
    const char *name;
    /* The sums at the points x over those of the near blocks that hold them; slopes only if wanted. */
    void (*sum)(const nsdf_block *blocks, const nsdf_near_blocks *near, uint32_t degree, int slopes,
                const float x[3][NSDF_BLOCK_POINTS], nsdf_block_sums *sums);
    /* Lists the blocks whose boxes meet that of `count` points, count > 0, ascending, and returns how many there are;
     * most + 1 when there are more than `most`.  The list has room for 2 * NSDF_BLOCK_GROUP more than that. */
    uint32_t (*meet)(const nsdf_block_boxes *boxes, const nsdf_block_boxes *group_boxes, uint32_t groups,
                     const float *const x[3], size_t count, uint32_t most, uint32_t *list);
    /* The block whose centre is nearest to a point, of equal ones the first, and its squared distance.  Where none is
     * nearer than *square says at first, the answer is `groups` * NSDF_BLOCK_GROUP. */
    uint32_t (*find_nearest)(const nsdf_block_group *group, const nsdf_group_balls *balls, uint32_t groups,
                             const float x[3], float *square);
    /* Lists the numbers of the blocks whose centres are within `reach` of a box, ascending, and perhaps a few more;
     * returns whether there are not more than NSDF_NEAR_MOST. */
    int (*list_centres)(const nsdf_block_group *group, const nsdf_group_balls *balls, uint32_t groups,
                        const float low[3], const float high[3], float reach, nsdf_near_blocks *list);
    /* find_nearest among those listed, with their centres; `none` where none is as near. */
    uint32_t (*nearest_listed)(const nsdf_near_blocks *list, uint32_t none, const float x[3], float *square);
    /* Whether the generalised winding number of the blocks as oriented elements of surface (Barill et al. 2018, eq. 11)
     * is above 1/2 at a point.  The number as all tables add it up decides, though not all have to work it out. */
    int (*is_wound)(const nsdf_block_group *group, uint32_t groups, const float x[3]);
} nsdf_block_kernels;

/* Fills in the centres and reaches of the blocks whose numbers are listed. */
void nsdf_blocks_describe(const nsdf_blocks *blocks, nsdf_near_blocks *near);

/* The best table among those that `features` (NSDF_CPU_...) allows; plain C for 0. */
const nsdf_block_kernels *nsdf_block_kernels_choose(uint32_t features);

const nsdf_block_kernels *nsdf_block_kernels_c(void);
const nsdf_block_kernels *nsdf_block_kernels_avx2(void);   /* NULL where it cannot be built */
const nsdf_block_kernels *nsdf_block_kernels_avx512(void); /* the same */

#endif
