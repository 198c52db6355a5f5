/* Points of one frame, sorted by place once, and the balls that hold them, block by block: each block gathers its
 * points, works on them as vectors, and sums its own gradients. */
#ifndef NSDF_BLOCK_BATCH_H
#define NSDF_BLOCK_BATCH_H

#include "block_model.h"
#include "sampler.h"

enum { NSDF_HIT_LANES = 8, NSDF_HIT_ARRAYS = 5, NSDF_BATCH_MOST_POINTS = 1 << 16 };

/* Samples that stay together for the whole of fitting, and candidates among them for each ball. */
typedef struct nsdf_block_batch {
    uint32_t count;
    float (*point)[4]; /* [count + NSDF_HIT_LANES]: x, y, z, distance; in the order of cells */
    uint32_t *span;  /* [nsdf_block_batch_spans]: where the points of each few cells along x begin, and after all where
                        the last ones end */
    uint32_t *first; /* [block + 1]: where a block's candidates begin */
    uint16_t *near;  /* [candidate + NSDF_HIT_LANES]: points, ascending within a block */
    size_t near_capacity;
    uint32_t *listed; /* [block]: stamp of the map (block_cache.h) that its candidates were found with; 0 = none */
} nsdf_block_batch;

/* What working on a batch needs; one for each worker. */
typedef struct nsdf_block_work {
    uint32_t *cell;  /* [point] */
    uint32_t *start; /* [cells + 2] */
    float (*sum)[2]; /* [point + 1]: weights and values over the balls; then dL/df over the weights, and f.  One more
                        stands for no point. */
    uint16_t *kept;  /* [kept_first[blocks]]: candidates as they were, while some are found anew */
    uint32_t *kept_first; /* [block + 1] */
    size_t kept_capacity;
    uint32_t *first;             /* [block + 1]: where a block's hits begin, a multiple of NSDF_HIT_LANES */
    uint32_t *point;             /* [hit] */
    float *hit[NSDF_HIT_ARRAYS]; /* [hit]: u, v, w, root = 1 - |u|^2, the block's value */
    size_t hit_capacity;
} nsdf_block_work;

/* Sums of a block's gradients: of the monomials in nsdf_block_term's order, and of u, times 1 and times u's transpose.
 */
typedef struct nsdf_block_gradient {
    float terms[NSDF_BLOCK_MOST_TERMS];
    float moment[3][4]; /* [k][j]: sum g_k u_j; [k][3]: sum g_k */
} nsdf_block_gradient;

/* The loss: |f - d| with a weight, see block_fit.c. */
typedef struct nsdf_block_loss {
    float scale, weight_distance, safe_share, near_limit;
} nsdf_block_loss;

typedef struct nsdf_block_loss_sums {
    double near_error;          /* sum |f - d| over the points nearer to the surface than near_limit */
    uint64_t near_count, count; /* such points; points that some ball holds */
} nsdf_block_loss_sums;

/* The inner loops, compiled for several instruction sets from the same C without fused multiply and add: all give the
 * same bits. */
typedef struct nsdf_block_passes {
    const char *name;
    /* Adds to a block's candidates those of the points from..to-1 for which 1 - |u|^2 is above `least`; there is room
     * for all.  Returns the place after the last. */
    size_t (*list)(nsdf_block_batch *batch, const float map[12], float least, uint32_t from, uint32_t to, size_t at);
    /* Lists those of the block's candidates that its ball holds, from hit `at` on; there is room for all and a vector
     * more.  Returns the hit after the last, padded to whole vectors by hits of the point that is none. */
    uint32_t (*find)(nsdf_block_work *work, const nsdf_block_batch *batch, uint32_t block, const float map[12],
                     uint32_t at);
    /* Values of the block at its hits, added to the points' sums. */
    void (*forward)(nsdf_block_work *work, uint32_t block, uint32_t degree, const float *monomials);
    /* f, and dL/df over the sum of weights, at the points that some ball holds; 0 and 0 at the others. */
    nsdf_block_loss_sums (*differentiate)(nsdf_block_work *work, const nsdf_block_batch *batch,
                                          const nsdf_block_loss *loss);
    void (*backward)(const nsdf_block_work *work, uint32_t block, uint32_t degree, const float *monomials,
                     nsdf_block_gradient *sums);
} nsdf_block_passes;

/* The fastest that this processor runs. */
const nsdf_block_passes *nsdf_block_passes_select(void);
const nsdf_block_passes *nsdf_block_passes_generic(void);
const nsdf_block_passes *nsdf_block_passes_avx2(void);   /* NULL where it cannot be built */
const nsdf_block_passes *nsdf_block_passes_avx512(void); /* the same */

/* Room for batches of up to `points` points, and for the blocks and cells of `frame`.  Returns 0, or -1 when memory
 * ran out. */
int nsdf_block_work_create(nsdf_block_work *work, uint32_t points, uint32_t blocks, const nsdf_block_frame *frame);
void nsdf_block_work_free(nsdf_block_work *work);

/* Stretches of cells along x of which a batch knows where their points begin, and one more. */
size_t nsdf_block_batch_spans(const nsdf_block_frame *frame);

/* Makes room for `points` points, at most NSDF_BATCH_MOST_POINTS, in the cells of `frame`.  Returns 0, or -1 when
 * memory ran out. */
int nsdf_block_batch_create(nsdf_block_batch *batch, uint32_t points, uint32_t blocks, const nsdf_block_frame *frame);
void nsdf_block_batch_free(nsdf_block_batch *batch);

/* The samples from, from + stride, ..., at most `wanted`, in the order of the frame's cells.  Candidates of what the
 * batch held before are of no use: they are to be listed without stamps. */
void nsdf_block_batch_fill(nsdf_block_batch *batch, nsdf_block_work *work, const nsdf_block_frame *frame,
                           const nsdf_sample_set *samples, size_t from, size_t stride, uint32_t wanted);

/* Candidates of each block that is there: the points within 1 + margin of its radius, where `map` and `reach`
 * ([block][12], [block][6], as frame->map and reach) put it.  With stamps ([block], all above 0), only those of blocks
 * whose stamp is not batch->listed are found, which then is; NULL = all.  Returns 0, or -1 when memory ran out. */
int nsdf_block_batch_list(nsdf_block_batch *batch, nsdf_block_work *work, const nsdf_block_passes *passes,
                          const nsdf_block_frame *frame, const float (*map)[12], const float (*reach)[6],
                          const uint32_t *stamp, uint32_t blocks, float margin);

/* Finds the hits among the candidates at the frame's time, and the sums over the balls there.  Returns 0, or -1 when
 * memory ran out. */
int nsdf_block_batch_forward(nsdf_block_work *work, const nsdf_block_batch *batch, const nsdf_block_passes *passes,
                             const nsdf_block_frame *frame, const float (*terms)[NSDF_BLOCK_MOST_TERMS],
                             uint32_t blocks, uint32_t degree);

#endif
