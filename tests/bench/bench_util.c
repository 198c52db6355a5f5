#include "bench_util.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { LINE = 64 };

static const double most_repeats = 1e6;

double bench_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- Timing ------------------------------------------------------------------------------------------------ */

static double seconds_a_call(const bench_case *timed, uint32_t repeats) {
    const double start = bench_seconds();
    for (uint32_t i = 0; i < repeats; i++)
        timed->run(timed->data);
    return (bench_seconds() - start) / repeats;
}

/* The first call pages memory in and wakes threads; the second tells how often to repeat. */
static uint32_t warm_up(const bench_case *timed, double run_seconds) {
    seconds_a_call(timed, 1);
    const double wanted = run_seconds / (seconds_a_call(timed, 1) + 1e-9) + 1.0;
    return (uint32_t)(wanted < most_repeats ? wanted : most_repeats);
}

static int compare(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void summarise(bench_case *timed, double *seconds, uint32_t runs) {
    qsort(seconds, runs, sizeof *seconds, compare);
    timed->runs = runs;
    timed->best = seconds[0];
    timed->median = 0.5 * (seconds[(runs - 1) / 2] + seconds[runs / 2]);
}

void bench_run(const bench_plan *plan, bench_case *cases, size_t count) {
    double(*seconds)[BENCH_MOST_ROUNDS] = bench_allocate(count, sizeof *seconds);
    uint32_t *repeats = bench_allocate(count, sizeof *repeats);
    for (size_t i = 0; i < count; i++)
        repeats[i] = warm_up(&cases[i], plan->run_seconds);
    const double start = bench_seconds();
    uint32_t round = 0;
    for (; round < plan->least_rounds || (round < plan->rounds && bench_seconds() - start < plan->budget_seconds);
         round++)
        for (size_t i = 0; i < count; i++)
            seconds[i][round] = seconds_a_call(&cases[i], repeats[i]);
    for (size_t i = 0; i < count; i++)
        summarise(&cases[i], seconds[i], round);
    free(seconds);
    free(repeats);
}

/* ---- Rows -------------------------------------------------------------------------------------------------- */

static bench_row row_of(const char *section, const bench_case *timed, const char *unit) {
    bench_row row = {section, timed->measure, unit, timed->threads, timed->runs, 0, 0, 0, 0, 0};
    return row;
}

bench_row bench_rate(const char *section, const bench_case *timed, double work, const char *unit) {
    bench_row row = row_of(section, timed, unit);
    row.best = work / timed->best;
    row.median = work / timed->median;
    return row;
}

bench_row bench_time(const char *section, const bench_case *timed, double factor, const char *unit) {
    bench_row row = row_of(section, timed, unit);
    row.best = factor * timed->best;
    row.median = factor * timed->median;
    return row;
}

bench_row bench_count(const char *section, const char *measure, uint32_t threads, double value, const char *unit) {
    bench_row row = {section, measure, unit, threads, 0, value, value, 0, 0, 0};
    return row;
}

void bench_print_header(void) {
    puts("section,measure,threads,best,median,unit,runs,of_sgemm,of_fma,of_draco");
}

static void print_ratio(double ratio) {
    if (ratio > 0)
        printf(",%.4g", ratio);
    else
        putchar(',');
}

void bench_print(const bench_row *row) {
    printf("%s,%s,%lu,%.5g,%.5g,%s,%lu", row->section, row->measure, (unsigned long)row->threads, row->best,
           row->median, row->unit, (unsigned long)row->runs);
    print_ratio(row->of_sgemm);
    print_ratio(row->of_fma);
    print_ratio(row->of_draco);
    putchar('\n');
    fflush(stdout);
}

/* ---- Memory ------------------------------------------------------------------------------------------------ */

void *bench_checked(void *block) {
    if (block)
        return block;
    fputs("bench: out of memory\n", stderr);
    exit(EXIT_FAILURE);
}

void *bench_allocate(size_t count, size_t size) {
    return bench_checked(malloc(count * size + 1));
}

void *bench_allocate_zeroed(size_t count, size_t size) {
    return bench_checked(calloc(count + 1, size));
}

float *bench_floats(size_t count) {
    const size_t bytes = (count * sizeof(float) + LINE) / LINE * LINE;
    return memset(bench_checked(aligned_alloc(LINE, bytes)), 0, bytes);
}
