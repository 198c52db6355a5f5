/* Steps for the square matrices of a network that do not change with time: momentum whose singular values are all
 * brought near 1 (Muon, K. Jordan et al. 2024), so that directions which the gradient hardly shows move as far as those
 * which it shows always.  Everything else is Adam's. */
#ifndef NSDF_MUON_H
#define NSDF_MUON_H

#include "fit_kernels.h"
#include "model.h"
#include "workers.h"

typedef struct nsdf_muon_matrix {
    size_t offset;           /* among the parameters */
    uint32_t size;           /* rows and columns */
    float *momentum, *ahead; /* [size][size]: running mean of the gradient, and the next step */
    float *scratch;
} nsdf_muon_matrix;

typedef struct nsdf_muon {
    const nsdf_fit_kernels *kernels;
    nsdf_muon_matrix matrices[NSDF_MAX_LAYERS];
    uint32_t count;
    float *gradient, *parameters; /* of the step that is being made */
    float rate;
} nsdf_muon;

/* Finds the matrices of the model.  Returns 0, or -1 when memory ran out. */
int nsdf_muon_create(nsdf_muon *muon, const nsdf_model *model, const nsdf_fit_kernels *kernels);
void nsdf_muon_free(nsdf_muon *muon);

/* Moves the matrices from where they are, and sets their gradient to 0, so that Adam leaves them there; `rate` is what
 * Adam's step has.  gradient: of all parameters. */
void nsdf_muon_step(nsdf_muon *muon, nsdf_workers *workers, float *parameters, float *gradient, double rate);

/* The matrix [size][size], in place, with singular values near 1; 0 stays 0.  scratch: nsdf_muon_scratch(size) floats
 * at a multiple of 64 bytes. */
void nsdf_muon_orthogonalise(const nsdf_fit_kernels *kernels, uint32_t size, float *matrix, float *scratch);
size_t nsdf_muon_scratch(uint32_t size);

#endif
