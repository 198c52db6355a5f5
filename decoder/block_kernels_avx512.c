/* Block kernels for AVX-512. */
#include "block_kernels.h"

#if defined(__x86_64__) && defined(__GNUC__)

#include <immintrin.h>

#ifdef __clang__
#define TARGET __attribute__((target("avx512f")))
#else
#define TARGET __attribute__((target("avx512f,prefer-vector-width=512")))
#endif
#define NAME "avx512"
#define LANES 16
#define LANE_BITS(mask) ((uint32_t)_mm512_test_epi32_mask((__m512i)(mask), (__m512i)(mask)))

#define ROUGH_INVERSE_ROOT(v) ((lanes)_mm512_rsqrt14_ps((__m512)(v)))

#include "block_kernels_impl.h"

const nsdf_block_kernels *nsdf_block_kernels_avx512(void) {
    return &table;
}

#else

const nsdf_block_kernels *nsdf_block_kernels_avx512(void) {
    return NULL;
}

#endif
