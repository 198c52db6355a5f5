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
#define LIST_BITS list_bits
#define ROUGH_INVERSE_ROOT(v) ((lanes)_mm512_rsqrt14_ps((__m512)(v)))

/* Both without a loop whose end nobody could foresee. */
TARGET static inline uint32_t list_lanes(__mmask16 mask, const uint32_t *from, uint32_t *to) {
    _mm512_storeu_si512(to, _mm512_maskz_compress_epi32(mask, _mm512_loadu_si512(from)));
    return (uint32_t)__builtin_popcount(mask);
}

TARGET static inline uint32_t list_bits(uint32_t bits, uint32_t first, uint32_t *to) {
    const __m512i places = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    const __m512i numbers = _mm512_add_epi32(places, _mm512_set1_epi32((int)first));
    _mm512_storeu_si512(to, _mm512_maskz_compress_epi32((__mmask16)bits, numbers));
    return (uint32_t)__builtin_popcount(bits);
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
