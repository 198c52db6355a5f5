/* The random matrix B of the Fourier features (thesis 5.3), the same on every machine (spec, section "Evaluating a
 * network"). */
#ifndef NSDF_FOURIER_H
#define NSDF_FOURIER_H

#include <stdint.h>

/* Fills b[count][4] with draws from N(0, sigma^2), approximated by Irwin-Hall sums of integers (SplitMix64). */
static inline void nsdf_fourier_matrix(uint64_t seed, float sigma, uint32_t count, float *b) {
    for (uint32_t i = 0; i < 4 * count; i++) {
        uint32_t sum = 0; /* twelve uniform 16-bit integers: variance 65536^2 up to a part in 2^32 */
        for (int k = 0; k < 3; k++) {
            seed += UINT64_C(0x9e3779b97f4a7c15);
            uint64_t z = seed;
            z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
            z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
            z ^= z >> 31;
            sum += (uint32_t)(z & 0xffff) + (uint32_t)(z >> 16 & 0xffff) + (uint32_t)(z >> 32 & 0xffff) +
                   (uint32_t)(z >> 48);
        }
        double unit = ((double)sum - 6.0 * 65535.0) / 65536.0;
        b[i] = (float)(unit * (double)sigma);
    }
}

#endif
