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

uint32_t nsdf_fit_kernels_list_short(const nsdf_fit_kernels *sets[NSDF_FIT_SHORT_SETS]) {
    uint32_t count = 0;
#if defined(__x86_64__)
    if (nsdf_fit_kernels_exact() != nsdf_fit_kernels_avx512() || !__builtin_cpu_supports("avx512bw") ||
        !__builtin_cpu_supports("avx512bf16"))
        return 0;
    const nsdf_fit_kernels *const built[NSDF_FIT_SHORT_SETS] = {nsdf_fit_kernels_bf16(), nsdf_fit_kernels_amx()};
    for (int i = 0; i < NSDF_FIT_SHORT_SETS; i++)
        if (built[i])
            sets[count++] = built[i];
#else
    (void)sets;
#endif
    return count;
}

const nsdf_fit_kernels *nsdf_fit_kernels_select(void) {
#if defined(__x86_64__)
    const nsdf_fit_kernels *sets[NSDF_FIT_SHORT_SETS];
    const uint32_t count = nsdf_fit_kernels_list_short(sets);
    /* Intel's processors do half as many products of bf16 as of single precision, unless they do them by tiles. */
    if (count > 0 && (sets[count - 1] != nsdf_fit_kernels_bf16() || __builtin_cpu_is("amd")))
        return sets[count - 1];
#endif
    return nsdf_fit_kernels_exact();
}
