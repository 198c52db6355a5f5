/* The passes for AVX-512. */
#include "block_batch.h"

#if defined(__x86_64__) && defined(__GNUC__)

#ifdef __clang__
#define TARGET __attribute__((target("avx512f")))
#else
#define TARGET __attribute__((target("avx512f,prefer-vector-width=512")))
#endif

#include <immintrin.h>

/* As the plain one, by compression. */
TARGET static uint32_t append(nsdf_block_batch *b, float u[4][NSDF_HIT_LANES], uint32_t from, uint32_t n, uint32_t at);
#define OWN_APPEND
#include "block_passes_impl.h"

TARGET static uint32_t append(nsdf_block_batch *b, float u[4][LANES], uint32_t from, uint32_t n, uint32_t at) {
    const __m512i lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    const __mmask16 there = (__mmask16)((UINT32_C(1) << n) - 1);
    const __mmask16 inside =
        _mm512_mask_cmp_ps_mask(there, _mm512_loadu_ps(u[3]), _mm512_set1_ps(LEAST_ROOT), _CMP_GT_OQ);
    const __m512i point = _mm512_add_epi32(lanes, _mm512_set1_epi32((int)from));
    _mm512_storeu_si512(b->point + at, _mm512_maskz_compress_epi32(inside, point));
    for (int i = 0; i < 4; i++)
        _mm512_storeu_ps(b->hit[i] + at, _mm512_maskz_compress_ps(inside, _mm512_loadu_ps(u[i])));
    return at + (uint32_t)__builtin_popcount(inside);
}

const nsdf_block_passes *nsdf_block_passes_avx512(void) {
    return &passes;
}

#else

const nsdf_block_passes *nsdf_block_passes_avx512(void) {
    return NULL;
}

#endif
