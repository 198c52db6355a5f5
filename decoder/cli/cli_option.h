/* Options that getopt_long does not understand. */
#ifndef NSDF_CLI_OPTION_H
#define NSDF_CLI_OPTION_H

#include <getopt.h>

/* What getopt_long found fault with, when it keeps quiet (opterr 0, a ':' first in the short options) and has answered
 * ':' or '?'.  Prints it and returns NSDF_CLI_USAGE. */
int nsdf_cli_refuse_option(int answer, int argc, char **argv, const struct option *options);

#endif
