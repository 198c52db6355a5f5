/* Block kernels for AVX2. */
#include "block_kernels.h"

#if defined(__x86_64__) && defined(__GNUC__)

#include <immintrin.h>

#define TARGET __attribute__((target("avx2")))
#define NAME "avx2"
#define LANES 8
#define LANE_BITS(mask) ((uint32_t)_mm256_movemask_ps((__m256)(mask)))

#define ROUGH_INVERSE_ROOT(v) ((lanes)_mm256_rsqrt_ps((__m256)(v)))

#include "block_kernels_impl.h"

const nsdf_block_kernels *nsdf_block_kernels_avx2(void) {
    return &table;
}

#else

const nsdf_block_kernels *nsdf_block_kernels_avx2(void) {
    return NULL;
}

#endif
