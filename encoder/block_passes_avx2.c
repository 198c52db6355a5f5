/* The passes for AVX2. */
#include "block_batch.h"

#if defined(__x86_64__) && defined(__GNUC__)

#define TARGET __attribute__((target("avx2")))

#include "block_passes_impl.h"

const nsdf_block_passes *nsdf_block_passes_avx2(void) {
    return &passes;
}

#else

const nsdf_block_passes *nsdf_block_passes_avx2(void) {
    return NULL;
}

#endif
