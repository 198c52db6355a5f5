/* Speed of opening, extraction and evaluation, printed on standard output. */
#ifndef NSDF_DEC_BENCH_H
#define NSDF_DEC_BENCH_H

#include "cli_input.h"
#include "dec_options.h"

/* NSDF_OK, or the status of the call that failed.  The times are those to extract at; of many, a few are used. */
nsdf_status dec_bench_run(nsdf_decoder *decoder, nsdf_cli_input *input, const dec_options *options,
                          const nsdf_decoder_options *open_options, const nsdf_mesh_options *mesh_options,
                          const nsdf_cli_times *times);

#endif
