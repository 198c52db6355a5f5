/* A process that fits one segment: its memory goes with it, and when it dies no other work is lost. */
#ifndef NSDF_ENC_JOB_H
#define NSDF_ENC_JOB_H

#include "enc_part.h"

#include <sys/types.h>

typedef struct enc_job {
    pid_t process; /* 0 = none */
    int pipe;      /* progress comes from it */
    uint32_t segment;
    double done; /* 0 to 1 */
} enc_job;

typedef enum enc_job_state {
    ENC_JOB_RUNNING,
    ENC_JOB_DONE,   /* the segment's file is there */
    ENC_JOB_FAILED, /* the process has said why */
    ENC_JOB_KILLED  /* by a signal, which is said here */
} enc_job_state;

/* Starts a process that fits a segment and writes its file.  0, or -1 after printing why. */
int enc_job_start(enc_job *job, const enc_parts *parts, uint32_t segment);

/* Takes in what the process has reported; after any other answer than ENC_JOB_RUNNING there is none. */
enc_job_state enc_job_check(enc_job *job);

/* Ends the process, if there is one. */
void enc_job_stop(enc_job *job);

#endif
