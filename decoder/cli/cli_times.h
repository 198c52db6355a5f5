/* Which times of a file to decode: --times, --fps, --frames. */
#ifndef NSDF_CLI_TIMES_H
#define NSDF_CLI_TIMES_H

#include "nsdf/decoder.h"

/* As given on the command line; texts are borrowed, and NULL when not given. */
typedef struct nsdf_cli_choice {
    const char *times, *frames;
    uint32_t rate_num, rate_den; /* of --fps; rate_num 0 when not given */
} nsdf_cli_choice;

typedef struct nsdf_cli_times {
    double *seconds; /* owned */
    uint32_t count;  /* >= 1 */
} nsdf_cli_times;

/* NSDF_CLI_SUCCESS, or another exit code after printing why.  Free with nsdf_cli_times_free in either case. */
int nsdf_cli_times_choose(const nsdf_cli_choice *choice, const nsdf_decoder *decoder, nsdf_cli_times *times);
void nsdf_cli_times_free(nsdf_cli_times *times);

#endif
