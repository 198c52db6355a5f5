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

#define LIST_LANES(mask, from, to) list_lanes(_mm512_test_epi32_mask((__m512i)(mask), (__m512i)(mask)), from, to)
#define ROUGH_INVERSE_ROOT(v) ((lanes)_mm512_rsqrt14_ps((__m512)(v)))

/* Without a loop whose end nobody could foresee. */
TARGET static inline uint32_t list_lanes(__mmask16 mask, const uint32_t *from, uint32_t *to) {
    _mm512_storeu_si512(to, _mm512_maskz_compress_epi32(mask, _mm512_loadu_si512(from)));
    return (uint32_t)__builtin_popcount(mask);
}

#include "block_kernels_impl.h"

const nsdf_block_kernels *nsdf_block_kernels_avx512(void) {
    return &table;
}

#else

const nsdf_block_kernels *nsdf_block_kernels_avx512(void) {
    return NULL;
}

#endif
