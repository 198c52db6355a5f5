/* The passes for any processor, and the choice among them. */
#define PASSES_NAME "generic"
#define W 4
#include "block_passes_impl.h"

const nsdf_block_passes *nsdf_block_passes_generic(void) {
    return &passes;
}

const nsdf_block_passes *nsdf_block_passes_select(void) {
    const nsdf_block_passes *best = &passes;
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2") && nsdf_block_passes_avx2())
        best = nsdf_block_passes_avx2();
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && nsdf_block_passes_avx512())
        best = nsdf_block_passes_avx512();
#endif
    return best;
}
