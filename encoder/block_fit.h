/* Fitting the blocks: poses, polynomials and what they are at rest together, by Adam, against samples of the signed
 * distance. */
#ifndef NSDF_BLOCK_FIT_H
#define NSDF_BLOCK_FIT_H

#include "block_model.h"
#include "fit.h"

/* As nsdf_fit_run, for blocks: model->values are fitted from where they are, and left rounded as the file will hold
 * them, unless job->control is given.  job->model is not used.  Returns as nsdf_fit_run. */
int nsdf_block_fit_run(const nsdf_fit_job *job, nsdf_block_model *model, nsdf_fit_result *result);

#endif
