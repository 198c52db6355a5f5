/* Runs numbered tasks on the caller's runner or on threads of our own. */
#ifndef NSDF_TASKS_H
#define NSDF_TASKS_H

#include "memory.h"

typedef struct nsdf_tasks nsdf_tasks;

/* threads: 0 = one per core.  With a runner (runner->run not NULL) no thread is ever started. */
nsdf_status nsdf_tasks_create(nsdf_memory *memory, uint32_t threads, const nsdf_task_runner *runner,
                              nsdf_tasks **tasks);
void nsdf_tasks_free(nsdf_tasks **tasks);

/* How many tasks may run at once; task functions get a `worker` below it and may use per-worker scratch memory. */
uint32_t nsdf_tasks_workers(const nsdf_tasks *tasks);

typedef void (*nsdf_task_fn)(void *data, uint32_t index, uint32_t worker);

/* Calls fn(data, i, worker) for every i < count and waits.  Which worker does which task is not determined: results
 * may depend on the index only.  Tasks must not allocate.  Small counts (0, 1) run on the calling thread. */
void nsdf_tasks_run(nsdf_tasks *tasks, uint32_t count, nsdf_task_fn fn, void *data);

#endif
