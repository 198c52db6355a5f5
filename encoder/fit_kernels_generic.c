/* Fitting kernels for any processor; the compiler lowers the vectors to what there is. */
#define KERNELS_NAME "generic"
#define LANES 4
#define ROW_BLOCK 6
#define OUTER_ROWS 3
#define OUTER_COLS 3
#include "fit_kernels_impl.h"

const nsdf_fit_kernels *nsdf_fit_kernels_generic(void) {
    return &kernels;
}

const nsdf_fit_kernels *nsdf_fit_kernels_exact(void) {
    const nsdf_fit_kernels *best = &kernels;
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && nsdf_fit_kernels_avx2())
        best = nsdf_fit_kernels_avx2();
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && nsdf_fit_kernels_avx512())
        best = nsdf_fit_kernels_avx512();
#endif
    return best;
}

const nsdf_fit_kernels *nsdf_fit_kernels_short(void) {
#if defined(__x86_64__)
    if (nsdf_fit_kernels_exact() == nsdf_fit_kernels_avx512() && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512bf16"))
        return nsdf_fit_kernels_bf16();
#endif
    return NULL;
}

const nsdf_fit_kernels *nsdf_fit_kernels_select(void) {
    const nsdf_fit_kernels *products = nsdf_fit_kernels_short();
#if defined(__x86_64__)
    if (products && __builtin_cpu_is("amd")) /* Intel's do half as many products of bf16 as of single precision */
        return products;
#else
    (void)products;
#endif
    return nsdf_fit_kernels_exact();
}
