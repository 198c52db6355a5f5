/* Command line of nsdf-cmp. */
#ifndef NSDF_CMP_OPTIONS_H
#define NSDF_CMP_OPTIONS_H

#include "nsdf/compare.h"

/* What is done about open sheets of the reference. */
typedef enum cmp_shell { CMP_SHELL_NONE, CMP_SHELL_AUTO, CMP_SHELL_GIVEN } cmp_shell;

typedef enum cmp_format { CMP_TABLE, CMP_CSV, CMP_JSON } cmp_format;

typedef struct cmp_options {
    nsdf_compare_options compare;
    const char *reference, *decoded;
    const char *frames;          /* list; NULL = all */
    const char *output;          /* NULL = standard output */
    const char *heatmap;         /* name or pattern; NULL = none */
    double heatmap_max;          /* in the units of the output; 0 = 5e-3 of the diagonal */
    double peak;                 /* world units; 0 = longest side of the reference's box */
    uint32_t resolution;         /* 0 = the file's */
    uint32_t rate_num, rate_den; /* of times in seconds; 0 = the file's, or 25 */
    int ignore_numbers;          /* of files */
    cmp_shell shell;
    double thickness; /* world units, where it is given */
    cmp_format format;
    int world, common;
    int quiet, verbose;
} cmp_options;

/* Fills *options from the arguments.  Returns -1 when the program should go on, otherwise its exit code (--help and
 * --version have printed, or the error is printed).  Strings are borrowed from the arguments. */
int cmp_options_parse(cmp_options *options, int argc, char **argv);

/* Whether a path names an .nsdf file. */
int cmp_is_nsdf(const char *path);

#endif
