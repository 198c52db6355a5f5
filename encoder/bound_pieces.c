#include "bound_pieces.h"

#include "surface_error.h"

#include <math.h>
#include <stdlib.h>

static const uint32_t resolutions[] = {64, 80, 96, 112, 128, 160, 192, 224, 256, 320, 384, 512};
enum { RESOLUTIONS = sizeof resolutions / sizeof *resolutions, SIZES = 5, LARGEST = 32 };
enum { MOST_VERTICES = 128 }; /* of a piece */

typedef struct {
    nsdf_decoder *decoder;
    double t;
    const nsdf_file_header *header;
    uint32_t pieces;
    uint32_t *first, *stride; /* [pieces + 1]: of their points; [pieces]: triangles from one to the next */
    size_t count;
    float *points;           /* [count][3], world */
    float *centres, *values; /* [count][SIZES], of the cubes around each point */
} search;

/* ---- Points on the pieces --------------------------------------------------------------------------------- */

/* Triangles between one point of a piece and the next. */
static uint32_t stride(uint32_t triangles) {
    return 1 + triangles / MOST_VERTICES;
}

/* Where the points of each piece begin; the largest gets none. */
static void place_pieces(search *s, const nsdf_surface *surface, const uint32_t *piece) {
    uint32_t *triangles = s->first + 1, end = 0;
    const uint32_t largest = nsdf_largest_piece(surface, piece, s->pieces, triangles);
    s->first[0] = 0;
    for (uint32_t p = 0; p < s->pieces; p++) {
        s->stride[p] = stride(triangles[p]);
        end += p == largest ? 0 : (triangles[p] + s->stride[p] - 1) / s->stride[p];
        s->first[p + 1] = end;
    }
    s->stride[largest] = 0;
    s->count = end;
}

/* First vertices of some triangles of each piece, spread over all of them. */
static void take_points(search *s, const nsdf_surface *surface, const uint32_t *piece, uint32_t *seen) {
    for (uint32_t i = 0; i < surface->triangle_count; i++) {
        const uint32_t p = piece[i];
        if (s->stride[p] == 0 || seen[p]++ % s->stride[p] != 0)
            continue;
        const float *v = surface->positions + 3 * (size_t)surface->indices[3 * (size_t)i];
        float *to = s->points + 3 * ((size_t)s->first[p] + (seen[p] - 1) / s->stride[p]);
        for (size_t k = 0; k < 3; k++)
            to[k] = (float)((double)v[k] * s->header->scale + s->header->centre[k]);
    }
}

/* ---- Cubes ------------------------------------------------------------------------------------------------ */

/* Along one axis, of the cube of `size` cells around x; the grid is the mesher's (decoder/mesher_grid.c). */
static float centre_along(const nsdf_file_header *h, int axis, double step, uint32_t size, double x) {
    const double low = (double)h->domain_min[axis], high = (double)h->domain_max[axis];
    const double cells = fmax(2.0, ceil((high - low) / step - 1e-3)), first = 0.5 * (low + high - cells * step);
    const double at = (floor((x - first) / (step * size)) + 0.5) * size;
    return (float)(fmin(fmax(first + at * step, low), high) * h->scale + h->centre[axis]);
}

static nsdf_status evaluate_cubes(search *s, double step) {
    const nsdf_file_header *h = s->header;
    float *to = s->centres;
    for (size_t i = 0; i < s->count; i++)
        for (uint32_t size = LARGEST; size >= 2; size /= 2)
            for (int k = 0; k < 3; k++)
                *to++ =
                    centre_along(h, k, step, size, ((double)s->points[3 * i + (size_t)k] - h->centre[k]) / h->scale);
    return nsdf_evaluate(s->decoder, s->t, s->centres, s->count * SIZES, s->values, NULL);
}

/* With which all cubes around a point are kept. */
static double bound_of_point(const search *s, size_t i, double step) {
    double most = 0.0;
    uint32_t size = LARGEST;
    for (size_t k = 0; k < SIZES; k++, size /= 2)
        most = fmax(most, fabs((double)s->values[i * SIZES + k]) / (0.5 * sqrt(3.0) * size * step * s->header->scale));
    return most;
}

/* The largest, over the pieces, of the least of their points. */
static double bound_at(const search *s, double step) {
    double most = 0.0;
    for (uint32_t p = 0; p < s->pieces; p++) {
        double least = s->first[p] < s->first[p + 1] ? INFINITY : 0.0;
        for (size_t i = s->first[p]; i < s->first[p + 1]; i++)
            least = fmin(least, bound_of_point(s, i, step));
        most = fmax(most, least);
    }
    return most;
}

static nsdf_status search_all(search *s, double *bound) {
    const nsdf_file_header *h = s->header;
    double longest = 0.0;
    for (int k = 0; k < 3; k++)
        longest = fmax(longest, (double)h->domain_max[k] - (double)h->domain_min[k]);
    nsdf_status status = NSDF_OK;
    for (size_t r = 0; r < RESOLUTIONS && status == NSDF_OK; r++) {
        const double step = longest / resolutions[r];
        status = evaluate_cubes(s, step);
        if (status == NSDF_OK)
            *bound = fmax(*bound, bound_at(s, step));
    }
    return status;
}

static nsdf_status search_surface(search *s, const nsdf_surface *surface, const uint32_t *piece, double *bound) {
    uint32_t *seen = calloc(s->pieces, sizeof *seen);
    nsdf_status status = NSDF_NO_MEMORY;
    s->first = malloc(((size_t)s->pieces + 1) * sizeof *s->first);
    s->stride = malloc(s->pieces * sizeof *s->stride);
    if (seen && s->first && s->stride) {
        place_pieces(s, surface, piece);
        s->points = malloc((3 * s->count + 1) * sizeof(float));
        s->centres = malloc((3 * SIZES * s->count + 1) * sizeof(float));
        s->values = malloc((SIZES * s->count + 1) * sizeof(float));
    }
    if (s->points && s->centres && s->values) {
        take_points(s, surface, piece, seen);
        status = search_all(s, bound);
    }
    free(seen);
    free(s->first);
    free(s->stride);
    free(s->points);
    free(s->centres);
    free(s->values);
    return status;
}

nsdf_status nsdf_bound_of_pieces(nsdf_decoder *decoder, double t, const nsdf_file_header *header,
                                 const nsdf_surface *surface, const uint32_t *piece, uint32_t pieces, double *bound) {
    search s = {.decoder = decoder, .t = t, .header = header, .pieces = pieces};
    return pieces > 1 ? search_surface(&s, surface, piece, bound) : NSDF_OK;
}
