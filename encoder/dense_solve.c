#include "dense_solve.h"

#include <math.h>

static const double least_pivot = 1e-18;

/* Row by row, so that inner products run along rows. */
static void factorise(double *a, size_t n) {
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j <= i; j++) {
            double sum = a[i * n + j];
            for (size_t k = 0; k < j; k++)
                sum -= a[i * n + k] * a[j * n + k];
            if (i == j)
                a[i * n + i] = sqrt(sum > least_pivot ? sum : least_pivot);
            else
                a[i * n + j] = sum / a[j * n + j];
        }
}

static void subtract_row(double *row, const double *other, double factor, size_t m) {
    for (size_t c = 0; c < m; c++)
        row[c] -= factor * other[c];
}

void nsdf_solve_positive(double *a, size_t n, double *b, size_t m) {
    factorise(a, n);
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < i; k++)
            subtract_row(b + i * m, b + k * m, a[i * n + k], m);
        for (size_t c = 0; c < m; c++)
            b[i * m + c] /= a[i * n + i];
    }
    for (size_t i = n; i-- > 0;) {
        for (size_t k = i + 1; k < n; k++)
            subtract_row(b + i * m, b + k * m, a[k * n + i], m);
        for (size_t c = 0; c < m; c++)
            b[i * m + c] /= a[i * n + i];
    }
}
