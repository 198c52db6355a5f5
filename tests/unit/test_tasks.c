/* Tasks on our own threads and on the caller's runner. */
#define _GNU_SOURCE /* pthread_setattr_default_np */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <pthread.h>
#include <stdatomic.h>
#include <string.h>

#include "tasks.h"

enum { COUNT = 1000, WORKERS = 256 };

typedef struct record {
    atomic_int runs[COUNT];
    atomic_int inside[WORKERS]; /* tasks that a worker is in */
    atomic_int overlaps;        /* times a worker was in two tasks at once */
    uint32_t workers;
    atomic_int bad_workers;
    pthread_t caller;
    atomic_int elsewhere; /* tasks that did not run on the calling thread */
} record;

static void note(void *data, uint32_t index, uint32_t worker) {
    record *r = data;
    if (worker >= r->workers) {
        atomic_fetch_add(&r->bad_workers, 1);
        return;
    }
    if (atomic_fetch_add(&r->inside[worker], 1) != 0)
        atomic_fetch_add(&r->overlaps, 1);
    atomic_fetch_add(&r->runs[index], 1);
    if (!pthread_equal(pthread_self(), r->caller))
        atomic_fetch_add(&r->elsewhere, 1);
    atomic_fetch_sub(&r->inside[worker], 1);
}

static void check_run(nsdf_tasks *tasks, uint32_t count, record *r) {
    memset(r, 0, sizeof *r);
    r->workers = nsdf_tasks_workers(tasks);
    r->caller = pthread_self();
    nsdf_tasks_run(tasks, count, note, r);
    for (uint32_t i = 0; i < COUNT; i++)
        assert_int_equal(atomic_load(&r->runs[i]), i < count);
    assert_int_equal(atomic_load(&r->overlaps), 0);
    assert_int_equal(atomic_load(&r->bad_workers), 0);
}

static void test_every_task_runs_once_for_every_thread_count(void **state) {
    nsdf_memory memory;
    static record r;
    (void)state;
    nsdf_memory_init(&memory, NULL, 1 << 20);
    for (uint32_t threads = 0; threads <= 5; threads++) {
        nsdf_tasks *tasks = NULL;
        assert_int_equal(nsdf_tasks_create(&memory, threads, NULL, &tasks), NSDF_OK);
        if (threads > 0)
            assert_int_equal(nsdf_tasks_workers(tasks), threads);
        for (uint32_t count = 0; count <= COUNT; count = 3 * count + 1)
            check_run(tasks, count, &r);
        check_run(tasks, COUNT, &r);
        nsdf_tasks_free(&tasks);
        assert_null(tasks);
    }
    assert_int_equal(memory.used, 0);
}

static void test_one_task_runs_on_the_calling_thread(void **state) {
    nsdf_memory memory;
    nsdf_tasks *tasks = NULL;
    static record r;
    (void)state;
    nsdf_memory_init(&memory, NULL, 1 << 20);
    assert_int_equal(nsdf_tasks_create(&memory, 4, NULL, &tasks), NSDF_OK);
    check_run(tasks, 1, &r);
    assert_int_equal(atomic_load(&r.elsewhere), 0);
    nsdf_tasks_free(&tasks);
}

typedef struct lane {
    void (*task)(void *data, uint32_t index);
    void *data;
    uint32_t index;
} lane;

static void *run_lane_thread(void *argument) {
    const lane *l = argument;
    l->task(l->data, l->index);
    return NULL;
}

/* A runner with a thread for each call, started last to first. */
static void run_threads(void *user, uint32_t count, void (*task)(void *data, uint32_t index), void *data) {
    pthread_t threads[WORKERS];
    lane lanes[WORKERS];
    ++*(int *)user;
    assert_true(count <= WORKERS);
    for (uint32_t i = count; i-- > 0;) {
        lanes[i] = (lane){task, data, i};
        assert_int_equal(pthread_create(&threads[i], NULL, run_lane_thread, &lanes[i]), 0);
    }
    for (uint32_t i = 0; i < count; i++)
        pthread_join(threads[i], NULL);
}

/* A runner without threads. */
static void run_in_turn(void *user, uint32_t count, void (*task)(void *data, uint32_t index), void *data) {
    ++*(int *)user;
    for (uint32_t i = count; i-- > 0;)
        task(data, i);
}

static void test_the_callers_runner_is_used_instead_of_threads(void **state) {
    nsdf_memory memory;
    static record r;
    (void)state;
    nsdf_memory_init(&memory, NULL, 1 << 20);
    for (int threaded = 0; threaded < 2; threaded++) {
        int calls = 0;
        const nsdf_task_runner runner = {&calls, threaded ? run_threads : run_in_turn};
        nsdf_tasks *tasks = NULL;
        assert_int_equal(nsdf_tasks_create(&memory, 4, &runner, &tasks), NSDF_OK);
        check_run(tasks, COUNT, &r);
        assert_int_equal(calls, 1);
        if (!threaded)
            assert_int_equal(atomic_load(&r.elsewhere), 0);
        nsdf_tasks_free(&tasks);
    }
}

static void *refuse(void *user, size_t size) {
    (void)user;
    (void)size;
    return NULL;
}

static void release_nothing(void *user, void *pointer) {
    (void)user;
    assert_null(pointer);
}

static void test_no_memory_is_a_status(void **state) {
    const nsdf_allocator hook = {NULL, refuse, release_nothing};
    nsdf_memory memory;
    nsdf_tasks *tasks = NULL;
    (void)state;
    nsdf_memory_init(&memory, &hook, 1 << 20);
    assert_int_equal(nsdf_tasks_create(&memory, 2, NULL, &tasks), NSDF_NO_MEMORY);
    assert_null(tasks);
    nsdf_memory_init(&memory, NULL, 100);
    assert_int_equal(nsdf_tasks_create(&memory, 2, NULL, &tasks), NSDF_LIMIT);
    nsdf_tasks_free(&tasks);
    nsdf_tasks_free(NULL);
}

#ifdef __GLIBC__
/* No thread can start, because none gets a stack: the caller does it all. */
static void test_threads_that_do_not_start_are_done_without(void **state) {
    nsdf_memory memory;
    nsdf_tasks *tasks = NULL;
    pthread_attr_t before, impossible;
    static record r;
    (void)state;
    assert_int_equal(pthread_getattr_default_np(&before), 0);
    assert_int_equal(pthread_attr_init(&impossible), 0);
    assert_int_equal(pthread_attr_setstacksize(&impossible, SIZE_MAX / 4), 0);
    assert_int_equal(pthread_setattr_default_np(&impossible), 0);
    nsdf_memory_init(&memory, NULL, 1 << 20);
    assert_int_equal(nsdf_tasks_create(&memory, 4, NULL, &tasks), NSDF_OK);
    check_run(tasks, COUNT, &r);
    check_run(tasks, COUNT, &r);
    assert_int_equal(atomic_load(&r.elsewhere), 0);
    nsdf_tasks_free(&tasks);
    assert_int_equal(pthread_setattr_default_np(&before), 0);
    pthread_attr_destroy(&before);
    pthread_attr_destroy(&impossible);
}
#endif

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_task_runs_once_for_every_thread_count),
        cmocka_unit_test(test_one_task_runs_on_the_calling_thread),
        cmocka_unit_test(test_the_callers_runner_is_used_instead_of_threads),
        cmocka_unit_test(test_no_memory_is_a_status),
#ifdef __GLIBC__
        cmocka_unit_test(test_threads_that_do_not_start_are_done_without),
#endif
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
