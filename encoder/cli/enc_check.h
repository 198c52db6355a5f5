/* nsdf-enc --check: what is wrong with the input, and what would be done about it. */
#ifndef ENC_CHECK_H
#define ENC_CHECK_H

#include "cli_list.h"
#include "enc_options.h"
#include "nsdf/sequence.h"

/* Checks the chosen frames and prints a line for each and a summary, or JSON, to the output (standard output where none
 * was named).  Returns the exit code: success when all can be encoded. */
int enc_check(const enc_options *options, nsdf_sequence *sequence, const nsdf_cli_list *list);

/* The numbers in the names of the files, or "" where none are missing or files are not numbered alike: "3, 8-9".
 * Returns text. */
const char *enc_missing_numbers(const nsdf_sequence *sequence, char *text, size_t size);

#endif
