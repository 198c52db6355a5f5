/* Inner loops of fitting: small matrix products and activations on panels of points.
 *
 * Layout: points come in panels of NSDF_PANEL; a matrix over points is [panel][row][NSDF_PANEL], so that one panel of
 * a layer stays in the first-level cache and every access is contiguous.  All pointers are aligned to 64 bytes. */
#ifndef NSDF_FIT_KERNELS_H
#define NSDF_FIT_KERNELS_H

#include <stddef.h>
#include <stdint.h>

enum { NSDF_PANEL = 32 };

/* y[panel][o][p] = sum_i a[o * stride + i] x[panel][i][p] for o < rows, i < cols.  Consecutive panels of x and y are
 * x_panel and y_panel floats apart. */
typedef void nsdf_fit_multiply(const float *a, size_t stride, uint32_t rows, uint32_t cols, const float *x,
                               size_t x_panel, float *y, size_t y_panel, uint32_t panels);

/* g[o * stride + i] += sum over panels and p of dz[panel][o][p] x[panel][i][p]. */
typedef void nsdf_fit_outer(const float *dz, size_t dz_panel, uint32_t rows, const float *x, size_t x_panel,
                            uint32_t cols, float *g, size_t stride, uint32_t panels);

typedef struct nsdf_fit_kernels {
    const char *name;

    nsdf_fit_multiply *multiply;
    nsdf_fit_outer *outer;

    /* The same with the factors rounded to bf16, sums in single precision, where the processor is faster with them; in
     * all other sets the very same functions.  What is rounded is off by 2^-8 of itself at most. */
    nsdf_fit_multiply *multiply_short;
    nsdf_fit_outer *outer_short;

    /* In place over `count` floats (a multiple of NSDF_PANEL): z becomes act(z), slope becomes act'(z).
     * sine: sin(omega z), omega cos(omega z); absolute error of sine and cosine below 3e-7 for |omega z| < 1000. */
    void (*sine)(float *z, float *slope, size_t count, float omega);
    void (*relu)(float *z, float *slope, size_t count);
    void (*tanh)(float *z, float *slope, size_t count);

    /* y *= x, `count` floats. */
    void (*scale)(float *y, const float *x, size_t count);
} nsdf_fit_kernels;

/* The fastest kernels that this processor runs. */
const nsdf_fit_kernels *nsdf_fit_kernels_select(void);

/* The fastest whose short products are those of single precision. */
const nsdf_fit_kernels *nsdf_fit_kernels_exact(void);
/* Those with short products that this processor runs, be they faster or not; returns how many there are. */
enum { NSDF_FIT_SHORT_SETS = 2 };
uint32_t nsdf_fit_kernels_list_short(const nsdf_fit_kernels *sets[NSDF_FIT_SHORT_SETS]);

/* Each set, NULL where the build has no such set; for tests. */
const nsdf_fit_kernels *nsdf_fit_kernels_generic(void);
const nsdf_fit_kernels *nsdf_fit_kernels_avx2(void);
const nsdf_fit_kernels *nsdf_fit_kernels_avx512(void);
const nsdf_fit_kernels *nsdf_fit_kernels_bf16(void); /* AVX-512 with bf16 */
const nsdf_fit_kernels *nsdf_fit_kernels_amx(void);  /* and products by tiles; NULL too where the system gives none */

#endif
