/* Meshes whose parts pass through each other: which triangles are on the outside of their union. */
#include "frames.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A triangle is hidden when a point this far in front of it (normalised) is inside of the mesh still. */
static const float step_out = 1e-4f;

/* Of these, one in so many is looked at first: most meshes hide nothing. */
enum { COARSE = 8 };

static int is_hidden(const nsdf_sdf *sdf, const nsdf_surface *s, uint32_t triangle) {
    const uint32_t *t = s->indices + 3 * (size_t)triangle;
    const float *a = s->positions + 3 * (size_t)t[0], *b = s->positions + 3 * (size_t)t[1],
                *c = s->positions + 3 * (size_t)t[2];
    float u[3], v[3], n[3], p[3];
    for (int k = 0; k < 3; k++) {
        u[k] = b[k] - a[k];
        v[k] = c[k] - a[k];
    }
    for (int k = 0; k < 3; k++)
        n[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
    float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (!(length > 0.0f))
        return 0;
    for (int k = 0; k < 3; k++)
        p[k] = (a[k] + b[k] + c[k]) / 3.0f + step_out * n[k] / length;
    return nsdf_sdf_winding(sdf, p) > 0.5f;
}

static int hides_any(const nsdf_sdf *sdf, const nsdf_surface *s) {
    for (uint32_t i = 0; i < s->triangle_count; i += COARSE)
        if (is_hidden(sdf, s, i))
            return 1;
    return 0;
}

int nsdf_frame_find_outer(nsdf_frame *frame) {
    const nsdf_surface *s = &frame->surface;
    nsdf_sdf *sdf = nsdf_sdf_create(s, NSDF_SIGN_WINDING);
    if (!sdf)
        return -1;
    if (!hides_any(sdf, s)) {
        nsdf_sdf_free(sdf);
        return 0;
    }
    nsdf_surface outer = {s->positions, malloc(3 * sizeof(uint32_t) * (size_t)s->triangle_count), s->vertex_count, 0};
    for (uint32_t i = 0; outer.indices && i < s->triangle_count; i++)
        if (!is_hidden(sdf, s, i))
            memcpy(outer.indices + 3 * (size_t)outer.triangle_count++, s->indices + 3 * (size_t)i,
                   3 * sizeof(uint32_t));
    nsdf_sdf_free(sdf);
    if (!outer.indices)
        return -1;
    if (outer.triangle_count == 0)
        free(outer.indices); /* nothing is outside: take the mesh as it is */
    else
        frame->outer = outer;
    frame->report.hidden_faces = s->triangle_count - nsdf_frame_outer(frame)->triangle_count;
    return 0;
}

const nsdf_surface *nsdf_frame_outer(const nsdf_frame *frame) {
    return frame->outer.triangle_count ? &frame->outer : &frame->surface;
}

nsdf_sdf *nsdf_frame_sdf(const nsdf_frame *frame) {
    if (frame->outer.triangle_count)
        return nsdf_sdf_create_union(&frame->outer, &frame->surface);
    return nsdf_sdf_create(&frame->surface, frame->sign);
}
