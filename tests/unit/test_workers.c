#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "workers.h"

#define TASKS 1000

typedef struct tally {
    atomic_uint runs[TASKS];
    atomic_uint busy[8]; /* tasks that a worker is running now */
    atomic_uint wrong;
    uint32_t workers;
} tally;

static void count_task(void *data, uint32_t index, uint32_t worker) {
    tally *t = data;
    if (worker >= t->workers || atomic_fetch_add(&t->busy[worker], 1) != 0) {
        atomic_fetch_add(&t->wrong, 1);
    }
    atomic_fetch_add(&t->runs[index], 1);
    atomic_fetch_sub(&t->busy[worker < 8 ? worker : 0], 1);
}

static void every_task_runs_once_with_a_worker_number_of_its_own(void **state) {
    (void)state;
    for (uint32_t threads = 1; threads <= 4; threads++) {
        nsdf_workers *team = nsdf_workers_create(threads);
        assert_non_null(team);
        assert_int_equal(nsdf_workers_count(team), threads);
        tally *t = calloc(1, sizeof *t);
        t->workers = threads;
        nsdf_workers_run(team, TASKS, count_task, t);
        for (int i = 0; i < TASKS; i++) {
            assert_int_equal(atomic_load(&t->runs[i]), 1);
        }
        assert_int_equal(atomic_load(&t->wrong), 0);
        free(t);
        nsdf_workers_free(team);
    }
}

static void add_plain(void *data, uint32_t index, uint32_t worker) {
    (void)worker;
    ((uint64_t *)data)[index] += index;
}

/* Plain memory that tasks of one run write and those of the next read: a race would show under the thread sanitizer,
 * and as a wrong sum. */
static void runs_follow_each_other_without_overlap(void **state) {
    (void)state;
    nsdf_workers *team = nsdf_workers_create(4);
    assert_non_null(team);
    uint64_t sums[7] = {0};
    for (int run = 0; run < 5000; run++) {
        nsdf_workers_run(team, 2 + (uint32_t)run % 6, add_plain, sums);
    }
    for (uint64_t i = 0; i < 7; i++) {
        uint64_t expected = 0;
        for (uint64_t run = 0; run < 5000; run++) {
            expected += 2 + run % 6 > i ? i : 0;
        }
        assert_int_equal(sums[i], expected);
    }
    nsdf_workers_free(team);
}

static void no_tasks_and_one_task_work(void **state) {
    (void)state;
    nsdf_workers *team = nsdf_workers_create(3);
    assert_non_null(team);
    uint64_t sums[2] = {0, 0};
    nsdf_workers_run(team, 0, add_plain, sums);
    nsdf_workers_run(team, 1, add_plain, sums);
    assert_int_equal(sums[1], 0);
    nsdf_workers_free(team);
    nsdf_workers_free(NULL);
}

static void zero_threads_means_one_per_core(void **state) {
    (void)state;
    nsdf_workers *team = nsdf_workers_create(0);
    assert_non_null(team);
    assert_in_range(nsdf_workers_count(team), 1, 256);
    nsdf_workers_free(team);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_task_runs_once_with_a_worker_number_of_its_own),
        cmocka_unit_test(runs_follow_each_other_without_overlap),
        cmocka_unit_test(no_tasks_and_one_task_work),
        cmocka_unit_test(zero_threads_means_one_per_core),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
