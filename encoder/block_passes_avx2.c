/* The passes for AVX2; compiled with -mavx2 on x86-64. */
#include "block_batch.h"
#if defined(__AVX2__)
#define PASSES_NAME "avx2"
#define W 8
#include "block_passes_impl.h"

const nsdf_block_passes *nsdf_block_passes_avx2(void) {
    return &passes;
}
#else
const nsdf_block_passes *nsdf_block_passes_avx2(void) {
    return NULL;
}
#endif
