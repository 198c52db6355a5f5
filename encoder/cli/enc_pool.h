/* The segments that are still to be fitted, and the jobs that do it on this machine. */
#ifndef NSDF_ENC_POOL_H
#define NSDF_ENC_POOL_H

#include "enc_job.h"

enum { ENC_MOST_JOBS = 256, ENC_MOST_TRIES = 3 };

typedef enum enc_segment_state { ENC_SEGMENT_OPEN = 0, ENC_SEGMENT_TAKEN, ENC_SEGMENT_DONE } enc_segment_state;

typedef struct enc_pool {
    const enc_parts *parts;
    uint8_t *states, *tries; /* [segment] */
    enc_job *jobs;           /* [job_count] */
    uint32_t job_count, done;
    double began;        /* the clock */
    uint32_t began_with; /* segments that were done then */
    int failed;
} enc_pool;

/* Finds out which segments are there from an earlier run.  0, or -1 after printing why; enc_pool_close in either case.
 */
int enc_pool_open(enc_pool *pool, const enc_parts *parts, uint32_t jobs);
/* Ends all jobs. */
void enc_pool_close(enc_pool *pool);

/* The first open segment, which is taken now; UINT32_MAX when there is none, or enough has failed. */
uint32_t enc_pool_take(enc_pool *pool);
/* A taken segment's file is there. */
void enc_pool_finish(enc_pool *pool, uint32_t segment);
/* A taken segment's process died: it is open again, or the pool has failed when it died too often. */
void enc_pool_lose(enc_pool *pool, uint32_t segment);

/* Starts jobs while there are open segments, and takes in what they report.  Returns how many run. */
uint32_t enc_pool_work(enc_pool *pool);

/* Shows how far all is; `elsewhere` is what is done of segments that other machines fit. */
void enc_pool_show(const enc_pool *pool, double elsewhere);

/* Whether to go on: nothing failed, no interrupt, and not all done. */
int enc_pool_goes_on(const enc_pool *pool);

/* 0 when all segments are done, else -1 after printing why not. */
int enc_pool_result(const enc_pool *pool);

/* All of it on this machine.  0 when all segments have files; -1 after printing why not. */
int enc_pool_run(const enc_parts *parts, uint32_t jobs);

#endif
