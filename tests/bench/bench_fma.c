#include "bench_fma.h"

#include <string.h>

#include "cpu.h"
#include "nsdf/decoder.h"

/* Independent chains: with two constants they fill sixteen registers, and are enough to hide the latency of two
 * multiplications and two additions a cycle. */
enum { CHAINS = 14 };

#if defined(__clang__)
#define UNROLL _Pragma("clang loop unroll(full)")
#else
#define UNROLL _Pragma("GCC unroll 14")
#endif

/* x -> x / 2 + 1, whose limit is 2: neither overflow nor denormals.  All chains are summed up: the compiler leaves out
 * those that nobody reads. */
#define DEFINE_LOOP(NAME, TARGET, VEC, SET, STEP)                                                                      \
    TARGET static float NAME(uint32_t turns) {                                                                         \
        const VEC half = SET(0.5f), one = SET(1.0f);                                                                   \
        VEC chain[CHAINS];                                                                                             \
        float lanes[CHAINS * sizeof(VEC) / sizeof(float)], sum = 0.0f;                                                 \
        UNROLL for (int i = 0; i < CHAINS; i++) chain[i] = SET((float)i);                                              \
        for (; turns > 0; turns--) {                                                                                   \
            UNROLL for (int i = 0; i < CHAINS; i++) chain[i] = STEP(chain[i], half, one);                              \
        }                                                                                                              \
        memcpy(lanes, chain, sizeof lanes);                                                                            \
        for (size_t i = 0; i < sizeof lanes / sizeof *lanes; i++)                                                      \
            sum += lanes[i];                                                                                           \
        return sum;                                                                                                    \
    }

#if defined(__GNUC__)
typedef float vec4 __attribute__((vector_size(16)));
#define SET4(x) ((vec4){x, x, x, x})
#else
typedef float vec4;
#define SET4(x) (x)
#endif
#define STEP4(x, a, b) ((x) * (a) + (b))
DEFINE_LOOP(loop_c, , vec4, SET4, STEP4)

#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>
DEFINE_LOOP(loop_avx2, __attribute__((target("avx2,fma"))), __m256, _mm256_set1_ps, _mm256_fmadd_ps)
DEFINE_LOOP(loop_avx512, __attribute__((target("avx512f"))), __m512, _mm512_set1_ps, _mm512_fmadd_ps)
#else
#define loop_avx2 NULL
#define loop_avx512 NULL
#endif

static const struct {
    const char *name;
    uint32_t feature, lanes;
    float (*loop)(uint32_t turns);
} sets[BENCH_ISA_COUNT] = {
    {"c", 0, sizeof(vec4) / sizeof(float), loop_c},
    {"avx2", NSDF_CPU_AVX2, 8, loop_avx2},
    {"avx512", NSDF_CPU_AVX512, 16, loop_avx512},
};

const char *bench_isa_name(bench_isa isa) {
    return sets[isa].name;
}

bench_isa bench_isa_of_name(const char *name) {
    bench_isa isa = BENCH_ISA_COUNT;
    while (isa-- > 0)
        if (strncmp(sets[isa].name, name, strlen(sets[isa].name)) == 0)
            return isa;
    return BENCH_ISA_C;
}

int bench_isa_is_here(bench_isa isa) {
    return sets[isa].loop && (sets[isa].feature & ~nsdf_cpu_features()) == 0;
}

bench_isa bench_isa_best(void) {
    bench_isa isa = BENCH_ISA_COUNT - 1;
    while (!bench_isa_is_here(isa))
        isa--;
    return isa;
}

double bench_fma_flop(bench_isa isa, uint32_t turns) {
    return 2.0 * CHAINS * sets[isa].lanes * turns;
}

float bench_fma_loop(bench_isa isa, uint32_t turns) {
    return sets[isa].loop(turns);
}
