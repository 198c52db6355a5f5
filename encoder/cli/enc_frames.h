/* The frames of the input that are fitted. */
#ifndef NSDF_ENC_FRAMES_H
#define NSDF_ENC_FRAMES_H

#include "cli_list.h"
#include "enc_options.h"
#include "nsdf/sequence.h"

/* Which of the frames that have a file to fit.  With --frame-step the last one is always among them, so that no time is
 * extrapolated. NSDF_CLI_SUCCESS, or another exit code after printing why; nsdf_cli_list_free in either case. */
int enc_choose_frames(const enc_options *options, const nsdf_sequence *sequence, nsdf_cli_list *list);

/* How many frames have no file; and in one line what that means, where numbers of files are missing, else "". */
uint32_t enc_explain_missing(const nsdf_sequence *sequence, char *text, size_t size);

/* Reads a frame and adds it to the encoder.  0, or -1 after printing why. */
int enc_add_frame(nsdf_encoder *encoder, nsdf_sequence *sequence, uint32_t frame);

#endif
