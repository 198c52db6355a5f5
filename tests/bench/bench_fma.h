/* The most multiplications and additions a second that an instruction set can do: a loop that touches registers only.
 */
#ifndef BENCH_FMA_H
#define BENCH_FMA_H

#include <stdint.h>

/* In the order of speed.  The C set is what a compiler makes of plain C: on x86-64, SSE2 without fused operations. */
typedef enum bench_isa { BENCH_ISA_C, BENCH_ISA_AVX2, BENCH_ISA_AVX512, BENCH_ISA_COUNT } bench_isa;

/* "c", "avx2", "avx512", as nsdf_kernel_name has them. */
const char *bench_isa_name(bench_isa isa);
/* Of a name that begins so, as "avx512-bf16" does; the C set for names it does not know. */
bench_isa bench_isa_of_name(const char *name);
/* Whether this machine and build can run it. */
int bench_isa_is_here(bench_isa isa);
/* The fastest that is here. */
bench_isa bench_isa_best(void);

/* Floating-point operations of bench_fma_loop(isa, turns), a fused one counting as two. */
double bench_fma_flop(bench_isa isa, uint32_t turns);
/* Runs the loop; the result only keeps the compiler from leaving it out. */
float bench_fma_loop(bench_isa isa, uint32_t turns);

#endif
