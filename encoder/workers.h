/* A team of threads that run the same numbered tasks together; started once, cheap to wake. */
#ifndef NSDF_WORKERS_H
#define NSDF_WORKERS_H

#include <stdint.h>

typedef struct nsdf_workers nsdf_workers;

/* threads 0 = one per core the process may use.  NULL when memory ran out or threads cannot be started. */
nsdf_workers *nsdf_workers_create(uint32_t threads);
void nsdf_workers_free(nsdf_workers *workers);
uint32_t nsdf_workers_count(const nsdf_workers *workers);

/* Calls fn(data, i, worker) once for every i < count, on count() threads, the caller's among them, and waits.  Tasks
 * are handed out in order; results may depend on i only. */
void nsdf_workers_run(nsdf_workers *workers, uint32_t count, void (*fn)(void *data, uint32_t index, uint32_t worker),
                      void *data);

#endif
