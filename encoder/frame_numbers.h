/* Where the files of a sequence stand in time: numbers of frames, from 0 on. */
#ifndef NSDF_FRAME_NUMBERS_H
#define NSDF_FRAME_NUMBERS_H

#include <stdbool.h>

#include "nsdf/sequence.h"
#include "sequence_paths.h"

/* The numbers of two names that differ in one number only, wherever in them it is ("walk_3.v2.obj" and
 * "walk_12.v2.obj": 3 and 12); false of any others. */
bool nsdf_number_pair(const char *a, const char *b, uint64_t numbers[2]);

/* Numbers the frames of files ([count] of `files`): by the times of a list file, or by the numbers in their names, or
 * one after the other (nsdf/sequence.h has the rules).  NSDF_CORRUPT for times that no frame has; NSDF_LIMIT for
 * numbers too far apart. */
nsdf_status nsdf_number_frames(const nsdf_path_list *files, const nsdf_sequence_options *options, uint32_t *numbers,
                               nsdf_encoder_error *error);

#endif
