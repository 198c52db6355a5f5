/* Options as the caller gave them -> options with every field set and checked. */
#ifndef NSDF_OPTIONS_H
#define NSDF_OPTIONS_H

#include "nsdf/decoder.h"

enum { NSDF_MAX_THREADS = 256, NSDF_MAX_PROJECTION = 8, NSDF_MIN_RESOLUTION = 2 };

/* given NULL = defaults.  A smaller struct_size than today's is that of an older caller: the missing fields get their
 * defaults. */
nsdf_status nsdf_options_resolve(const nsdf_decoder_options *given, nsdf_decoder_options *options, nsdf_error *error);
nsdf_status nsdf_mesh_options_resolve(const nsdf_mesh_options *given, nsdf_mesh_options *options, nsdf_error *error);

#endif
