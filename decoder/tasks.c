/* Numbered tasks on threads.  Every worker is a "lane" that draws task numbers from one counter; the calling thread is
 * lane 0 of our own pool, and the caller's runner is given whole lanes, so that lane = worker in both cases. */
#ifndef _POSIX_C_SOURCE
#define _POSIX_C_SOURCE 200809L
#endif
#include "tasks.h"

#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <string.h>
#include <unistd.h>

enum { MAX_WORKERS = 256 };

/* Jobs of a frame follow each other within microseconds, while a thread that sleeps takes tens of them to wake: it
 * looks so many times before going to sleep, some ten microseconds. */
enum { PATIENCE = 20000 };

typedef struct job {
    nsdf_task_fn fn;
    void *data;
    uint32_t count;
    atomic_uint_least64_t next; /* wider than count: every lane overshoots by one */
} job;

typedef struct pool_thread {
    nsdf_tasks *tasks;
    pthread_t handle;
    uint32_t worker;
} pool_thread;

struct nsdf_tasks {
    nsdf_memory *memory;
    nsdf_task_runner runner;
    uint32_t workers;
    uint32_t started; /* pool threads that run; fewer than workers - 1 when the system gave no more */
    int start_tried;
    job current;
    pthread_mutex_t lock; /* guards changes of the fields below */
    pthread_cond_t begin, done;
    atomic_uint_least64_t round;   /* counts the jobs handed to the pool */
    atomic_uint_least32_t running; /* pool threads that have not finished this round */
    atomic_int stopping;
    pool_thread threads[]; /* workers - 1 */
};

static void run_lane(job *j, uint32_t worker) {
    for (;;) {
        uint64_t index = atomic_fetch_add_explicit(&j->next, 1, memory_order_relaxed);
        if (index >= j->count)
            return;
        j->fn(j->data, (uint32_t)index, worker);
    }
}

static void await_round(nsdf_tasks *tasks, uint64_t seen) {
    for (int i = 0; i < PATIENCE && atomic_load(&tasks->round) == seen && !atomic_load(&tasks->stopping);)
        i++;
}

static void await_others(nsdf_tasks *tasks) {
    for (int i = 0; i < PATIENCE && atomic_load(&tasks->running) > 0;)
        i++;
}

static void *pool_main(void *argument) {
    const pool_thread *self = argument;
    nsdf_tasks *tasks = self->tasks;
    uint64_t seen = 0;
    pthread_mutex_lock(&tasks->lock);
    for (;;) {
        while (tasks->round == seen && !tasks->stopping)
            pthread_cond_wait(&tasks->begin, &tasks->lock);
        if (tasks->stopping)
            break;
        seen = tasks->round;
        pthread_mutex_unlock(&tasks->lock);
        run_lane(&tasks->current, self->worker);
        pthread_mutex_lock(&tasks->lock);
        if (--tasks->running == 0)
            pthread_cond_signal(&tasks->done);
        pthread_mutex_unlock(&tasks->lock);
        await_round(tasks, seen);
        pthread_mutex_lock(&tasks->lock);
    }
    pthread_mutex_unlock(&tasks->lock);
    return NULL;
}

static uint32_t core_count(void) {
    long n = sysconf(_SC_NPROCESSORS_ONLN);
    return n < 1 ? 1 : n > MAX_WORKERS ? MAX_WORKERS : (uint32_t)n;
}

static int init_sync(nsdf_tasks *tasks) {
    if (pthread_mutex_init(&tasks->lock, NULL) != 0)
        return -1;
    if (pthread_cond_init(&tasks->begin, NULL) == 0) {
        if (pthread_cond_init(&tasks->done, NULL) == 0)
            return 0;
        pthread_cond_destroy(&tasks->begin);
    }
    pthread_mutex_destroy(&tasks->lock);
    return -1;
}

nsdf_status nsdf_tasks_create(nsdf_memory *memory, uint32_t threads, const nsdf_task_runner *runner,
                              nsdf_tasks **tasks) {
    uint32_t workers = threads == 0 ? core_count() : threads > MAX_WORKERS ? MAX_WORKERS : threads;
    size_t size = sizeof(nsdf_tasks) + (workers - 1) * sizeof(pool_thread);
    void *block;
    nsdf_status status = nsdf_memory_take(memory, size, &block);
    if (status != NSDF_OK)
        return status;
    memset(block, 0, size);
    nsdf_tasks *made = block;
    made->memory = memory;
    made->workers = workers;
    if (runner && runner->run)
        made->runner = *runner;
    if (init_sync(made) != 0) {
        nsdf_memory_give(memory, made);
        return NSDF_NO_MEMORY;
    }
    *tasks = made;
    return NSDF_OK;
}

void nsdf_tasks_free(nsdf_tasks **tasks) {
    if (!tasks || !*tasks)
        return;
    nsdf_tasks *t = *tasks;
    pthread_mutex_lock(&t->lock);
    t->stopping = 1;
    pthread_cond_broadcast(&t->begin);
    pthread_mutex_unlock(&t->lock);
    for (uint32_t i = 0; i < t->started; i++)
        pthread_join(t->threads[i].handle, NULL);
    pthread_cond_destroy(&t->done);
    pthread_cond_destroy(&t->begin);
    pthread_mutex_destroy(&t->lock);
    nsdf_memory_give(t->memory, t);
    *tasks = NULL;
}

uint32_t nsdf_tasks_workers(const nsdf_tasks *tasks) {
    return tasks->workers;
}

/* Tried once: a system that has no more threads to give is not asked again and again.  Signals are for the program's
 * own threads. */
static void start_pool(nsdf_tasks *tasks) {
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    tasks->start_tried = 1;
    while (tasks->started < tasks->workers - 1) {
        pool_thread *thread = &tasks->threads[tasks->started];
        thread->tasks = tasks;
        thread->worker = tasks->started + 1;
        if (pthread_create(&thread->handle, NULL, pool_main, thread) != 0)
            break;
        tasks->started++;
    }
    pthread_sigmask(SIG_SETMASK, &before, NULL);
}

static void run_on_pool(nsdf_tasks *tasks) {
    if (!tasks->start_tried)
        start_pool(tasks);
    pthread_mutex_lock(&tasks->lock);
    tasks->round++;
    tasks->running = tasks->started;
    pthread_cond_broadcast(&tasks->begin);
    pthread_mutex_unlock(&tasks->lock);
    run_lane(&tasks->current, 0);
    await_others(tasks);
    pthread_mutex_lock(&tasks->lock);
    while (tasks->running > 0)
        pthread_cond_wait(&tasks->done, &tasks->lock);
    pthread_mutex_unlock(&tasks->lock);
}

static void runner_lane(void *data, uint32_t index) {
    run_lane(data, index);
}

void nsdf_tasks_run(nsdf_tasks *tasks, uint32_t count, nsdf_task_fn fn, void *data) {
    job *j = &tasks->current;
    j->fn = fn;
    j->data = data;
    j->count = count;
    atomic_store(&j->next, 0);
    if (count <= 1 || tasks->workers == 1)
        run_lane(j, 0);
    else if (tasks->runner.run)
        tasks->runner.run(tasks->runner.user, count < tasks->workers ? count : tasks->workers, runner_lane, j);
    else
        run_on_pool(tasks);
}
