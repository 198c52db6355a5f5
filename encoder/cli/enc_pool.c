#include "enc_pool.h"

#include "cli_util.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

enum { MOST_TRIES = 3, WAIT_MS = 200, MOST_JOBS = 256 };

typedef struct job {
    pid_t process; /* 0 = none */
    int pipe;      /* progress comes from it, as doubles */
    uint32_t segment;
    double done;
} job;

typedef struct pool {
    const enc_parts *parts;
    uint8_t *tries;    /* [segment] */
    uint8_t *finished; /* [segment] */
    job jobs[MOST_JOBS];
    uint32_t job_count, next, finished_count;
    double began, began_with; /* the clock, and segments that were finished then */
    int failed;
} pool;

/* ---- In the process ----------------------------------------------------------------------------------------- */

static int report(void *user, double done) {
    const int *pipe = user;
    /* A full pipe loses a report, which the next one makes up for; a closed one ends the process by SIGPIPE. */
    if (write(*pipe, &done, sizeof done) < 0 && errno != EAGAIN && errno != EINTR)
        return 1;
    return 0;
}

/* The parent is told of interrupts and decides; its death ends this process too. */
static void settle_signals(void) {
    signal(SIGINT, SIG_IGN);
    signal(SIGTERM, SIG_DFL);
    signal(SIGHUP, SIG_DFL);
    signal(SIGPIPE, SIG_DFL);
#ifdef __linux__
    prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
}

static void run_process(const enc_parts *parts, uint32_t segment, int pipe) {
    enc_part part;
    settle_signals();
    int code = enc_part_fit(parts->plan, segment, report, &pipe, &part) == 0 ? NSDF_CLI_SUCCESS : NSDF_CLI_FAILURE;
    if (code == NSDF_CLI_SUCCESS && enc_part_write(parts, segment, &part) != 0)
        code = NSDF_CLI_FAILURE;
    _exit(code);
}

/* ---- In the program ----------------------------------------------------------------------------------------- */

static int start(pool *p, job *j, uint32_t segment) {
    int ends[2];
    if (pipe(ends) != 0) {
        nsdf_cli_error("cannot make a pipe: %s", strerror(errno));
        return -1;
    }
    nsdf_cli_progress("%s", "");
    const pid_t process = fork();
    if (process == 0) {
        close(ends[0]);
        fcntl(ends[1], F_SETFL, O_NONBLOCK);
        run_process(p->parts, segment, ends[1]);
    }
    close(ends[1]);
    if (process < 0) {
        nsdf_cli_error("cannot start a process: %s", strerror(errno));
        close(ends[0]);
        return -1;
    }
    fcntl(ends[0], F_SETFL, O_NONBLOCK);
    p->tries[segment]++;
    *j = (job){process, ends[0], segment, 0.0};
    return 0;
}

static void finish(pool *p, uint32_t segment, const enc_part *part) {
    const nsdf_span *s = &p->parts->plan->spans[segment];
    const uint32_t *numbers = p->parts->plan->list->numbers;
    p->finished[segment] = 1;
    p->finished_count++;
    nsdf_cli_verbose(
        "segment %u of %u, frames %u to %u: %zu bytes, mean error %.2e, %.0f s", segment + 1, p->parts->plan->count,
        numbers[s->first], numbers[s->last], part->size, nsdf_mean_error(&part->stats.quality),
        part->stats.seconds_sample + part->stats.seconds_fit + part->stats.seconds_code + part->stats.seconds_verify);
}

/* A process ended.  One that failed has said why; one that was killed is made good for. */
static void settle(pool *p, job *j, int status) {
    enc_part part;
    close(j->pipe);
    j->process = 0;
    if (WIFEXITED(status) && WEXITSTATUS(status) == NSDF_CLI_SUCCESS &&
        enc_part_read(p->parts, j->segment, &part) == 0) {
        finish(p, j->segment, &part);
        enc_part_free(&part);
        return;
    }
    if (WIFSIGNALED(status) && p->tries[j->segment] < MOST_TRIES) {
        nsdf_cli_warn("segment %u: its process was ended by signal %d; it is fitted again", j->segment + 1,
                      WTERMSIG(status));
        p->next = j->segment < p->next ? j->segment : p->next;
        return;
    }
    if (WIFSIGNALED(status))
        nsdf_cli_error("segment %u: its process was ended by signal %d", j->segment + 1, WTERMSIG(status));
    p->failed = 1;
}

