/* The passes for AVX-512. */
#include "block_batch.h"

#if defined(__x86_64__) && defined(__GNUC__)

#ifdef __clang__
#define TARGET __attribute__((target("avx512f")))
#else
#define TARGET __attribute__((target("avx512f,prefer-vector-width=512")))
#endif

#include "block_passes_impl.h"

const nsdf_block_passes *nsdf_block_passes_avx512(void) {
    return &passes;
}

#else

const nsdf_block_passes *nsdf_block_passes_avx512(void) {
    return NULL;
}

#endif
