/* Fitting kernels for AVX-512 with products of bf16 numbers; compiled with -mavx512f -mavx512dq -mavx512bw -mavx512bf16
 * on x86-64.  One instruction multiplies 32 pairs of numbers of eight bits and adds neighbouring products to 16 sums in
 * single precision: twice what a multiplication and addition of single precision does, where it is as fast. */
#include "fit_kernels.h"
#if defined(__AVX512F__) && defined(__AVX512DQ__) && defined(__AVX512BW__) && defined(__AVX512BF16__)
#define KERNELS_NAME "avx512-bf16"
#define LANES 16
#define ROW_BLOCK 12
#define PAIR_BLOCK 1
#define OUTER_ROWS 4
#define OUTER_COLS 4
#define OWN_SHORT
#include "fit_kernels_impl.h"

#include "fit_kernels_short.h"

/* Sums indexed by a loop counter are registers only when the loop is gone. */
#if defined(__clang__)
#define UNROLL _Pragma("clang loop unroll(full)")
#else
#define UNROLL _Pragma("GCC unroll 32")
#endif

static inline vec add_products(vec sum, pairs a, pairs b) {
    return (vec)_mm512_dpbf16_ps((__m512)sum, (__m512bh)a, (__m512bh)b);
}

/* sums[r][c] = sum over i of a[r * stride + i] times x[i][c], for n rows and two vectors; n and stride are constants
 * wherever this is inlined. */
static inline __attribute__((always_inline)) void rows_times_pairs(const int n, const int32_t *a, const size_t stride,
                                                                   size_t count, const pairs (*x)[2],
                                                                   vec sums[ROW_BLOCK][2]) {
    vec lo[ROW_BLOCK], hi[ROW_BLOCK];
    UNROLL
    for (int r = 0; r < n; r++)
        lo[r] = hi[r] = (vec){0};
    for (size_t i = 0; i < count; i++) {
        const pairs xl = x[i][0], xh = x[i][1];
        UNROLL
        for (int r = 0; r < n; r++) {
            const pairs w = a[(size_t)r * stride + i] - (pairs){0};
            lo[r] = add_products(lo[r], w, xl);
            hi[r] = add_products(hi[r], w, xh);
        }
    }
    UNROLL
    for (int r = 0; r < n; r++) {
        sums[r][0] = lo[r];
        sums[r][1] = hi[r];
    }
}

static uint32_t block_of(uint32_t left) {
    return left >= ROW_BLOCK ? ROW_BLOCK : left >= 8 ? 8 : left >= 4 ? 4 : 1;
}

static inline __attribute__((always_inline)) void block_times_pairs(uint32_t n, const int32_t *a, const size_t stride,
                                                                    size_t count, const pairs (*x)[2],
                                                                    vec sums[ROW_BLOCK][2]) {
    if (n == ROW_BLOCK)
        rows_times_pairs(ROW_BLOCK, a, stride, count, x, sums);
    else if (n == 8)
        rows_times_pairs(8, a, stride, count, x, sums);
    else if (n == 4)
        rows_times_pairs(4, a, stride, count, x, sums);
    else
        rows_times_pairs(1, a, stride, count, x, sums);
}

/* Functions of their own, so that nothing around the loop takes registers from the sums. */
static __attribute__((noinline)) void matrix_block(uint32_t n, const int32_t *a, size_t count, const pairs (*x)[2],
                                                   vec sums[ROW_BLOCK][2]) {
    block_times_pairs(n, a, MATRIX_STRIDE, count, x, sums);
}

static __attribute__((noinline)) void points_block(uint32_t n, const int32_t *a, size_t count, const pairs (*x)[2],
                                                   vec sums[ROW_BLOCK][2]) {
    block_times_pairs(n, a, TILE_PAIRS, count, x, sums);
}

static void begin_products(void) {}

static void end_products(void) {}

static const nsdf_fit_kernels kernels = {KERNELS_NAME, multiply, outer,      multiply_short, outer_short,
                                         sine,         relu,     tanh_panel, scale};

const nsdf_fit_kernels *nsdf_fit_kernels_bf16(void) {
    return &kernels;
}
#else
const nsdf_fit_kernels *nsdf_fit_kernels_bf16(void) {
    return NULL;
}
#endif
