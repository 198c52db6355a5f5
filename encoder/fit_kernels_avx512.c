/* Fitting kernels for AVX-512; compiled with -mavx512f -mavx512dq on x86-64. */
#include "fit_kernels.h"
#if defined(__AVX512F__) && defined(__AVX512DQ__)
#define KERNELS_NAME "avx512"
#define LANES 16
#define ROW_BLOCK 12
#define OUTER_ROWS 4
#define OUTER_COLS 4
#include "fit_kernels_impl.h"

const nsdf_fit_kernels *nsdf_fit_kernels_avx512(void) {
    return &kernels;
}
#else
const nsdf_fit_kernels *nsdf_fit_kernels_avx512(void) {
    return NULL;
}
#endif
