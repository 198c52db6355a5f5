/* Fitting what blocks are at rest: how much each bone moves them, where their centres are, how large they are.
 *
 * All else is fitted around these, so that few bits are enough for them; but where they are put at first, by what the
 * surface's tracked points tell, is not where they serve best.  They are fitted along with all else until they settle:
 * are rounded, before other values are, and stay. */
#ifndef NSDF_BLOCK_REST_H
#define NSDF_BLOCK_REST_H

#include "block_batch.h"
#include "fit_state.h"
#include "optimiser.h"

/* Gradient of one block: of its weights, its centre and its radius. */
enum { NSDF_REST_VALUES = NSDF_BONE_INFLUENCES + 4 };

typedef struct nsdf_block_rest {
    nsdf_adam weights, centres, radii;
    uint8_t settled; /* the model's values at rest are rounded, and are not to change again */
} nsdf_block_rest;

/* `settled` for a model whose values are.  Returns 0, or -1 when memory ran out. */
int nsdf_block_rest_create(nsdf_block_rest *rest, const nsdf_block_model *model, int settled);
void nsdf_block_rest_free(nsdf_block_rest *rest);

/* Gradients of the loss with respect to a block's values at rest, where `pose` is that with respect to its pose at the
 * frame's time and `sums` are those of its points.  A weight of 0 has the gradient 0. */
void nsdf_block_rest_gradient(const nsdf_block_model *model, const nsdf_block_frame *frame, uint32_t block,
                              const float pose[12], const nsdf_block_gradient *sums, float rest[NSDF_REST_VALUES]);

/* Adds them to the gradient of the model's values. */
void nsdf_block_rest_add_gradient(const nsdf_block_model *model, uint32_t block, const float rest[NSDF_REST_VALUES],
                                  float *gradient);

/* One step of the model's values at rest, with `share` of their rates.  Weights of a block keep the sum 1, and those
 * above 0 stay so; radii stay within fixed shares of model->radius.  gradient[value_count] is used up. */
void nsdf_block_rest_step(nsdf_block_rest *rest, nsdf_block_model *model, float *gradient, double share);

/* Rounds the model's values at rest, if that was not done before. */
void nsdf_block_rest_settle(nsdf_block_rest *rest, nsdf_block_model *model);

/* For checkpoints; the model's values themselves are not among the fields. */
void nsdf_block_rest_fields(nsdf_block_rest *rest, nsdf_fit_state *fields);

#endif
