/* The result of nsdf-cmp as a table, CSV or JSON. */
#ifndef NSDF_CMP_OUTPUT_H
#define NSDF_CMP_OUTPUT_H

#include "cli_util.h"
#include "cmp_options.h"

typedef struct cmp_result {
    const cmp_options *options;
    const uint32_t *frames; /* [count]: their numbers */
    const nsdf_difference *differences;
    uint32_t count;
    double diagonal, peak; /* world units */
    nsdf_difference_summary summary;
} cmp_result;

/* Writes to a file that was opened; failures are kept there. */
void cmp_output_write(const cmp_result *result, nsdf_cli_file *file);

#endif
