/* Errors as colours. */
#ifndef PLAY_HEAT_H
#define PLAY_HEAT_H

#include "nsdf/decoder.h"
#include "overlay.h"

/* How far the decoded surface of time t is from points, as shares of `top` (world units): share[count].  The distance
 * is |f| / |grad f|, which is that to the zero set where that is near, as it is here; it needs no search. */
nsdf_status play_heat_measure(nsdf_decoder *decoder, double t, const float *points, size_t count, double top,
                              float *share);

/* What the colours mean, in the lower right corner. */
void play_heat_legend(play_overlay *overlay, double top_of_diagonal, int width, int height);

#endif
