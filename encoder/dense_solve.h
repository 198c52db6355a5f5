/* Small dense linear systems. */
#ifndef NSDF_DENSE_SOLVE_H
#define NSDF_DENSE_SOLVE_H

#include <stddef.h>

/* Solves A X = B for a symmetric positive definite A[n][n] by Cholesky's factorisation, in place: A is overwritten, and
 * B[n][m] becomes X.  Pivots that are not positive become tiny ones. */
void nsdf_solve_positive(double *a, size_t n, double *b, size_t m);

#endif
