/* What the commands' options have in common.  `option` is as the user writes it: "--times". */
#ifndef NSDF_CLI_OPTION_H
#define NSDF_CLI_OPTION_H

#include <getopt.h>
#include <stdint.h>

/* What getopt_long found fault with, when it keeps quiet (opterr 0, a ':' first in the short options) and has answered
 * ':' or '?'.  Prints it and returns NSDF_CLI_USAGE. */
int nsdf_cli_refuse_option(int answer, int argc, char **argv, const struct option *options);

/* Prints that the text is not `expected` and returns NSDF_CLI_USAGE. */
int nsdf_cli_bad_value(const char *option, const char *text, const char *expected);

/* A whole number from min to max: NSDF_CLI_SUCCESS, or NSDF_CLI_USAGE after printing why not. */
int nsdf_cli_take_count(const char *option, const char *text, uint32_t min, uint32_t max, uint32_t *out);
/* The same for a rate such as 50, 29.97 or 60000/1001. */
int nsdf_cli_take_rate(const char *option, const char *text, uint32_t *num, uint32_t *den);

/* Whether the long option of that value takes a value. */
int nsdf_cli_takes_value(int option, const struct option *options);

#endif
