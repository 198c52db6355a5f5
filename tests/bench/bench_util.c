#include "bench_util.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { LINE = 64 };

static const double most_repeats = 1e6;

/* ---- Timing ------------------------------------------------------------------------------------------------ */

static double clock_seconds(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double bench_seconds(void) {
    return clock_seconds(CLOCK_MONOTONIC);
}

/* Notes the least processor time that a call took. */
static double seconds_a_call(bench_case *timed, uint32_t repeats) {
    const double start_cpu = clock_seconds(CLOCK_THREAD_CPUTIME_ID), start = bench_seconds();
    for (uint32_t i = 0; i < repeats; i++)
        timed->run(timed->data);
    const double seconds = (bench_seconds() - start) / repeats;
    const double cpu = (clock_seconds(CLOCK_THREAD_CPUTIME_ID) - start_cpu) / repeats;
    if (timed->threads == 1 && (timed->cpu <= 0.0 || cpu < timed->cpu))
        timed->cpu = cpu;
    return seconds;
}

/* The first call pages memory in and wakes threads; the second tells how often to repeat. */
static uint32_t warm_up(bench_case *timed, double run_seconds) {
    seconds_a_call(timed, 1);
    const double wanted = run_seconds / (seconds_a_call(timed, 1) + 1e-9) + 1.0;
    timed->cpu = 0.0;
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

double bench_compared_seconds(const bench_case *timed) {
    return timed->cpu > 0.0 ? timed->cpu : timed->best;
}

/* ---- Rows -------------------------------------------------------------------------------------------------- */

static bench_row row_of(const char *section, const bench_case *timed, const char *unit) {
    bench_row row = {section, timed->measure, unit, timed->threads, timed->runs, 0, 0, 0, 0, 0, 0};
    return row;
}

bench_row bench_rate(const char *section, const bench_case *timed, double work, const char *unit) {
    bench_row row = row_of(section, timed, unit);
    row.best = work / timed->best;
    row.median = work / timed->median;
    row.cpu = timed->cpu > 0.0 ? work / timed->cpu : 0.0;
    return row;
}

bench_row bench_time(const char *section, const bench_case *timed, double factor, const char *unit) {
    bench_row row = row_of(section, timed, unit);
    row.best = factor * timed->best;
    row.median = factor * timed->median;
    row.cpu = factor * timed->cpu;
    return row;
}

bench_row bench_count(const char *section, const char *measure, uint32_t threads, double value, const char *unit) {
    bench_row row = {section, measure, unit, threads, 0, value, value, 0, 0, 0, 0};
    return row;
}

void bench_print_header(void) {
    puts("section,measure,threads,best,median,unit,runs,of_sgemm,of_fma,of_draco,cpu");
}

static void print_if_known(double value, int digits) {
    if (value > 0)
        printf(",%.*g", digits, value);
    else
        putchar(',');
}

void bench_print(const bench_row *row) {
    printf("%s,%s,%lu,%.5g,%.5g,%s,%lu", row->section, row->measure, (unsigned long)row->threads, row->best,
           row->median, row->unit, (unsigned long)row->runs);
    print_if_known(row->of_sgemm, 4);
    print_if_known(row->of_fma, 4);
    print_if_known(row->of_draco, 4);
    print_if_known(row->cpu, 5);
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
