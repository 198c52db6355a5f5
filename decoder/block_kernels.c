/* Plain C, and the choice of a table: C first, then overridden upward. */
#define TARGET
#define NAME "c"
#define LANES 4
#define LANE_BITS(mask) ((uint32_t)(((mask)[0] & 1) | ((mask)[1] & 2) | ((mask)[2] & 4) | ((mask)[3] & 8)))

#include "block_kernels_impl.h"

#include "nsdf/decoder.h"

const nsdf_block_kernels *nsdf_block_kernels_c(void) {
    return &table;
}

const nsdf_block_kernels *nsdf_block_kernels_choose(uint32_t features) {
    const nsdf_block_kernels *chosen = &table;
    if ((features & NSDF_CPU_AVX2) && nsdf_block_kernels_avx2())
        chosen = nsdf_block_kernels_avx2();
    if ((features & NSDF_CPU_AVX512) && nsdf_block_kernels_avx512())
        chosen = nsdf_block_kernels_avx512();
    return chosen;
}
