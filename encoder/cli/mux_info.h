/* What is in a file, and what is wrong with it. */
#ifndef NSDF_MUX_INFO_H
#define NSDF_MUX_INFO_H

#include "mux_input.h"

/* An exit code, after printing JSON on standard output or why not. */
int mux_info_print(const mux_input *input);
/* An exit code, after printing that the file is sound, or all that is found to be wrong with it. */
int mux_info_validate(const mux_input *input);

#endif
