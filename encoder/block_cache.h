/* Batches that are kept from step to step.
 *
 * A frame's samples fall into as many batches as there are strides through them, which stay what they are, and while
 * fitting blocks hardly move: candidates found once, with a margin, serve many steps.  Whether they still do is not
 * guessed: a ball's candidates belong to a reference, the map that they were found with, and hold all of its points as
 * long as its map is near enough to that one.  Of balls that have moved further they are found anew. */
#ifndef NSDF_BLOCK_CACHE_H
#define NSDF_BLOCK_CACHE_H

#include "block_batch.h"

/* Where a frame's blocks were when their candidates were last found. */
typedef struct nsdf_block_reference {
    float (*map)[12]; /* [block] */
    float (*reach)[6];
    uint32_t *stamp; /* how often it was set; 0 = never */
} nsdf_block_reference;

typedef struct nsdf_block_cache {
    const nsdf_sample_set *samples; /* [frame_count] */
    uint32_t frame_count, blocks, wanted;
    uint32_t *first;                  /* [frame + 1]: where a frame's batches begin */
    nsdf_block_batch *batches;        /* empty until they are first used; NULL when nothing is kept */
    nsdf_block_reference *references; /* [frame] */
} nsdf_block_cache;

/* Batches of `wanted` points each, in the cells of `frame`, of samples that stay.  Nothing is kept when it would take
 * more than `most_bytes`. Returns 0, or -1 when memory ran out. */
int nsdf_block_cache_create(nsdf_block_cache *cache, const nsdf_sample_set *samples, uint32_t frame_count,
                            uint32_t wanted, uint32_t blocks, const nsdf_block_frame *frame, size_t most_bytes);
void nsdf_block_cache_free(nsdf_block_cache *cache);

/* How many batches a frame has. */
uint32_t nsdf_block_cache_batches(const nsdf_block_cache *cache, uint32_t frame);

/* Batch `number` of a frame with candidates for the blocks as `at` has them.  Kept, if `keep` and the cache keeps any:
 * then no other thread may ask for a batch of the same frame meanwhile.  Otherwise it is made in `own`, which has room
 * for it.  What passes find in either is the same.  NULL when memory ran out. */
const nsdf_block_batch *nsdf_block_cache_take(nsdf_block_cache *cache, uint32_t frame, uint32_t number, int keep,
                                              const nsdf_block_frame *at, const float *radii,
                                              const nsdf_block_passes *passes, nsdf_block_work *work,
                                              nsdf_block_batch *own);

#endif
