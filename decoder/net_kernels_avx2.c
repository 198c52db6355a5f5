/* Kernels for AVX2 with FMA. */
#include "net_kernels.h"

#if defined(__x86_64__) && defined(__GNUC__)

#include <immintrin.h>

#define TARGET __attribute__((target("avx2,fma")))
#define NAME "avx2"
#define LANES 8
#define ROWS 4 /* 4 rows of 3 vectors, 3 inputs and a weight: all 16 registers */
#define VEC __m256
#define v_load _mm256_loadu_ps
#define v_store _mm256_storeu_ps
#define v_set _mm256_set1_ps
#define v_add _mm256_add_ps
#define v_sub _mm256_sub_ps
#define v_mul _mm256_mul_ps
#define v_div _mm256_div_ps
#define v_fma _mm256_fmadd_ps
#define v_fnma _mm256_fnmadd_ps
#define v_min _mm256_min_ps
#define v_max _mm256_max_ps
#define v_and _mm256_and_ps
#define v_or _mm256_or_ps
#define v_xor _mm256_xor_ps
#define v_bits(b) _mm256_castsi256_ps(_mm256_set1_epi32(b))
#define v_shift(x, n) _mm256_castsi256_ps(_mm256_slli_epi32(_mm256_castps_si256(x), n))
#define v_addi(x, y) _mm256_castsi256_ps(_mm256_add_epi32(_mm256_castps_si256(x), _mm256_castps_si256(y)))
#define v_positive(x, y) _mm256_and_ps(_mm256_cmp_ps(x, _mm256_setzero_ps(), _CMP_GT_OQ), y)

#include "net_kernels_simd.h"

const nsdf_net_kernels *nsdf_net_kernels_avx2(void) {
    return &table;
}

#else

const nsdf_net_kernels *nsdf_net_kernels_avx2(void) {
    return NULL;
}

#endif
