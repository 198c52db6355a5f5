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

const nsdf_fit_kernels *nsdf_fit_kernels_select(void) {
    const nsdf_fit_kernels *exact = nsdf_fit_kernels_exact();
#if defined(__x86_64__)
    if (exact == nsdf_fit_kernels_avx512() && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512bf16") && nsdf_fit_kernels_bf16())
        return nsdf_fit_kernels_bf16();
#endif
    return exact;
}
