/* Block kernels for AVX2. */
#include "block_kernels.h"

#if defined(__x86_64__) && defined(__GNUC__)

#define TARGET __attribute__((target("avx2")))
#define NAME "avx2"

#include "block_kernels_impl.h"

const nsdf_block_kernels *nsdf_block_kernels_avx2(void) {
    return &table;
}

#else

const nsdf_block_kernels *nsdf_block_kernels_avx2(void) {
    return NULL;
}

#endif
