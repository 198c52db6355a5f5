/* File names with a frame number in them: out_%04d.obj. */
#ifndef NSDF_CLI_PATTERN_H
#define NSDF_CLI_PATTERN_H

#include <stddef.h>

typedef struct nsdf_cli_pattern {
    const char *name; /* borrowed */
    size_t prefix_length;
    const char *suffix; /* behind the conversion; NULL when there is none */
    int width, zeros;
} nsdf_cli_pattern;

/* Takes a name with at most one %d, %4d or %04d apart; "%%" stands for "%".  NSDF_CLI_SUCCESS, or NSDF_CLI_USAGE after
 * printing why. */
int nsdf_cli_pattern_parse(nsdf_cli_pattern *pattern, const char *name);

/* The name with the number in it, in a buffer that the caller frees; NULL when memory ran out. */
char *nsdf_cli_pattern_name(const nsdf_cli_pattern *pattern, unsigned long long number);

#endif
