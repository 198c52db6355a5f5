/* The passes for AVX-512; compiled with -mavx512f on x86-64. */
#include "block_batch.h"
#if defined(__AVX512F__)

#include <immintrin.h>

#define PASSES_NAME "avx512"
#define W 16
#define OWN_APPEND

/* As the plain ones, by compression. */
static inline size_t append_candidates(uint16_t *near, const float root[NSDF_HIT_LANES], float least, uint32_t from,
                                       uint32_t n, size_t at) {
    const __m512i lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    const __mmask16 there = (__mmask16)((UINT32_C(1) << n) - 1);
    const __mmask16 inside = _mm512_mask_cmp_ps_mask(there, _mm512_loadu_ps(root), _mm512_set1_ps(least), _CMP_GT_OQ);
    const __m512i point = _mm512_maskz_compress_epi32(inside, _mm512_add_epi32(lanes, _mm512_set1_epi32((int)from)));
    _mm256_storeu_si256((__m256i *)(void *)(near + at), _mm512_cvtepi32_epi16(point));
    return at + (uint32_t)__builtin_popcount(inside);
}

static inline uint32_t append_hits(nsdf_block_work *w, float u[4][NSDF_HIT_LANES], const uint16_t *point, uint32_t n,
                                   uint32_t at);

#include "block_passes_impl.h"

static inline uint32_t append_hits(nsdf_block_work *w, float u[4][LANES], const uint16_t *point, uint32_t n,
                                   uint32_t at) {
    const __mmask16 there = (__mmask16)((UINT32_C(1) << n) - 1);
    const __mmask16 inside =
        _mm512_mask_cmp_ps_mask(there, _mm512_loadu_ps(u[3]), _mm512_set1_ps(LEAST_ROOT), _CMP_GT_OQ);
    const __m512i points = _mm512_cvtepu16_epi32(_mm256_loadu_si256((const __m256i *)(const void *)point));
    _mm512_storeu_si512(w->point + at, _mm512_maskz_compress_epi32(inside, points));
    for (int i = 0; i < 4; i++)
        _mm512_storeu_ps(w->hit[i] + at, _mm512_maskz_compress_ps(inside, _mm512_loadu_ps(u[i])));
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
