/* The inner loops of block evaluation, one table per instruction set.
 *
 * Points are worked on in tiles of NSDF_TILE.  The tables are compiled from the same C (block_kernels_impl.h) without
 * fused multiply and add, and every lane gets the same operations in the same order: all tables give the same bits. */
#ifndef NSDF_BLOCK_KERNELS_H
#define NSDF_BLOCK_KERNELS_H

#include "blocks.h"
#include "net_kernels.h"

/* Sums over the balls that hold a point; the slopes are derivatives with respect to x. */
typedef struct nsdf_block_sums {
    float weight[NSDF_TILE], value[NSDF_TILE];
    float weight_slope[3][NSDF_TILE], value_slope[3][NSDF_TILE];
} nsdf_block_sums;

typedef struct nsdf_block_kernels {
    const char *name;
    /* Adds a block to the sums at the points x[3][NSDF_TILE]; slopes only if wanted. */
    void (*add)(const nsdf_block *block, uint32_t degree, int slopes, const float x[3][NSDF_TILE],
                nsdf_block_sums *sums);
    /* The block whose centre is nearest, of equal ones the first, and its squared distance.  Where none is nearer than
     * `square` says at first, `nearest` is `count`. */
    void (*find_nearest)(const nsdf_block_place *places, uint32_t count, const float x[3][NSDF_TILE],
                         float square[NSDF_TILE], uint32_t nearest[NSDF_TILE]);
    /* Generalised winding number of the blocks as oriented elements of surface (Barill et al. 2018, eq. 11). */
    void (*wind)(const nsdf_block_place *places, uint32_t count, const float x[3][NSDF_TILE], float sum[NSDF_TILE]);
} nsdf_block_kernels;

/* The best table among those that `features` (NSDF_CPU_...) allows; plain C for 0. */
const nsdf_block_kernels *nsdf_block_kernels_choose(uint32_t features);

const nsdf_block_kernels *nsdf_block_kernels_c(void);
const nsdf_block_kernels *nsdf_block_kernels_avx2(void);   /* NULL where it cannot be built */
const nsdf_block_kernels *nsdf_block_kernels_avx512(void); /* the same */

#endif
