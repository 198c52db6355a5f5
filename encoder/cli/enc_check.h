/* nsdf-enc --check: what is wrong with the input, and what would be done about it. */
#ifndef ENC_CHECK_H
#define ENC_CHECK_H

#include "cli_list.h"
#include "enc_options.h"
#include "nsdf/sequence.h"

/* Checks the chosen frames and prints a line for each and a summary, or JSON, to the output (standard output where none
 * was named).  Returns the exit code: success when all can be encoded. */
int enc_check(const enc_options *options, nsdf_sequence *sequence, const nsdf_cli_list *list);

#endif
