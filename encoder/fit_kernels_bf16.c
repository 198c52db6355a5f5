/* Fitting kernels for AVX-512 with products of bf16 numbers; compiled with -mavx512f -mavx512dq -mavx512bw -mavx512bf16
 * on x86-64.  One instruction multiplies 32 pairs of numbers of eight bits and adds neighbouring products to 16 sums in
 * single precision: twice what a multiplication and addition of single precision does. */
#include "fit_kernels.h"
#if defined(__AVX512F__) && defined(__AVX512DQ__) && defined(__AVX512BW__) && defined(__AVX512BF16__)
#define KERNELS_NAME "avx512-bf16"
#define LANES 16
#define ROW_BLOCK 12
#define OUTER_ROWS 4
#define OUTER_COLS 4
#define OWN_SHORT
#include "fit_kernels_impl.h"

#include <immintrin.h>

/* Sums indexed by a loop counter are registers only when the loop is gone. */
#if defined(__clang__)
#define UNROLL _Pragma("clang loop unroll(full)")
#else
#define UNROLL _Pragma("GCC unroll 32")
#endif

/* Each lane two bf16 numbers, the even one in the low half. */
typedef int32_t pairs __attribute__((vector_size(64)));

enum {
    WIDEST = 160,               /* columns that fit into buffers on the stack; beyond, products are exact */
    MATRIX_STRIDE = WIDEST / 2, /* constants, so that rows are one pointer and offsets */
    TILE_PANELS = 16,
    TILE_PAIRS = TILE_PANELS * NSDF_PANEL / 2
};

/* Sixteen numbers and sixteen more, in order. */
static inline pairs to_bf16(vec low, vec high) {
    return (pairs)_mm512_cvtne2ps_pbh((__m512)high, (__m512)low);
}

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

