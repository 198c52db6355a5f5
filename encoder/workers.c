/* Workers sleep until a job is posted, and take task numbers from one counter.  The caller works too, and then waits
 * only for the workers that joined: those that wake after the last task was taken go back to sleep. */
#include "workers.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <unistd.h>

typedef void task_fn(void *data, uint32_t index, uint32_t worker);

typedef struct member {
    nsdf_workers *team;
    pthread_t thread;
    uint32_t number; /* 1 and up; 0 is the caller */
} member;

struct nsdf_workers {
    pthread_mutex_t lock; /* guards what follows, but for `next` */
    pthread_cond_t posted, finished;
    uint64_t job;    /* numbers the jobs */
    bool open, stop; /* the job may be joined; the team is being dissolved */
    uint32_t joined; /* workers inside the job */
    task_fn *fn;
    void *data;
    uint32_t count;
    atomic_uint_fast64_t next; /* task to hand out; 64 bits, so that it cannot wrap round */
    member *members;
    uint32_t member_count; /* started */
};

static void work(nsdf_workers *team, task_fn *fn, void *data, uint32_t count, uint32_t worker) {
    for (;;) {
        uint_fast64_t task = atomic_fetch_add_explicit(&team->next, 1, memory_order_relaxed);
        if (task >= count) {
            return;
        }
        fn(data, (uint32_t)task, worker);
    }
}

/* Called and left with the lock held. */
static void join_job(nsdf_workers *team, uint32_t worker) {
    task_fn *fn = team->fn;
    void *data = team->data;
    uint32_t count = team->count;
    team->joined++;
    (void)pthread_mutex_unlock(&team->lock);
    work(team, fn, data, count, worker);
    (void)pthread_mutex_lock(&team->lock);
    if (--team->joined == 0) {
        (void)pthread_cond_signal(&team->finished);
    }
}

static void *member_main(void *argument) {
    const member *self = argument;
    nsdf_workers *team = self->team;
    uint64_t seen = 0;
    (void)pthread_mutex_lock(&team->lock);
    while (!team->stop) {
        if (team->open && team->job != seen) {
            seen = team->job;
            join_job(team, self->number);
        } else {
            (void)pthread_cond_wait(&team->posted, &team->lock);
        }
    }
    (void)pthread_mutex_unlock(&team->lock);
    return NULL;
}

static uint32_t core_count(void) {
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    return cores < 1 ? 1 : cores > 256 ? 256 : (uint32_t)cores;
}

static int start_members(nsdf_workers *team, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        member *m = &team->members[i];
        m->team = team;
        m->number = i + 1;
        if (pthread_create(&m->thread, NULL, member_main, m) != 0) {
            return -1;
        }
        team->member_count++;
    }
    return 0;
}

nsdf_workers *nsdf_workers_create(uint32_t threads) {
    uint32_t count = threads != 0 ? threads : core_count();
    nsdf_workers *team = calloc(1, sizeof *team);
    member *members = calloc(count, sizeof *members);
    if (team == NULL || members == NULL) {
        free(team);
        free(members);
        return NULL;
    }
    team->members = members;
    atomic_init(&team->next, 0);
    (void)pthread_mutex_init(&team->lock, NULL);
    (void)pthread_cond_init(&team->posted, NULL);
    (void)pthread_cond_init(&team->finished, NULL);
    if (start_members(team, count - 1) != 0) {
        nsdf_workers_free(team);
        return NULL;
    }
    return team;
}

void nsdf_workers_free(nsdf_workers *workers) {
    if (workers == NULL) {
        return;
    }
    (void)pthread_mutex_lock(&workers->lock);
    workers->stop = true;
    (void)pthread_cond_broadcast(&workers->posted);
    (void)pthread_mutex_unlock(&workers->lock);
    for (uint32_t i = 0; i < workers->member_count; i++) {
        (void)pthread_join(workers->members[i].thread, NULL);
    }
    (void)pthread_cond_destroy(&workers->finished);
    (void)pthread_cond_destroy(&workers->posted);
    (void)pthread_mutex_destroy(&workers->lock);
    free(workers->members);
    free(workers);
}

uint32_t nsdf_workers_count(const nsdf_workers *workers) {
    return workers->member_count + 1;
}

static void post(nsdf_workers *team, uint32_t count, task_fn *fn, void *data) {
    (void)pthread_mutex_lock(&team->lock);
    team->fn = fn;
    team->data = data;
    team->count = count;
    atomic_store_explicit(&team->next, 0, memory_order_relaxed);
    team->job++;
    team->open = true;
    (void)pthread_cond_broadcast(&team->posted);
    (void)pthread_mutex_unlock(&team->lock);
}

static void wait_for_members(nsdf_workers *team) {
    (void)pthread_mutex_lock(&team->lock);
    team->open = false;
    while (team->joined > 0) {
        (void)pthread_cond_wait(&team->finished, &team->lock);
    }
    (void)pthread_mutex_unlock(&team->lock);
}

void nsdf_workers_run(nsdf_workers *workers, uint32_t count, task_fn *fn, void *data) {
    if (workers->member_count == 0 || count <= 1) {
        for (uint32_t i = 0; i < count; i++) {
            fn(data, i, 0);
        }
        return;
    }
    post(workers, count, fn, data);
    work(workers, fn, data, count, 0);
    wait_for_members(workers);
}
