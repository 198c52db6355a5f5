/* Which times to decode. */
#ifndef NSDF_DEC_TIMES_H
#define NSDF_DEC_TIMES_H

#include "dec_options.h"

typedef struct dec_times {
    double *seconds; /* owned */
    uint32_t count;  /* >= 1 */
} dec_times;

/* NSDF_CLI_SUCCESS, or another exit code after printing why.  Free with dec_times_free in either case. */
int dec_times_choose(const dec_options *options, const nsdf_decoder *decoder, dec_times *times);
void dec_times_free(dec_times *times);

#endif