static int is_running(const pool *p, uint32_t segment) {
    for (uint32_t i = 0; i < p->job_count; i++)
        if (p->jobs[i].process != 0 && p->jobs[i].segment == segment)
            return 1;
    return 0;
}

static void start_jobs(pool *p) {
    const uint32_t count = p->parts->plan->count;
    for (uint32_t i = 0; i < p->job_count && !p->failed; i++) {
        while (p->next < count && (p->finished[p->next] || is_running(p, p->next)))
            p->next++;
        if (p->jobs[i].process == 0 && p->next < count)
            p->failed = start(p, &p->jobs[i], p->next) != 0;
    }
}

static void read_progress(job *j) {
    double done;
    while (read(j->pipe, &done, sizeof done) == (ssize_t)sizeof done)
        j->done = done;
}

static void show_progress(const pool *p) {
    const uint32_t count = p->parts->plan->count;
    double done = p->finished_count;
    for (uint32_t i = 0; i < p->job_count; i++)
        done += p->jobs[i].process != 0 ? p->jobs[i].done : 0.0;
    const double elapsed = nsdf_cli_clock() - p->began, gone = done - p->began_with;
    nsdf_cli_progress("segment %u of %u, %4.1f %%  %.0f s left", p->finished_count + 1, count, 100.0 * done / count,
                      gone > 0.0 ? elapsed * (count - done) / gone : 0.0);
}

/* Waits a little for news of the processes.  Returns how many are running. */
static uint32_t watch(pool *p) {
    struct pollfd ends[MOST_JOBS];
    uint32_t running = 0;
    for (uint32_t i = 0; i < p->job_count; i++)
        if (p->jobs[i].process != 0)
            ends[running++] = (struct pollfd){p->jobs[i].pipe, POLLIN, 0};
    (void)poll(ends, running, WAIT_MS);
    for (uint32_t i = 0; i < p->job_count; i++) {
        int status;
        if (p->jobs[i].process == 0)
            continue;
        read_progress(&p->jobs[i]);
        if (waitpid(p->jobs[i].process, &status, WNOHANG) == p->jobs[i].process)
            settle(p, &p->jobs[i], status);
    }
    show_progress(p);
    return running;
}

static void stop_all(pool *p) {
    for (uint32_t i = 0; i < p->job_count; i++) {
        job *j = &p->jobs[i];
        if (j->process == 0)
            continue;
        kill(j->process, SIGKILL);
        (void)waitpid(j->process, NULL, 0);
        close(j->pipe);
        j->process = 0;
    }
}

static void find_finished(pool *p) {
    for (uint32_t i = 0; i < p->parts->plan->count; i++) {
        enc_part part;
        if (enc_part_read(p->parts, i, &part) != 0)
            continue;
        finish(p, i, &part);
        enc_part_free(&part);
    }
    if (p->finished_count > 0)
        nsdf_cli_say("%u of %u segments are there from an earlier run", p->finished_count, p->parts->plan->count);
}

static int run_all(pool *p) {
    find_finished(p);
    p->began = nsdf_cli_clock();
    p->began_with = p->finished_count;
    do
        start_jobs(p);
    while (watch(p) > 0 && !p->failed && nsdf_cli_interrupts() == 0);
    stop_all(p);
    if (p->finished_count == p->parts->plan->count)
        return 0;
    if (nsdf_cli_interrupts() > 0)
        nsdf_cli_error("interrupted: nothing was written, but %u of %u segments are in '%s': the same command goes on "
                       "from them",
                       p->finished_count, p->parts->plan->count, p->parts->folder);
    return -1;
}

int enc_pool_run(const enc_parts *parts, uint32_t jobs) {
    pool *p = calloc(1, sizeof *p);
    int result = -1;
    if (p) {
        p->parts = parts;
        p->job_count = jobs < 1 ? 1 : jobs > MOST_JOBS ? MOST_JOBS : jobs;
        p->tries = calloc(parts->plan->count, 1);
        p->finished = calloc(parts->plan->count, 1);
    }
    if (p && p->tries && p->finished)
        result = run_all(p);
    else
        nsdf_cli_error("out of memory");
    if (p) {
        free(p->tries);
        free(p->finished);
    }
    free(p);
    return result;
}
