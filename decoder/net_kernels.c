/* Choice of a kernel table: C first, then overridden upward. */
#include "net_kernels.h"
#include "nsdf/decoder.h"

const nsdf_net_kernels *nsdf_net_kernels_choose(uint32_t features) {
    const nsdf_net_kernels *chosen = nsdf_net_kernels_c();
    if ((features & NSDF_CPU_AVX2) && nsdf_net_kernels_avx2())
        chosen = nsdf_net_kernels_avx2();
    if ((features & NSDF_CPU_AVX512) && nsdf_net_kernels_avx512())
        chosen = nsdf_net_kernels_avx512();
    if ((features & NSDF_CPU_NEON) && nsdf_net_kernels_neon())
        chosen = nsdf_net_kernels_neon();
    return chosen;
}
