/* Long sequences: which segments there are, and how each is fitted. */
#ifndef NSDF_ENC_PLAN_H
#define NSDF_ENC_PLAN_H

#include "enc_frames.h"
#include "nsdf/survey.h"

/* Frames of a cross-fade on each side of a cut, at most. */
enum { ENC_OVERLAP = 2 };

typedef struct enc_plan {
    const enc_options *options; /* borrowed, as the two that follow */
    nsdf_sequence *sequence;
    const nsdf_cli_list *list; /* of the frames to fit; spans count their places in it */
    nsdf_span *spans;          /* [count], owned */
    uint64_t *hashes;          /* [count], owned: of all that a segment's file depends on */
    uint32_t count;
    double box_min[3], box_max[3];
    uint64_t triangles; /* in all frames */
    uint32_t at_once;   /* segments that are fitted at a time on this machine, for sharing out its processors */
} enc_plan;

/* Whether the sequence is fitted in segments: --segment says so, or it is long.  0, 1, or -1 after printing why a frame
 * cannot be read. */
int enc_plan_needed(const enc_options *options, nsdf_sequence *sequence, const nsdf_cli_list *list);

/* Looks over all frames.  0, or -1 after printing why; enc_plan_free in either case. */
int enc_plan_make(enc_plan *plan, const enc_options *options, nsdf_sequence *sequence, const nsdf_cli_list *list);
void enc_plan_free(enc_plan *plan);

/* Bytes that --size or --bitrate asks for; 0 without them. */
double enc_plan_size(const enc_plan *plan);

/* The options of one segment: a size or a bitrate for the whole file is shared out by time. */
nsdf_encoder_options enc_plan_options(const enc_plan *plan, uint32_t segment);

/* Nominal frames of a cross-fade into a segment on each side of the cut. */
uint32_t enc_plan_fade(const enc_plan *plan, uint32_t segment);

#endif
