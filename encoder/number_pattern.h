/* File names with one number in them, written as printf patterns: walk_%04d.obj. */
#ifndef NSDF_NUMBER_PATTERN_H
#define NSDF_NUMBER_PATTERN_H

#include <stdbool.h>
#include <stdint.h>

#define NSDF_PATTERN_NAME 256 /* bytes of a file name, with the zero */

typedef struct nsdf_number_pattern {
    char prefix[NSDF_PATTERN_NAME], suffix[NSDF_PATTERN_NAME];
    int width; /* least number of characters */
    char pad;  /* '0' or ' ' */
} nsdf_number_pattern;

/* Understands exactly one %d, %i or %u with an optional 0 and a width below 10; %% is a percent sign.  Returns false
 * for anything else. */
bool nsdf_number_pattern_parse(nsdf_number_pattern *pattern, const char *name);

/* Whether the pattern gives this name for some number (of up to 18 digits). */
bool nsdf_number_pattern_match(const nsdf_number_pattern *pattern, const char *name, uint64_t *number);

#endif
