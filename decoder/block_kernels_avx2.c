/* Block kernels for AVX2. */
#include "block_kernels.h"

#if defined(__x86_64__) && defined(__GNUC__)

#include <immintrin.h>

#define TARGET __attribute__((target("avx2")))
#define NAME "avx2"
#define LANES 8
#define LANE_BITS(mask) ((uint32_t)_mm256_movemask_ps((__m256)(mask)))

#define LIST_LANES(mask, from, to) list_lanes((uint32_t)_mm256_movemask_ps((__m256)(mask)), from, to)
#define LIST_BITS list_bits
#define ROUGH_INVERSE_ROOT(v) ((lanes)_mm256_rsqrt_ps((__m256)(v)))

/* Which of four bits are set, by their number, and how many. */
static const _Alignas(16) int32_t places[16][4] = {
    {0, 0, 0, 0}, {0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {2, 0, 0, 0}, {0, 2, 0, 0}, {1, 2, 0, 0}, {0, 1, 2, 0},
    {3, 0, 0, 0}, {0, 3, 0, 0}, {1, 3, 0, 0}, {0, 1, 3, 0}, {2, 3, 0, 0}, {0, 2, 3, 0}, {1, 2, 3, 0}, {0, 1, 2, 3}};
static const uint8_t counts[16] = {0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4};

/* Both without a loop whose end nobody could foresee. */
TARGET static inline uint32_t list_lanes(uint32_t bits, const uint32_t *from, uint32_t *to) {
    const uint32_t low = bits & 15, high = bits >> 4;
    for (uint32_t part = 0; part < 2; part++) {
        const __m128 numbers = _mm_loadu_ps((const float *)(from + 4 * part));
        const __m128i chosen = _mm_load_si128((const __m128i *)places[part ? high : low]);
        _mm_storeu_ps((float *)(part ? to + counts[low] : to), _mm_permutevar_ps(numbers, chosen));
    }
    return (uint32_t)counts[low] + counts[high];
}

TARGET static inline uint32_t list_bits(uint32_t bits, uint32_t first, uint32_t *to) {
    uint32_t count = 0;
    for (uint32_t part = 0; part < 4; part++, bits >>= 4) {
        const __m128i chosen = _mm_load_si128((const __m128i *)places[bits & 15]);
        _mm_storeu_si128((__m128i *)(to + count), _mm_add_epi32(chosen, _mm_set1_epi32((int)(first + 4 * part))));
        count += counts[bits & 15];
    }
    return count;
}

#include "block_kernels_impl.h"

const nsdf_block_kernels *nsdf_block_kernels_avx2(void) {
    return &table;
}

#else

const nsdf_block_kernels *nsdf_block_kernels_avx2(void) {
    return NULL;
}

#endif
