/* Pictures of the meshes that a file was made from, beside the decoded ones or as heat maps. */
#ifndef PLAY_COMPARE_VIEW_H
#define PLAY_COMPARE_VIEW_H

#include "play_options.h"
#include "renderer.h"

typedef struct play_compare_view play_compare_view;

/* Looks for the meshes of options->compare, which must be as many as the file has frames; options and decoder are
 * borrowed.  NSDF_CLI_SUCCESS, or NSDF_CLI_FAILURE after printing why. */
int play_compare_open(play_compare_view **compare, const play_options *options, nsdf_decoder *decoder);
/* NULL-safe. */
void play_compare_close(play_compare_view *compare);

/* Pixels on the left of a picture, options->width wide, that the input takes: half of them, or all as a heat map. */
int play_compare_width(const play_options *options);

/* Draws the mesh of the frame that is shown at `seconds` there, into rgba[4 * options->width * options->height].
 * NSDF_CLI_SUCCESS, or NSDF_CLI_FAILURE after printing why. */
int play_compare_draw(play_compare_view *compare, play_renderer *renderer, const play_scene *scene, double seconds,
                      unsigned char *rgba);

/* What stands over the decoded surface beside it. */
void play_compare_label(play_overlay *overlay, const play_options *options, double seconds, uint32_t resolution);

#endif
