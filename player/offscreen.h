/* Pictures without a display. */
#ifndef PLAY_OFFSCREEN_H
#define PLAY_OFFSCREEN_H

#include "cli_input.h"
#include "play_options.h"

/* Draws the times that the options choose into files or to standard output.  An exit code, after printing why.
 * `input` is what the decoder reads. */
int play_offscreen_run(const play_options *options, nsdf_cli_input *input, nsdf_decoder *decoder);

#endif
