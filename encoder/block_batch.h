/* A slot's points and the balls that hold them, block by block: each block gathers its points once, works on them as
 * vectors, and sums its own gradients. */
#ifndef NSDF_BLOCK_BATCH_H
#define NSDF_BLOCK_BATCH_H

#include "block_model.h"

enum { NSDF_HIT_LANES = 16, NSDF_HIT_ARRAYS = 5 };

typedef struct nsdf_block_batch {
    uint32_t count, capacity;
    float *x, *y, *z, *d; /* [count]: samples as they were added */
    /* The same in the order of cells, and what the passes make of them; one more stands for no point. */
    float *sorted[3];
    uint32_t *source;      /* [count]: which sample it was */
    uint32_t *start;       /* [cells + 1] */
    float *weight, *value; /* sums over the balls; then value is f, and weight the share dL/df / weight */
    /* Hits: block after block, each padded to NSDF_HIT_LANES. */
    uint32_t *first;             /* [block + 1] */
    uint32_t *point;             /* [hit]: place in the sorted order */
    float *hit[NSDF_HIT_ARRAYS]; /* [hit]: u, v, w, root = 1 - |u|^2, the block's value */
    size_t hit_capacity;
} nsdf_block_batch;

/* Sums of a block's gradients: of the monomials in nsdf_block_term's order, of u, and of u times u's transpose. */
typedef struct nsdf_block_gradient {
    float terms[NSDF_BLOCK_MOST_TERMS];
    float slope[3], moment[9]; /* moment[3 k + j] = sum g_k u_j */
} nsdf_block_gradient;

/* The inner loops, compiled for several instruction sets from the same C without fused multiply and add: all give the
 * same bits. */
typedef struct nsdf_block_passes {
    /* Lists those of the sorted points from..to-1 that the ball holds, from hit `at` on; returns the hit after the
     * last. */
    uint32_t (*find)(nsdf_block_batch *batch, const float map[12], uint32_t from, uint32_t to, uint32_t at);
    /* Values of the block at its hits, added to the points' sums. */
    void (*forward)(nsdf_block_batch *batch, uint32_t block, uint32_t degree, const float *monomials);
    void (*backward)(const nsdf_block_batch *batch, uint32_t block, uint32_t degree, const float *monomials,
                     nsdf_block_gradient *sums);
} nsdf_block_passes;

/* The fastest that this processor runs. */
const nsdf_block_passes *nsdf_block_passes_select(void);
const nsdf_block_passes *nsdf_block_passes_generic(void);
const nsdf_block_passes *nsdf_block_passes_avx2(void);   /* NULL where it cannot be built */
const nsdf_block_passes *nsdf_block_passes_avx512(void); /* the same */

/* Room for `points` points and the blocks and cells of `frame`.  Returns 0, or -1 when memory ran out. */
int nsdf_block_batch_create(nsdf_block_batch *batch, uint32_t points, uint32_t blocks, const nsdf_block_frame *frame);
void nsdf_block_batch_free(nsdf_block_batch *batch);

static inline void nsdf_block_batch_add(nsdf_block_batch *b, float x, float y, float z, float d) {
    const uint32_t i = b->count++;
    b->x[i] = x;
    b->y[i] = y;
    b->z[i] = z;
    b->d[i] = d;
}

/* Sorts the points and finds the hits at the frame's time.  Returns 0, or -1 when memory ran out. */
int nsdf_block_batch_find(nsdf_block_batch *batch, const nsdf_block_passes *passes, const nsdf_block_frame *frame,
                          uint32_t blocks);

#endif
