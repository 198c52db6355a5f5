/* Quantisers for every array of a model, and the integers they give. */
#ifndef NSDF_QUANTISE_MODEL_H
#define NSDF_QUANTISE_MODEL_H

#include "model.h"

typedef struct nsdf_quantise_params {
    double bits; /* >= 32: float32 is stored */
    int minmax;  /* the thesis's quantiser between the extremes (4.13), else steps from the root mean square */
} nsdf_quantise_params;

/* Sets quantiser, step and offset of every array.  Without minmax the step is 6 rms / 2^bits and the offset 0, so
 * that zero stays zero. */
void nsdf_choose_quantisers(nsdf_model *model, const nsdf_quantise_params *params, const float *parameters);

/* The parameters as the decoder will see them. */
void nsdf_round_parameters(const nsdf_model *model, const float *parameters, float *rounded);

/* The integers to store (bits of the floats for raw arrays).  Returns 0, or -1 if a value cannot be represented. */
int nsdf_quantise_parameters(const nsdf_model *model, const float *parameters, int32_t *q);

#endif
