/* Bytes a second that one thread reads from each level of memory. */
#include <stdlib.h>
#include <string.h>

#include "bench_kernels.h"

/* Within the first cache, within the second, and beyond all. */
static const struct {
    const char *name;
    size_t bytes;
} levels[] = {{"first-level cache", 16u << 10}, {"second-level cache", 384u << 10}, {"memory", 128u << 20}};
enum { LEVELS = sizeof levels / sizeof *levels };

typedef struct reading {
    float *values;
    size_t count;
    bench_isa isa;
    volatile float sum;
} reading;

#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>

__attribute__((target("avx2"))) static float read_avx2(const float *p, size_t count) {
    __m256 a = _mm256_setzero_ps(), b = a, c = a, d = a;
    for (const float *end = p + count; p < end; p += 32) {
        a = _mm256_or_ps(a, _mm256_load_ps(p));
        b = _mm256_or_ps(b, _mm256_load_ps(p + 8));
        c = _mm256_or_ps(c, _mm256_load_ps(p + 16));
        d = _mm256_or_ps(d, _mm256_load_ps(p + 24));
    }
    return _mm256_cvtss_f32(_mm256_or_ps(_mm256_or_ps(a, b), _mm256_or_ps(c, d)));
}

__attribute__((target("avx512f"))) static float read_avx512(const float *p, size_t count) {
    __m512i a = _mm512_setzero_si512(), b = a;
    for (const float *end = p + count; p < end; p += 32) {
        a = _mm512_or_si512(a, _mm512_load_si512(p));
        b = _mm512_or_si512(b, _mm512_load_si512(p + 16));
    }
    return _mm512_cvtss_f32(_mm512_castsi512_ps(_mm512_or_si512(a, b)));
}
#else
#define read_avx2 read_c
#define read_avx512 read_c
#endif

static float read_c(const float *p, size_t count) {
    float sum[32] = {0.0f};
    for (const float *end = p + count; p < end; p += 32)
        for (int i = 0; i < 32; i++)
            sum[i] += p[i];
    return sum[0];
}

static void run_read(void *data) {
    reading *r = data;
    r->sum = (r->isa == BENCH_ISA_AVX512 ? read_avx512
              : r->isa == BENCH_ISA_AVX2 ? read_avx2
                                         : read_c)(r->values, r->count);
}

void kernels_add_memory(kernels_list *list) {
    static reading readings[LEVELS];
    for (int i = 0; i < LEVELS; i++) {
        const size_t count = levels[i].bytes / sizeof(float);
        const kernels_entry entry = {"peak", bench_isa_best(), KERNELS_BYTES, (double)levels[i].bytes, 0.0, "", -1};
        readings[i].values = bench_floats(count);
        readings[i].count = count;
        readings[i].isa = bench_isa_best();
        kernels_add(list, &entry, levels[i].name, run_read, &readings[i]);
    }
}
