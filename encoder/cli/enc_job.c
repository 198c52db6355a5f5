#include "enc_job.h"

#include "cli_util.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

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

int enc_job_start(enc_job *job, const enc_parts *parts, uint32_t segment) {
    int ends[2];
    if (pipe(ends) != 0) {
        nsdf_cli_error("cannot make a pipe: %s", strerror(errno));
        return -1;
    }
    const pid_t process = fork();
    if (process == 0) {
        close(ends[0]);
        fcntl(ends[1], F_SETFL, O_NONBLOCK);
        run_process(parts, segment, ends[1]);
    }
    close(ends[1]);
    if (process < 0) {
        nsdf_cli_error("cannot start a process: %s", strerror(errno));
        close(ends[0]);
        return -1;
    }
    fcntl(ends[0], F_SETFL, O_NONBLOCK);
    *job = (enc_job){process, ends[0], segment, 0.0};
    return 0;
}

enc_job_state enc_job_check(enc_job *job) {
    double done;
    int status;
    while (read(job->pipe, &done, sizeof done) == (ssize_t)sizeof done)
        job->done = done;
    if (waitpid(job->process, &status, WNOHANG) != job->process)
        return ENC_JOB_RUNNING;
    close(job->pipe);
    job->process = 0;
    if (WIFEXITED(status))
        return WEXITSTATUS(status) == NSDF_CLI_SUCCESS ? ENC_JOB_DONE : ENC_JOB_FAILED;
    nsdf_cli_warn("segment %u: its process was ended by signal %d", job->segment + 1, WTERMSIG(status));
    return ENC_JOB_KILLED;
}

void enc_job_stop(enc_job *job) {
    if (job->process == 0)
        return;
    kill(job->process, SIGKILL);
    (void)waitpid(job->process, NULL, 0);
    close(job->pipe);
    job->process = 0;
}
