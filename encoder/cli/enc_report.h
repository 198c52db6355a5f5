/* --report: what was done and what came out, as JSON. */
#ifndef NSDF_ENC_REPORT_H
#define NSDF_ENC_REPORT_H

#include "enc_options.h"

/* Writes the report under a temporary name (nsdf_cli_commit makes it visible).  0, or -1 after printing why. */
int enc_report_write(const enc_options *options, const nsdf_encoder_stats *stats, int interrupted);

#endif
