/* Fitting kernels for AVX2 with FMA; compiled with -mavx2 -mfma on x86-64. */
#include "fit_kernels.h"
#if defined(__AVX2__) && defined(__FMA__)
#define KERNELS_NAME "avx2"
#define LANES 8
#define ROW_BLOCK 6
#define OUTER_ROWS 3
#define OUTER_COLS 3
#include "fit_kernels_impl.h"

const nsdf_fit_kernels *nsdf_fit_kernels_avx2(void) {
    return &kernels;
}
#else
const nsdf_fit_kernels *nsdf_fit_kernels_avx2(void) {
    return NULL;
}
#endif
