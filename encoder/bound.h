/* The extraction bound: how large |f| may be at the centre of a cube that the surface passes. */
#ifndef NSDF_BOUND_H
#define NSDF_BOUND_H

#include "check_job.h"
#include "container_write.h"

/* Files get none above it; with it, next to nothing is skipped. */
#define NSDF_HIGHEST_BOUND 64.0

/* For a network: evaluates the file's field on a dense grid at the frames, finds the smallest bound for which no cube
 * of 2 to 32 cells with a change of sign is skipped, adds a margin, and raises it until sparse and dense extraction
 * agree on twelve of them.  For blocks: raises it from 1 until extraction gives what a bound of 4 gives; that the
 * mesher follows the surface into cells that the bound left out is used there.  Where verification follows, which finds
 * what small pieces need in all frames, a third of many frames stands for all.  `file` must hold some bound already;
 * the result goes to *bound. */
nsdf_status nsdf_measure_bound(const nsdf_check_job *job, const nsdf_buffer *file, int blocks, float *bound,
                               nsdf_encoder_error *error);

/* How many times as long measuring a network's bound takes as measuring and checking one frame does, at most, but for
 * more than one round of checks. */
double nsdf_bound_work(const nsdf_check_job *job);

#endif