/* The largest block of rows that is not more than `left`. */
static inline uint32_t block_of(uint32_t left) {
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

/* ---- A matrix times points ------------------------------------------------------------------------------- */

/* The next numbers of a row, as many as there are up to 16; the others are 0. */
static inline vec load_row(const float *row, uint32_t left) {
    const __mmask16 there = (__mmask16)(left >= LANES ? 0xffff : (1u << left) - 1);
    return (vec)_mm512_maskz_loadu_ps(there, row);
}

/* Rows of the matrix in bf16, neighbouring columns in pairs, and zeros behind them. */
static void pack_matrix(const float *a, size_t stride, uint32_t rows, uint32_t cols, int32_t (*packed)[MATRIX_STRIDE]) {
    for (uint32_t r = 0; r < rows; r++)
        for (uint32_t i = 0; i < cols; i += 2 * LANES) {
            const float *row = a + r * stride + i;
            const uint32_t left = cols - i;
            const pairs p = to_bf16(load_row(row, left), load_row(row + LANES, left > LANES ? left - LANES : 0));
            memcpy(packed[r] + i / 2, &p, sizeof p);
        }
}

/* Lane p: a[p] and b[p]. */
static inline pairs interleave(vec a, vec b) {
    const __m512i order = _mm512_set_epi16(31, 15, 30, 14, 29, 13, 28, 12, 27, 11, 26, 10, 25, 9, 24, 8, 23, 7, 22, 6,
                                           21, 5, 20, 4, 19, 3, 18, 2, 17, 1, 16, 0);
    return (pairs)_mm512_permutexvar_epi16(order, (__m512i)to_bf16(a, b));
}

/* Neighbouring rows of a panel in pairs. */
static void pack_panel(const float *x, uint32_t rows, pairs (*packed)[2]) {
    for (uint32_t i = 0; i < rows; i += 2)
        for (int part = 0; part < 2; part++) {
            const float *row = x + (size_t)i * NSDF_PANEL + part * LANES;
            packed[i / 2][part] = interleave(load(row), i + 1 < rows ? load(row + NSDF_PANEL) : (vec){0});
        }
}

static void multiply_short(const float *a, size_t stride, uint32_t rows, uint32_t cols, const float *x, size_t x_panel,
                           float *y, size_t y_panel, uint32_t panels) {
    int32_t matrix[WIDEST][MATRIX_STRIDE];
    pairs panel[MATRIX_STRIDE][2];
    if (rows > WIDEST || cols > WIDEST) {
        multiply(a, stride, rows, cols, x, x_panel, y, y_panel, panels);
        return;
    }
    pack_matrix(a, stride, rows, cols, matrix);
    for (uint32_t k = 0; k < panels; k++) {
        pack_panel(x + k * x_panel, cols, panel);
        for (uint32_t o = 0, n; o < rows; o += n) {
            n = block_of(rows - o);
            matrix_block(n, matrix[o], (cols + 1) / 2, (const pairs(*)[2])panel,
                         (vec(*)[2])(y + k * y_panel + (size_t)o * NSDF_PANEL));
        }
    }
}

/* ---- Sums over points ------------------------------------------------------------------------------------ */

/* Lane j of v[i] and lane i of v[j] change places: single lanes, then twos, fours and eights. */
static inline __attribute__((always_inline)) void transpose_lanes(pairs v[LANES]) {
#define EXCHANGE(step, low, high)                                                                                      \
    for (int i = 0; i < LANES; i++)                                                                                    \
        if (!(i & (step))) {                                                                                           \
            const pairs a = v[i], b = v[i + (step)];                                                                   \
            v[i] = __builtin_shufflevector(a, b, low);                                                                 \
            v[i + (step)] = __builtin_shufflevector(a, b, high);                                                       \
        }
#define LIST(...) __VA_ARGS__
    EXCHANGE(1, LIST(0, 16, 2, 18, 4, 20, 6, 22, 8, 24, 10, 26, 12, 28, 14, 30),
             LIST(1, 17, 3, 19, 5, 21, 7, 23, 9, 25, 11, 27, 13, 29, 15, 31))
    EXCHANGE(2, LIST(0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29),
             LIST(2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31))
    EXCHANGE(4, LIST(0, 1, 2, 3, 16, 17, 18, 19, 8, 9, 10, 11, 24, 25, 26, 27),
             LIST(4, 5, 6, 7, 20, 21, 22, 23, 12, 13, 14, 15, 28, 29, 30, 31))
    EXCHANGE(8, LIST(0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23),
             LIST(8, 9, 10, 11, 12, 13, 14, 15, 24, 25, 26, 27, 28, 29, 30, 31))
#undef LIST
#undef EXCHANGE
}

/* Lanes are sixteen columns, rows of x; [pair of points]. */
static void pack_columns(const float *x, size_t x_panel, uint32_t panels, pairs (*packed)[2], int part) {
    for (uint32_t k = 0; k < panels; k++) {
        pairs v[LANES];
        for (int c = 0; c < LANES; c++) {
            const float *row = x + k * x_panel + (size_t)c * NSDF_PANEL;
            v[c] = to_bf16(load(row), load(row + LANES));
        }
        transpose_lanes(v);
        for (uint32_t p = 0; p < LANES; p++)
            packed[k * LANES + p][part] = v[p];
    }
}

/* Rows of dz, neighbouring points in pairs. */
static void pack_rows(const float *dz, size_t dz_panel, uint32_t rows, uint32_t panels, int32_t (*packed)[TILE_PAIRS]) {
    for (uint32_t k = 0; k < panels; k++)
        for (uint32_t r = 0; r < rows; r++) {
            const float *row = dz + k * dz_panel + (size_t)r * NSDF_PANEL;
            const pairs p = to_bf16(load(row), load(row + LANES));
            memcpy(packed[r] + k * LANES, &p, sizeof p);
        }
}

static inline void add_to(float *g, vec sum) {
    vec before;
    memcpy(&before, g, sizeof before);
    sum += before;
    memcpy(g, &sum, sizeof sum);
}

/* One or two vectors of columns. */
static void outer_columns(const float *dz, size_t dz_panel, uint32_t rows, const pairs (*x)[2], uint32_t vectors,
                          float *g, size_t stride, uint32_t panels) {
    int32_t packed[ROW_BLOCK][TILE_PAIRS] __attribute__((aligned(64)));
    for (uint32_t o = 0, n; o < rows; o += n) {
        vec sums[ROW_BLOCK][2];
        n = block_of(rows - o);
        pack_rows(dz + (size_t)o * NSDF_PANEL, dz_panel, n, panels, packed);
        points_block(n, packed[0], (size_t)panels * LANES, x, sums);
        for (uint32_t r = 0; r < n; r++)
            for (uint32_t c = 0; c < vectors; c++)
                add_to(g + (o + r) * stride + c * LANES, sums[r][c]);
    }
}

/* Columns that fill no vector, which are few, are exact. */
static void outer_short(const float *dz, size_t dz_panel, uint32_t rows, const float *x, size_t x_panel, uint32_t cols,
                        float *g, size_t stride, uint32_t panels) {
    const uint32_t whole = cols / LANES * LANES;
    pairs packed[TILE_PAIRS][2];
    memset(packed, 0, sizeof packed);
    for (uint32_t k = 0; k < panels; k += TILE_PANELS) {
        const uint32_t now = panels - k < TILE_PANELS ? panels - k : TILE_PANELS;
        for (uint32_t i = 0; i < whole; i += 2 * LANES) {
            const uint32_t vectors = whole - i < 2 * LANES ? 1 : 2;
            for (uint32_t part = 0; part < vectors; part++)
                pack_columns(x + k * x_panel + (size_t)(i + part * LANES) * NSDF_PANEL, x_panel, now, packed,
                             (int)part);
            outer_columns(dz + k * dz_panel, dz_panel, rows, (const pairs(*)[2])packed, vectors, g + i, stride, now);
        }
    }
    outer(dz, dz_panel, rows, x + (size_t)whole * NSDF_PANEL, x_panel, cols - whole, g + whole, stride, panels);
}

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
