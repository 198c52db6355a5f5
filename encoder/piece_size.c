/* How small the pieces of a frame are: decoded pieces that are much smaller are no part of the surface. */
#include "frames.h"
#include "surface_error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    float low[3], high[3];
    int outside; /* has a triangle that counts */
} piece_box;

static void add_triangle(piece_box *box, const nsdf_surface *s, const uint32_t *triangle) {
    for (int k = 0; k < 3; k++)
        for (int a = 0; a < 3; a++) {
            const float x = s->positions[3 * (size_t)triangle[k] + (size_t)a];
            box->low[a] = fminf(box->low[a], x);
            box->high[a] = fmaxf(box->high[a], x);
        }
}

/* Outer triangles are some of the surface's, in the same order. */
static void mark_outside(piece_box *boxes, const nsdf_frame *frame, const uint32_t *piece) {
    const nsdf_surface *whole = &frame->surface, *outer = nsdf_frame_outer(frame);
    for (uint32_t i = 0, k = 0; i < whole->triangle_count && k < outer->triangle_count; i++)
        if (memcmp(whole->indices + 3 * (size_t)i, outer->indices + 3 * (size_t)k, 3 * sizeof(uint32_t)) == 0) {
            boxes[piece[i]].outside = 1;
            k++;
        }
}

static float shortest_diagonal(const piece_box *boxes, int64_t count) {
    float least = INFINITY;
    for (int64_t i = 0; i < count; i++) {
        float square = 0.0f;
        for (int a = 0; a < 3; a++)
            square += (boxes[i].high[a] - boxes[i].low[a]) * (boxes[i].high[a] - boxes[i].low[a]);
        if (boxes[i].outside)
            least = fminf(least, sqrtf(square));
    }
    return least;
}

int nsdf_frame_find_smallest_piece(nsdf_frame *frame) {
    const nsdf_surface *s = &frame->surface;
    uint32_t *piece = malloc(((size_t)s->triangle_count + 1) * sizeof *piece);
    const int64_t count = piece ? nsdf_surface_components(s, piece) : -1;
    piece_box *boxes = count >= 0 ? malloc(((size_t)count + 1) * sizeof *boxes) : NULL;
    if (boxes) {
        const piece_box nothing = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, 0};
        for (int64_t i = 0; i < count; i++)
            boxes[i] = nothing;
        for (uint32_t i = 0; i < s->triangle_count; i++)
            add_triangle(&boxes[piece[i]], s, s->indices + 3 * (size_t)i);
        mark_outside(boxes, frame, piece);
        frame->smallest_piece = shortest_diagonal(boxes, count);
    }
    free(piece);
    free(boxes);
    return boxes ? 0 : -1;
}

float nsdf_frames_smallest_piece(const nsdf_frames *frames) {
    float least = 2.0f * NSDF_LARGEST_SPECK;
    for (uint32_t i = 0; i < frames->count; i++)
        least = fminf(least, frames->frames[i].smallest_piece);
    return 0.5f * least;
}
