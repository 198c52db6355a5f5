/* Timing, statistics and output of the bench programs. */
#ifndef BENCH_UTIL_H
#define BENCH_UTIL_H

#include <stddef.h>
#include <stdint.h>

enum { BENCH_MOST_ROUNDS = 64 };

/* How thoroughly to measure.  Where other programs want the processor too, many short runs find a moment of quiet. */
typedef struct bench_plan {
    uint32_t rounds;       /* measured runs of each case, 1 to BENCH_MOST_ROUNDS */
    uint32_t least_rounds; /* so many at least, and no more once all of them took budget_seconds */
    double budget_seconds;
    double run_seconds; /* a run repeats its call until it should last so long */
} bench_plan;

/* Something to time: run(data), again and again. */
typedef struct bench_case {
    char measure[48];
    uint32_t threads;
    void (*run)(void *data);
    void *data;
    uint32_t runs;       /* what follows is filled in */
    double best, median; /* seconds a call: the least and the median of the runs */
    double cpu;          /* the least processor time of the calling thread; 0 where threads is not 1 */
} bench_case;

/* Seconds of CLOCK_MONOTONIC. */
double bench_seconds(void);

/* Warms every case up, then runs them in turn, round after round, so that what is compared sees the same machine. */
void bench_run(const bench_plan *plan, bench_case *cases, size_t count);

/* Seconds a call for comparing cases of as many threads: processor time where it is known, because waiting for a core
 * that another program has is no part of it, else the least of the runs. */
double bench_compared_seconds(const bench_case *timed);

/* A line of output. */
typedef struct bench_row {
    const char *section, *measure, *unit;
    uint32_t threads, runs; /* runs 0: counted, not timed */
    double best, median;
    double cpu;              /* by processor time; 0 = not known */
    double of_sgemm, of_fma; /* as a fraction of a peer in the same run; 0 = not compared */
    double of_draco;         /* in Draco's rows: our time over this one */
} bench_row;

/* work(units a call) / seconds. */
bench_row bench_rate(const char *section, const bench_case *timed, double work, const char *unit);
/* seconds * factor. */
bench_row bench_time(const char *section, const bench_case *timed, double factor, const char *unit);
/* A number that is no time. */
bench_row bench_count(const char *section, const char *measure, uint32_t threads, double value, const char *unit);

/* The columns' names, and a row, as CSV on standard output. */
void bench_print_header(void);
void bench_print(const bench_row *row);

/* The block, if it is not NULL: otherwise ends the program with a message. */
void *bench_checked(void *block);
/* malloc and calloc that end the program with a message when there is no memory. */
void *bench_allocate(size_t count, size_t size);
void *bench_allocate_zeroed(size_t count, size_t size);
/* Zeroed floats at a multiple of 64 bytes; free with free. */
float *bench_floats(size_t count);

#endif
