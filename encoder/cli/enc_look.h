/* Looking over all frames of a long sequence, many at a time. */
#ifndef NSDF_ENC_LOOK_H
#define NSDF_ENC_LOOK_H

#include "cli_list.h"
#include "nsdf/sequence.h"
#include "nsdf/survey.h"

/* Adds the frames to the survey, in their order, with `threads` threads, 0 = one per core; *triangles gets the number
 * in all of them.  0, or -1 after printing why, or when interrupted. */
int enc_look_over(nsdf_survey *survey, nsdf_sequence *sequence, const nsdf_cli_list *frames, uint32_t threads,
                  uint64_t *triangles);

#endif
