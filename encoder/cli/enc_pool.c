#include "enc_pool.h"

#include "cli_util.h"

#include <poll.h>
#include <stdlib.h>
#include <string.h>

enum { WAIT_MS = 200 };

/* ---- Segments ----------------------------------------------------------------------------------------------- */

static uint32_t count_of(const enc_pool *p) {
    return p->parts->plan->count;
}

uint32_t enc_pool_take(enc_pool *p) {
    for (uint32_t i = 0; i < count_of(p) && !p->failed; i++)
        if (p->states[i] == ENC_SEGMENT_OPEN) {
            p->states[i] = ENC_SEGMENT_TAKEN;
            p->tries[i]++;
            return i;
        }
    return UINT32_MAX;
}

void enc_pool_finish(enc_pool *p, uint32_t segment) {
    const nsdf_span *s = &p->parts->plan->spans[segment];
    const uint32_t *numbers = p->parts->plan->list->numbers;
    enc_part part;
    if (enc_part_read(p->parts, segment, &part) != 0) {
        nsdf_cli_error("segment %u: its file cannot be read in '%s'", segment + 1, p->parts->folder);
        p->failed = 1;
        return;
    }
    p->states[segment] = ENC_SEGMENT_DONE;
    p->done++;
    nsdf_cli_verbose("segment %u of %u, frames %u to %u: %zu bytes, mean error %.2e, %.0f s", segment + 1, count_of(p),
                     numbers[s->first], numbers[s->last], part.size, nsdf_mean_error(&part.stats.quality),
                     part.stats.seconds_sample + part.stats.seconds_fit + part.stats.seconds_code +
                         part.stats.seconds_verify);
    enc_part_free(&part);
}

void enc_pool_lose(enc_pool *p, uint32_t segment) {
    p->states[segment] = ENC_SEGMENT_OPEN;
    if (p->tries[segment] < ENC_MOST_TRIES) {
        nsdf_cli_warn("segment %u is fitted again", segment + 1);
        return;
    }
    nsdf_cli_error("segment %u was lost %d times", segment + 1, ENC_MOST_TRIES);
    p->failed = 1;
}

static void find_finished(enc_pool *p) {
    for (uint32_t i = 0; i < count_of(p); i++) {
        enc_part part;
        if (enc_part_read(p->parts, i, &part) != 0)
            continue;
        enc_part_free(&part);
        enc_pool_finish(p, i);
    }
    if (p->done > 0)
        nsdf_cli_say("%u of %u segments are there from an earlier run", p->done, count_of(p));
}

int enc_pool_open(enc_pool *p, const enc_parts *parts, uint32_t jobs) {
    const uint32_t count = parts->plan->count;
    memset(p, 0, sizeof *p);
    p->parts = parts;
    p->job_count = jobs > ENC_MOST_JOBS ? ENC_MOST_JOBS : jobs;
    p->states = calloc(count, 1);
    p->tries = calloc(count, 1);
    p->jobs = calloc(p->job_count + 1, sizeof *p->jobs);
    if (!p->states || !p->tries || !p->jobs) {
        nsdf_cli_error("out of memory");
        p->job_count = 0;
        return -1;
    }
    find_finished(p);
    p->began = nsdf_cli_clock();
    p->began_with = p->done;
    return 0;
}

void enc_pool_close(enc_pool *p) {
    for (uint32_t i = 0; i < p->job_count; i++)
        enc_job_stop(&p->jobs[i]);
    free(p->states);
    free(p->tries);
    free(p->jobs);
    memset(p, 0, sizeof *p);
}

int enc_pool_goes_on(const enc_pool *p) {
    return p->done < count_of(p) && !p->failed && nsdf_cli_interrupts() == 0;
}

int enc_pool_result(const enc_pool *p) {
    if (p->done == count_of(p))
        return 0;
    if (nsdf_cli_interrupts() > 0)
        nsdf_cli_error("interrupted: nothing was written, but %u of %u segments are in '%s': the same command goes on "
                       "from them",
                       p->done, count_of(p), p->parts->folder);
    return -1;
}

/* ---- Jobs --------------------------------------------------------------------------------------------------- */

static void start_job(enc_pool *p, enc_job *j) {
    const uint32_t segment = enc_pool_take(p);
    if (segment != UINT32_MAX && enc_job_start(j, p->parts, segment) != 0) {
        p->states[segment] = ENC_SEGMENT_OPEN;
        p->failed = 1;
    }
}

static void check_job(enc_pool *p, enc_job *j) {
    const uint32_t segment = j->segment;
    switch (enc_job_check(j)) {
    case ENC_JOB_RUNNING:
        break;
    case ENC_JOB_DONE:
        enc_pool_finish(p, segment);
        break;
    case ENC_JOB_KILLED:
        enc_pool_lose(p, segment);
        break;
    case ENC_JOB_FAILED:
        p->failed = 1;
        break;
    }
}

uint32_t enc_pool_work(enc_pool *p) {
    uint32_t running = 0;
    for (uint32_t i = 0; i < p->job_count; i++) {
        enc_job *j = &p->jobs[i];
        if (j->process != 0)
            check_job(p, j);
        if (j->process == 0)
            start_job(p, j);
        running += j->process != 0;
    }
    return running;
}

void enc_pool_show(const enc_pool *p, double elsewhere) {
    const uint32_t count = count_of(p);
    double done = p->done + elsewhere;
    for (uint32_t i = 0; i < p->job_count; i++)
        done += p->jobs[i].process != 0 ? p->jobs[i].done : 0.0;
    const double elapsed = nsdf_cli_clock() - p->began, gone = done - p->began_with;
    nsdf_cli_progress("%u of %u segments, %4.1f %%  %.0f s left", p->done, count, 100.0 * done / count,
                      gone > 0.0 ? elapsed * (count - done) / gone : 0.0);
}

/* Until a job reports, or a moment has passed. */
static void wait_for_jobs(const enc_pool *p) {
    struct pollfd ends[ENC_MOST_JOBS];
    nfds_t count = 0;
    for (uint32_t i = 0; i < p->job_count; i++)
        if (p->jobs[i].process != 0)
            ends[count++] = (struct pollfd){p->jobs[i].pipe, POLLIN, 0};
    (void)poll(ends, count, WAIT_MS);
}

int enc_pool_run(const enc_parts *parts, uint32_t jobs) {
    enc_pool pool;
    int result = enc_pool_open(&pool, parts, jobs);
    while (result == 0 && enc_pool_goes_on(&pool) && enc_pool_work(&pool) > 0) {
        wait_for_jobs(&pool);
        enc_pool_show(&pool, 0.0);
    }
    if (result == 0)
        result = enc_pool_result(&pool);
    enc_pool_close(&pool);
    return result;
}
