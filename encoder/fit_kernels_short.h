/* Products with factors rounded to bf16 and sums in single precision: packing, which the sets that have them share.
 * Included after fit_kernels_impl.h by a source file that defines OWN_SHORT, LANES 16, and
 *   ROW_BLOCK    most rows of a product that are summed at once
 *   PAIR_BLOCK   pairs are summed by so many
 * and the functions declared below. */
#include <immintrin.h>

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

/* How many of `left` rows the next block has, at most ROW_BLOCK. */
static uint32_t block_of(uint32_t left);

/* sums[r][c] = sum over i of a[r * stride + i] times x[i][c], for n rows and two vectors, with the stride MATRIX_STRIDE
 * or TILE_PAIRS.  Up to the next multiple of PAIR_BLOCK both factors are 0. */
static void matrix_block(uint32_t n, const int32_t *a, size_t count, const pairs (*x)[2], vec sums[ROW_BLOCK][2]);
static void points_block(uint32_t n, const int32_t *a, size_t count, const pairs (*x)[2], vec sums[ROW_BLOCK][2]);

/* Around the blocks of a product. */
static void begin_products(void);
static void end_products(void);

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

/* Neighbouring rows of a panel in pairs, and zeros behind them. */
static void pack_panel(const float *x, uint32_t rows, pairs (*packed)[2]) {
    const uint32_t count = (rows + 1) / 2, whole = (count + PAIR_BLOCK - 1) / PAIR_BLOCK * PAIR_BLOCK;
    for (uint32_t i = 0; i < rows; i += 2)
        for (int part = 0; part < 2; part++) {
            const float *row = x + (size_t)i * NSDF_PANEL + part * LANES;
            packed[i / 2][part] = interleave(load(row), i + 1 < rows ? load(row + NSDF_PANEL) : (vec){0});
        }
    for (uint32_t i = count; i < whole; i++)
        packed[i][0] = packed[i][1] = (pairs){0};
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
    begin_products();
    for (uint32_t k = 0; k < panels; k++) {
        pack_panel(x + k * x_panel, cols, panel);
        for (uint32_t o = 0, n; o < rows; o += n) {
            n = block_of(rows - o);
            matrix_block(n, matrix[o], (cols + 1) / 2, (const pairs(*)[2])panel,
                         (vec(*)[2])(y + k * y_panel + (size_t)o * NSDF_PANEL));
        }
    }
    end_products();
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
    begin_products();
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
    end_products();
    outer(dz, dz_panel, rows, x + (size_t)whole * NSDF_PANEL, x_panel, cols - whole, g + whole, stride, panels);
}
