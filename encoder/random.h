/* Random numbers: PCG32 (O'Neill 2014), the same on every machine. */
#ifndef NSDF_RANDOM_H
#define NSDF_RANDOM_H

#include <math.h>
#include <stdint.h>

typedef struct nsdf_random {
    uint64_t state, stream; /* stream is odd */
} nsdf_random;

static inline uint32_t nsdf_random_u32(nsdf_random *r) {
    uint64_t old = r->state;
    r->state = old * UINT64_C(6364136223846793005) + r->stream;
    uint32_t x = (uint32_t)(((old >> 18) ^ old) >> 27), rot = (uint32_t)(old >> 59);
    return x >> rot | x << ((32 - rot) & 31);
}

/* Different streams of one seed are independent. */
static inline nsdf_random nsdf_random_start(uint64_t seed, uint64_t stream) {
    nsdf_random r = {0, stream << 1 | 1};
    (void)nsdf_random_u32(&r);
    r.state += seed;
    (void)nsdf_random_u32(&r);
    return r;
}

/* Uniform in [0, 1), 24 bits. */
static inline float nsdf_random_unit(nsdf_random *r) {
    return (float)(nsdf_random_u32(r) >> 8) * 0x1p-24f;
}

/* Uniform in [0, n), n > 0. */
static inline uint32_t nsdf_random_below(nsdf_random *r, uint32_t n) {
    return (uint32_t)((uint64_t)nsdf_random_u32(r) * n >> 32);
}

/* One draw from N(0, 1) (Box & Muller). */
static inline float nsdf_random_normal(nsdf_random *r) {
    double u = ((double)nsdf_random_u32(r) + 1.0) * 0x1p-32, v = (double)nsdf_random_u32(r) * 0x1p-32;
    return (float)(sqrt(-2.0 * log(u)) * cos(6.283185307179586 * v));
}

#endif
