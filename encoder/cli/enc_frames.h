/* The frames of the input that are fitted. */
#ifndef NSDF_ENC_FRAMES_H
#define NSDF_ENC_FRAMES_H

#include "cli_list.h"
#include "enc_options.h"
#include "nsdf/sequence.h"

/* Which frames to fit.  With --frame-step the last one is always among them, so that no time is extrapolated.
 * NSDF_CLI_SUCCESS, or another exit code after printing why; nsdf_cli_list_free in either case. */
int enc_choose_frames(const enc_options *options, uint32_t count, nsdf_cli_list *list);

/* Reads a frame and adds it to the encoder.  0, or -1 after printing why. */
int enc_add_frame(nsdf_encoder *encoder, nsdf_sequence *sequence, uint32_t index);

#endif
