/* Moving blocks at one time: balls that follow the surface, each with a polynomial that is the signed distance near it
 * (multi-level partition of unity implicits, Ohtake et al. 2003, on moving frames).
 *
 *     u_k = U_k (x - c_k)     the ball's own coordinates, |u_k| < 1 inside
 *     f   = sum_k w_k p_k(u_k) / sum_k w_k,   w_k = life_k (1 - |u_k|^2)^2
 *
 * Polynomials of u are polynomials of d = x - c, and |u|^2 is a quadratic form of d: composing works both out, so that
 * points are not mapped into each ball, nor slopes back.
 *
 * Outside of all balls there is no surface: |f| = max(|x - c| - r / 2, r / 4) for the nearest centre c and its radius
 * r, and the sign tells on which side of the blocks, taken as oriented elements of surface, the point lies. */
#ifndef NSDF_BLOCKS_H
#define NSDF_BLOCKS_H

#include "format_desc.h"
#include "tasks.h"

enum { NSDF_BLOCK_TERMS = 20 };

/* One block at one time, a whole number of cache lines. */
typedef struct nsdf_block {
    _Alignas(64) float centre[3];
    float radius; /* of the ball at rest; 0 when the block is not there at this time */
    float life;
    float shape[6];                /* |u|^2 = d^T U^T U d by the monomials of second degree of d */
    float terms[NSDF_BLOCK_TERMS]; /* the polynomial by monomials of d */
} nsdf_block;

enum {
    NSDF_BLOCK_GROUP = 16,
    NSDF_BLOCK_RUN = 192 /* points that are worked on together best */
};

/* Blocks as elements of surface, side by side in their order. */
typedef struct nsdf_block_group {
    float centre[3][NSDF_BLOCK_GROUP]; /* further than any domain is long when a block is not there */
    /* outward normal times the area that the block stands for, over 4 pi; 0 when it is not there */
    float dipole[3][NSDF_BLOCK_GROUP];
    float reach[NSDF_BLOCK_GROUP]; /* no point of the ball is further from the centre; a little larger, for rounding */
} nsdf_block_group;

/* Balls that hold the centres of a group's blocks, of as many groups side by side; far away where no block is there. */
typedef struct nsdf_group_balls {
    float middle[3][NSDF_BLOCK_GROUP], radius[NSDF_BLOCK_GROUP];
} nsdf_group_balls;

/* Boxes side by side: of blocks' balls, or of groups; empty (low above high) where no block is there. */
typedef struct nsdf_block_boxes {
    float low[3][NSDF_BLOCK_GROUP], high[3][NSDF_BLOCK_GROUP];
} nsdf_block_boxes;

/* How many groups of `count`. */
static inline uint32_t nsdf_block_groups(uint32_t count) {
    return (count + NSDF_BLOCK_GROUP - 1) / NSDF_BLOCK_GROUP;
}

typedef struct nsdf_blocks {
    const nsdf_blocks_desc *desc;
    const float *values;                   /* the part's parameters */
    nsdf_block *blocks;                    /* [block_count] */
    float (*own_terms)[NSDF_BLOCK_TERMS];  /* [block_count]: polynomials by monomials of u */
    float largest_radius;                  /* of all balls, at rest */
    int moving;                            /* some coefficients are splines over time */
    double *bones;                         /* [bone_count][12]: [3][4] rows of M and the centre's position */
    nsdf_block_group *groups;              /* [nsdf_block_groups(block_count)] */
    nsdf_group_balls *balls;               /* [nsdf_block_groups(of those)] */
    nsdf_block_boxes *boxes, *group_boxes; /* the same: of blocks, of groups */
} nsdf_blocks;

/* Bytes of storage that nsdf_blocks_init needs. */
uint64_t nsdf_blocks_storage(const nsdf_blocks_desc *desc);
/* Lays the blocks out in `storage` (aligned to 64 bytes), which must stay, and desc and values too; these were checked.
 */
void nsdf_blocks_init(nsdf_blocks *blocks, const nsdf_blocks_desc *desc, const float *values, void *storage);
/* Brings the blocks to time u in [0, 1], by the workers of `tasks` or, if that is NULL, on the calling thread. */
void nsdf_blocks_compose(nsdf_blocks *blocks, double u, nsdf_tasks *tasks);

struct nsdf_block_kernels;
/* Adds the values at `count` points, 1 to NSDF_BLOCK_RUN, xyz [3][stride], and the gradients [3][stride] if not NULL.
 * Quicker for points that lie near each other. */
void nsdf_blocks_evaluate(const nsdf_blocks *blocks, const struct nsdf_block_kernels *kernels, size_t count,
                          size_t stride, const float *xyz, float *value, float *gradient);

/* The same values in the balls, where exact[] is set to 1, else 0; outside their size, or where that is above `enough`
 * anything above it.  Stored, not added. */
void nsdf_blocks_measure(const nsdf_blocks *blocks, const struct nsdf_block_kernels *kernels, size_t count,
                         size_t stride, const float *xyz, float enough, float *value, uint8_t *exact);

/* blocks_groups.c: all groups without blocks; a block with the box of its ball, low then high, into its group, one that
 * is not there out of it; and a group's ball and box once all are in it. */
void nsdf_blocks_clear_groups(nsdf_blocks *blocks);
void nsdf_blocks_set_place(nsdf_blocks *blocks, uint32_t k, const float centre[3], const float dipole[3], float reach,
                           const float box[6]);
void nsdf_blocks_remove_place(nsdf_blocks *blocks, uint32_t k);
void nsdf_blocks_bound_group(nsdf_blocks *blocks, uint32_t group);

/* Where monomial x^a y^b z^c, a + b + c <= 3, lies among the terms: by degree, and within it a, then b, descending. */
static inline uint32_t nsdf_block_term(uint32_t a, uint32_t b, uint32_t c) {
    const uint32_t degree = a + b + c, rest = b + c;
    return degree * (degree + 1) * (degree + 2) / 6 + rest * (rest + 1) / 2 + c;
}

#endif
