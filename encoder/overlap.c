/* Meshes whose parts pass through each other: which triangles are on the outside of their union. */
#include "frames.h"

#include "hidden.h"

/* One in so many triangles is looked at first: most meshes hide nothing. */
enum { FIRST_LOOK = 8 };

int nsdf_frame_find_outer(nsdf_frame *frame) {
    if (nsdf_find_outer(&frame->surface, &frame->surface, FIRST_LOOK, &frame->outer) != 0)
        return -1;
    frame->report.hidden_faces = frame->surface.triangle_count - nsdf_frame_outer(frame)->triangle_count;
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
