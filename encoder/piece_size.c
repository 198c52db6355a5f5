/* How small the pieces of a frame are: decoded pieces that are much smaller are no part of the surface. */
#include "frames.h"
#include "surface_error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The smallest of the pieces with a triangle on the outside.  Outer triangles are some of the surface's, in the same
 * order. */
static float smallest_outside(const nsdf_frame *frame, const uint32_t *piece, const float *sizes) {
    const nsdf_surface *whole = &frame->surface, *outer = nsdf_frame_outer(frame);
    float least = INFINITY;
    for (uint32_t i = 0, k = 0; i < whole->triangle_count && k < outer->triangle_count; i++)
        if (memcmp(whole->indices + 3 * (size_t)i, outer->indices + 3 * (size_t)k, 3 * sizeof(uint32_t)) == 0) {
            least = fminf(least, sizes[piece[i]]);
            k++;
        }
    return least;
}

int nsdf_frame_find_smallest_piece(nsdf_frame *frame) {
    const nsdf_surface *s = &frame->surface;
    uint32_t *piece = malloc(((size_t)s->triangle_count + 1) * sizeof *piece);
    const int64_t count = piece ? nsdf_surface_components(s, piece) : -1;
    float *sizes = count >= 0 ? malloc(((size_t)count + 1) * sizeof *sizes) : NULL;
    const int failed = !sizes || nsdf_piece_sizes(s, piece, (uint32_t)count, sizes) != 0;
    if (!failed)
        frame->smallest_piece = smallest_outside(frame, piece, sizes);
    free(piece);
    free(sizes);
    return failed ? -1 : 0;
}

float nsdf_frames_smallest_piece(const nsdf_frames *frames) {
    float least = INFINITY;
    for (uint32_t i = 0; i < frames->count; i++)
        least = fminf(least, frames->frames[i].smallest_piece);
    return least;
}
