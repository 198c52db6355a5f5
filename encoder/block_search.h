/* Where the decoded surface of a block model lies away from the input: hard samples for the rest of fitting. */
#ifndef NSDF_BLOCK_SEARCH_H
#define NSDF_BLOCK_SEARCH_H

#include "block_model.h"
#include "fit.h"

enum { NSDF_BLOCK_MOST_HARD = 512 };

/* A set of hard samples for each frame, empty at first, with room for NSDF_BLOCK_MOST_HARD.  NULL when memory ran out.
 */
nsdf_sample_set *nsdf_block_hard_create(uint32_t frames);
void nsdf_block_hard_free(nsdf_sample_set *hard, uint32_t frames);

/* Decodes the model as it would be stored, at every frame, on a grid of `resolution` cells, and adds vertices further
 * than `tolerance` (normalised) from the input to the frame's set, with their true distances; of more than there is
 * room for, an even choice.  *found gets how many vertices there were.  Returns 0, or -1 when memory ran out. */
int nsdf_block_search(const nsdf_fit_job *job, const nsdf_block_model *model, uint32_t resolution, float tolerance,
                      nsdf_sample_set *hard, uint64_t *found);

#endif
