/* From frames to a fitted block part, and to its bytes. */
#ifndef NSDF_BLOCK_STAGE_H
#define NSDF_BLOCK_STAGE_H

#include "block_fit.h"
#include "container.h"
#include "nodes.h"

/* The options with the steps, frames and points of blocks, for a sequence of so many frames, in the place of the
 * network's. */
nsdf_encoder_options nsdf_block_options(const nsdf_encoder_options *options, uint32_t frame_count);

/* What is known of the surface's motion before there are blocks. */
typedef struct nsdf_tracked {
    nsdf_nodes nodes; /* enough for options->blocks */
    double area;      /* of the surface at rest */
} nsdf_tracked;

/* Follows the surface.  Returns 0, or -1 when memory ran out (then there is nothing to free). */
int nsdf_track_surface(const nsdf_fit_job *job, nsdf_tracked *tracked);

/* The least share of a frame's surface that the blocks would hold.  Returns 0, or -1 when memory ran out. */
int nsdf_find_block_cover(const nsdf_fit_job *job, const nsdf_tracked *tracked, double *least);

/* Places the blocks on what was tracked, finds bones and first values.  Returns 0, or -1 when memory ran out. */
int nsdf_start_blocks(const nsdf_fit_job *job, const nsdf_tracked *tracked, nsdf_block_model *model);

/* Tracks unless that is done, finds bones, starts and fits.  Returns as nsdf_fit_run. */
int nsdf_fit_blocks(const nsdf_fit_job *job, nsdf_block_model *model, nsdf_fit_result *result);

/* As nsdf_code_segment. */
int nsdf_code_blocks(const nsdf_block_model *model, nsdf_coded_segment *segment);

/* Where the coded bytes go.  Returns 0, or -1 when memory ran out. */
int nsdf_weigh_blocks(const nsdf_block_model *model, nsdf_block_bytes *bytes);

#endif
