/* --report: what was done and what came out, as JSON. */
#ifndef NSDF_ENC_REPORT_H
#define NSDF_ENC_REPORT_H

#include "cli_util.h"
#include "enc_options.h"

/* Writes the report to an open file and closes it.  also_bytes[also_count]: sizes of the files of --also.  0, or -1
 * after printing why. */
int enc_report_write(nsdf_cli_file *file, const enc_options *options, const nsdf_encoder_stats *stats,
                     const uint64_t *also_bytes, int interrupted);

#endif
