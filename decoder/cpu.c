/* CPU features by cpuid, and by xgetbv whether the operating system saves the wide registers (Intel SDM vol. 1, 14.3
 * and 15.2). */
#include "cpu.h"
#include "nsdf/decoder.h"

#if defined(__x86_64__) && defined(__GNUC__)

#include <cpuid.h>

enum {
    LEAF1_ECX_FMA = 1 << 12,
    LEAF1_ECX_OSXSAVE = 1 << 27,
    LEAF7_EBX_AVX2 = 1 << 5,
    LEAF7_EBX_AVX512F = 1 << 16,
    XCR0_YMM = 0x06, /* SSE and AVX state */
    XCR0_ZMM = 0xe6  /* and opmask, upper halves, upper registers */
};

static uint32_t enabled_state(void) {
    uint32_t low, high;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return low;
}

uint32_t nsdf_cpu_features(void) {
    uint32_t a, b, c, d, features = 0;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & LEAF1_ECX_FMA) || !(c & LEAF1_ECX_OSXSAVE))
        return 0;
    uint32_t state = enabled_state();
    if (!__get_cpuid_count(7, 0, &a, &b, &c, &d) || (state & XCR0_YMM) != XCR0_YMM)
        return 0;
    if (b & LEAF7_EBX_AVX2)
        features |= NSDF_CPU_AVX2;
    if ((b & LEAF7_EBX_AVX512F) && (state & XCR0_ZMM) == XCR0_ZMM)
        features |= NSDF_CPU_AVX512;
    return features;
}

#elif defined(__aarch64__)

uint32_t nsdf_cpu_features(void) {
    return NSDF_CPU_NEON; /* part of the architecture (Arm ARM, A1.5) */
}

#else

uint32_t nsdf_cpu_features(void) {
    return 0;
}

#endif
