/* Kernels for AVX-512F. */
#include "net_kernels.h"

#if defined(__x86_64__) && defined(__GNUC__)

#include <immintrin.h>

#define TARGET __attribute__((target("avx512f")))
#define NAME "avx512"
#define LANES 16
#define ROWS 8 /* 8 rows of 3 vectors, 3 inputs and a weight: 28 of 32 registers */
#define VEC __m512
#define AS_INT _mm512_castps_si512
#define AS_VEC _mm512_castsi512_ps
#define v_load _mm512_loadu_ps
#define v_store _mm512_storeu_ps
#define v_set _mm512_set1_ps
#define v_add _mm512_add_ps
#define v_sub _mm512_sub_ps
#define v_mul _mm512_mul_ps
#define v_div _mm512_div_ps
#define v_fma _mm512_fmadd_ps
#define v_fnma _mm512_fnmadd_ps
#define v_min _mm512_min_ps
#define v_max _mm512_max_ps
/* Bitwise operations on floats came with AVX-512DQ only. */
#define v_and(x, y) AS_VEC(_mm512_and_si512(AS_INT(x), AS_INT(y)))
#define v_or(x, y) AS_VEC(_mm512_or_si512(AS_INT(x), AS_INT(y)))
#define v_xor(x, y) AS_VEC(_mm512_xor_si512(AS_INT(x), AS_INT(y)))
#define v_bits(b) AS_VEC(_mm512_set1_epi32(b))
#define v_shift(x, n) AS_VEC(_mm512_slli_epi32(AS_INT(x), n))
#define v_addi(x, y) AS_VEC(_mm512_add_epi32(AS_INT(x), AS_INT(y)))
#define v_positive(x, y) _mm512_maskz_mov_ps(_mm512_cmp_ps_mask(x, _mm512_setzero_ps(), _CMP_GT_OQ), y)

#include "net_kernels_simd.h"

const nsdf_net_kernels *nsdf_net_kernels_avx512(void) {
    return &table;
}

#else

const nsdf_net_kernels *nsdf_net_kernels_avx512(void) {
    return NULL;
}

#endif
