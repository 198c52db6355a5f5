/* Kernels for AArch64, whose vectors every processor has.  What is plain C beside them, as the block kernels, the
 * compiler turns into such vectors by itself. */
#include "net_kernels.h"

#if defined(__aarch64__) && defined(__GNUC__)

#include <arm_neon.h>

#define TARGET
#define NAME "neon"
#define LANES 4
#define ROWS 8 /* 8 rows of 3 vectors, 3 inputs and a weight: 28 of 32 registers */
#define VEC float32x4_t
#define AS_INT vreinterpretq_s32_f32
#define AS_VEC vreinterpretq_f32_s32
#define v_load vld1q_f32
#define v_store vst1q_f32
#define v_set vdupq_n_f32
#define v_add vaddq_f32
#define v_sub vsubq_f32
#define v_mul vmulq_f32
#define v_div vdivq_f32
#define v_fma(a, b, c) vfmaq_f32(c, a, b)
#define v_fnma(a, b, c) vfmsq_f32(c, a, b)
#define v_min vminq_f32 /* not a number when one is, which is what the others give where they are used */
#define v_max vmaxq_f32
#define v_and(x, y) AS_VEC(vandq_s32(AS_INT(x), AS_INT(y)))
#define v_or(x, y) AS_VEC(vorrq_s32(AS_INT(x), AS_INT(y)))
#define v_xor(x, y) AS_VEC(veorq_s32(AS_INT(x), AS_INT(y)))
#define v_bits(b) AS_VEC(vdupq_n_s32(b))
#define v_shift(x, n) AS_VEC(vshlq_n_s32(AS_INT(x), n))
#define v_addi(x, y) AS_VEC(vaddq_s32(AS_INT(x), AS_INT(y)))
#define v_positive(x, y) AS_VEC(vandq_s32(vreinterpretq_s32_u32(vcgtq_f32(x, vdupq_n_f32(0.0f))), AS_INT(y)))

#include "net_kernels_simd.h"

const nsdf_net_kernels *nsdf_net_kernels_neon(void) {
    return &table;
}

#else

const nsdf_net_kernels *nsdf_net_kernels_neon(void) {
    return NULL;
}

#endif
