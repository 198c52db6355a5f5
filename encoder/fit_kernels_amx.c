/* Fitting kernels for AVX-512 with products of bf16 numbers by AMX; compiled with -mavx512f -mavx512dq -mavx512bw
 * -mavx512bf16 -mamx-tile -mamx-bf16 on x86-64.  One instruction multiplies sixteen rows of 32 bf16 numbers by 32 of
 * sixteen columns and adds to 256 sums in single precision. */
#define _DEFAULT_SOURCE /* for syscall */
#include "fit_kernels.h"
#if defined(__AVX512F__) && defined(__AVX512DQ__) && defined(__AVX512BW__) && defined(__AVX512BF16__) &&               \
    defined(__AMX_BF16__) && defined(__linux__)
#define KERNELS_NAME "avx512-amx"
#define LANES 16
#define ROW_BLOCK 16
#define PAIR_BLOCK 16
#define OUTER_ROWS 4
#define OUTER_COLS 4
#define OWN_SHORT
#include "fit_kernels_impl.h"
#include "fit_kernels_short.h"

#include <cpuid.h>
#include <sys/syscall.h>
#include <unistd.h>

static uint32_t block_of(uint32_t left) {
    return left < ROW_BLOCK ? left : ROW_BLOCK;
}

/* ---- Tiles ----------------------------------------------------------------------------------------------- */

/* Numbers of tiles; macros, since the intrinsics put them into names of registers. */
#define FIRST_SUM 0
#define SECOND_SUM 1
#define ROWS 2
#define FIRST_COLUMNS 3
#define SECOND_COLUMNS 4
enum { TILES = 5 };

/* As LDTILECFG reads it (Intel's manual, volume 1, 18.2). */
typedef struct tile_config {
    uint8_t palette, start_row, reserved[14];
    uint16_t row_bytes[16];
    uint8_t rows[16];
} tile_config;

/* All tiles have sixteen rows of 64 bytes. */
static void begin_products(void) {
    tile_config config = {.palette = 1};
    for (int i = 0; i < TILES; i++) {
        config.row_bytes[i] = 64;
        config.rows[i] = ROW_BLOCK;
    }
    _tile_loadconfig(&config);
}

static void end_products(void) {
    _tile_release();
}

/* Sixteen rows, of which n are wanted; there is room for those only. */
static inline __attribute__((always_inline)) void block_times_pairs(uint32_t n, const int32_t *a, const size_t stride,
                                                                    size_t count, const pairs (*x)[2],
                                                                    vec sums[ROW_BLOCK][2]) {
    vec all[ROW_BLOCK][2];
    vec(*to)[2] = n == ROW_BLOCK ? sums : all;
    __asm__ volatile("" ::: "memory"); /* what tiles load has been stored: their intrinsics do not say what they read */
    _tile_zero(FIRST_SUM);
    _tile_zero(SECOND_SUM);
    for (size_t i = 0; i < count; i += PAIR_BLOCK) {
        _tile_loadd(ROWS, a + i, stride * sizeof *a);
        _tile_loadd(FIRST_COLUMNS, &x[i][0], sizeof *x);
        _tile_loadd(SECOND_COLUMNS, &x[i][1], sizeof *x);
        _tile_dpbf16ps(FIRST_SUM, ROWS, FIRST_COLUMNS);
        _tile_dpbf16ps(SECOND_SUM, ROWS, SECOND_COLUMNS);
    }
    _tile_stored(FIRST_SUM, &to[0][0], sizeof *to);
    _tile_stored(SECOND_SUM, &to[0][1], sizeof *to);
    if (to == all)
        memcpy(sums, all, n * sizeof *all);
}

static void matrix_block(uint32_t n, const int32_t *a, size_t count, const pairs (*x)[2], vec sums[ROW_BLOCK][2]) {
    block_times_pairs(n, a, MATRIX_STRIDE, count, x, sums);
}

static void points_block(uint32_t n, const int32_t *a, size_t count, const pairs (*x)[2], vec sums[ROW_BLOCK][2]) {
    block_times_pairs(n, a, TILE_PAIRS, count, x, sums);
}

static const nsdf_fit_kernels kernels = {KERNELS_NAME, multiply, outer,      multiply_short, outer_short,
                                         sine,         relu,     tanh_panel, scale};

/* Linux gives tiles to a process that asks for them (arch_prctl(2)). */
static int may_use_tiles(void) {
    enum { REQUEST = 0x1023, TILE_DATA = 18 };
    const unsigned tile = 1u << 24, bf16 = 1u << 22;
    unsigned eax = 0, ebx = 0, ecx = 0, edx = 0;
    return __get_cpuid_count(7, 0, &eax, &ebx, &ecx, &edx) && edx & tile && edx & bf16 &&
           syscall(SYS_arch_prctl, REQUEST, TILE_DATA) == 0;
}

const nsdf_fit_kernels *nsdf_fit_kernels_amx(void) {
    return may_use_tiles() ? &kernels : NULL;
}
#else
const nsdf_fit_kernels *nsdf_fit_kernels_amx(void) {
    return NULL;
}
#endif
