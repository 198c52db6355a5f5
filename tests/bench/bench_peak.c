#include "bench_peak.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef BENCH_WITH_OPENBLAS
#include <cblas.h>
#endif

enum { TURNS = 1000000 };

typedef struct fma_job {
    nsdf_workers *team;
    bench_isa isa;
    volatile float result;
} fma_job;

struct bench_peak {
    nsdf_workers *team;
    fma_job fma[BENCH_ISA_COUNT];
    uint32_t size;
    float *a, *b, *c; /* [size][size] */
};

bench_peak *bench_peak_create(nsdf_workers *team, uint32_t sgemm_size) {
    bench_peak *peak = bench_allocate_zeroed(1, sizeof *peak);
    const size_t cells = (size_t)sgemm_size * sgemm_size;
    peak->team = team;
    peak->size = sgemm_size;
    peak->a = bench_floats(cells);
    peak->b = bench_floats(cells);
    peak->c = bench_floats(cells);
    for (size_t i = 0; i < cells; i++) {
        peak->a[i] = (float)(i % 7) - 3.0f;
        peak->b[i] = (float)(i % 5) - 2.0f;
    }
    return peak;
}

void bench_peak_free(bench_peak *peak) {
    free(peak->a);
    free(peak->b);
    free(peak->c);
    free(peak);
}

/* ---- Registers --------------------------------------------------------------------------------------------- */

static void fma_task(void *data, uint32_t index, uint32_t worker) {
    fma_job *job = data;
    const float result = bench_fma_loop(job->isa, TURNS);
    if (index == 0)
        job->result = result;
    (void)worker;
}

static void run_fma(void *data) {
    fma_job *job = data;
    nsdf_workers_run(job->team, nsdf_workers_count(job->team), fma_task, job);
}

double bench_peak_fma_case(bench_peak *peak, bench_isa isa, bench_case *timed) {
    const uint32_t threads = nsdf_workers_count(peak->team);
    peak->fma[isa] = (fma_job){peak->team, isa, 0};
    *timed = (bench_case){"", threads, run_fma, &peak->fma[isa], 0, 0, 0, 0};
    snprintf(timed->measure, sizeof timed->measure, "register loop %s", bench_isa_name(isa));
    return threads * bench_fma_flop(isa, TURNS);
}

/* ---- OpenBLAS ---------------------------------------------------------------------------------------------- */

#ifdef BENCH_WITH_OPENBLAS

static void run_sgemm(void *data) {
    bench_peak *peak = data;
    const int n = (int)peak->size;
    openblas_set_num_threads((int)nsdf_workers_count(peak->team));
    cblas_sgemm(CblasRowMajor, CblasNoTrans, CblasNoTrans, n, n, n, 1.0f, peak->a, n, peak->b, n, 0.0f, peak->c, n);
}

double bench_peak_sgemm_case(bench_peak *peak, bench_case *timed) {
    const double n = peak->size;
    *timed = (bench_case){"", nsdf_workers_count(peak->team), run_sgemm, peak, 0, 0, 0, 0};
    snprintf(timed->measure, sizeof timed->measure, "OpenBLAS sgemm %lu", (unsigned long)peak->size);
    return 2.0 * n * n * n;
}

const char *bench_peak_blas(void) {
    return openblas_get_config();
}

#else

double bench_peak_sgemm_case(bench_peak *peak, bench_case *timed) {
    (void)peak;
    (void)timed;
    return 0.0;
}

const char *bench_peak_blas(void) {
    return "not built in";
}

#endif
