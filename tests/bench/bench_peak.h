/* What the machine can do at most in single precision: the register loop of bench_fma.h, and OpenBLAS's matrix product
 * where it is built in; each with as many threads as a team has. */
#ifndef BENCH_PEAK_H
#define BENCH_PEAK_H

#include "bench_fma.h"
#include "bench_util.h"
#include "workers.h"

typedef struct bench_peak bench_peak;

/* sgemm_size: rows and columns of the matrices.  The team is borrowed. */
bench_peak *bench_peak_create(nsdf_workers *team, uint32_t sgemm_size);
void bench_peak_free(bench_peak *peak);

/* Cases to interleave with what is compared; they keep a pointer into `peak`.  Each returns the floating-point
 * operations of a call; sgemm: 0 and no case without OpenBLAS. */
double bench_peak_fma_case(bench_peak *peak, bench_isa isa, bench_case *timed);
double bench_peak_sgemm_case(bench_peak *peak, bench_case *timed);

/* Version, core and kernels that OpenBLAS chose, or "not built in". */
const char *bench_peak_blas(void);

#endif
