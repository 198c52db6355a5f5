/* What is in a file, printed on standard output. */
#ifndef NSDF_DEC_INFO_H
#define NSDF_DEC_INFO_H

#include "dec_options.h"

/* NSDF_OK, or the status of the call that failed.  `load` also reads all segments, to say what is in them. */
nsdf_status dec_info_print(nsdf_decoder *decoder, const char *path, int load);
nsdf_status dec_info_print_json(nsdf_decoder *decoder, const char *path, int load);

#endif
