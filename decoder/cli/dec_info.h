/* What is in a file, printed on standard output. */
#ifndef NSDF_DEC_INFO_H
#define NSDF_DEC_INFO_H

#include "dec_options.h"

/* NSDF_OK, or the status of the call that failed. */
nsdf_status dec_info_print(nsdf_decoder *decoder, const char *path);
nsdf_status dec_info_print_json(nsdf_decoder *decoder, const char *path);

#endif
