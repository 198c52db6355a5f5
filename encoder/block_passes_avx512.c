/* The passes for AVX-512 on vectors of eight: twice the registers of AVX2, and compression.  Compiled with -mavx512f
 * -mavx512vl on x86-64. */
#include "block_batch.h"
#if defined(__AVX512F__) && defined(__AVX512VL__)

#include <immintrin.h>

#define PASSES_NAME "avx512"
#define W 8
#define OWN_APPEND

typedef float eight __attribute__((vector_size(32)));

/* As the plain ones. */
static inline __attribute__((always_inline)) size_t append_candidates(uint16_t *near, const eight root[1], float least,
                                                                      uint32_t from, uint32_t n, size_t at) {
    const __m256i each = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    const __mmask8 there = (__mmask8)((UINT32_C(1) << n) - 1);
    const __mmask8 inside = _mm256_mask_cmp_ps_mask(there, (__m256)root[0], _mm256_set1_ps(least), _CMP_GT_OQ);
    const __m256i point = _mm256_maskz_compress_epi32(inside, _mm256_add_epi32(each, _mm256_set1_epi32((int)from)));
    _mm_storeu_si128((__m128i *)(void *)(near + at), _mm256_cvtepi32_epi16(point));
    return at + (uint32_t)__builtin_popcount(inside);
}

static inline __attribute__((always_inline)) uint32_t append_hits(nsdf_block_work *w, const eight u[1][4],
                                                                  const uint16_t *point, uint32_t n, uint32_t at);

#include "block_passes_impl.h"

static inline uint32_t append_hits(nsdf_block_work *w, const eight u[1][4], const uint16_t *point, uint32_t n,
                                   uint32_t at) {
    const __mmask8 there = (__mmask8)((UINT32_C(1) << n) - 1);
    const __mmask8 inside = _mm256_mask_cmp_ps_mask(there, (__m256)u[0][3], _mm256_set1_ps(LEAST_ROOT), _CMP_GT_OQ);
    const __m256i points = _mm256_cvtepu16_epi32(_mm_loadu_si128((const __m128i *)(const void *)point));
    _mm256_storeu_si256((__m256i *)(void *)(w->point + at), _mm256_maskz_compress_epi32(inside, points));
    for (int i = 0; i < 4; i++)
        _mm256_storeu_ps(w->hit[i] + at, _mm256_maskz_compress_ps(inside, (__m256)u[0][i]));
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
