/* Frames, times and segments (spec, section 2). */
#include "stream.h"

double nsdf_stream_frame_time(const nsdf_stream *stream, uint32_t index) {
    return (double)((uint64_t)index * stream->header.rate_den) / (double)stream->header.rate_num;
}

double nsdf_stream_duration(const nsdf_stream *stream) {
    return nsdf_stream_frame_time(stream, stream->header.frame_count - 1);
}

/* The same of any frame, also one before the first. */
static double time_of(const nsdf_stream *stream, int64_t frame) {
    /* Both factors are exact, so that the product is rounded once, as the integer would be. */
    return (double)frame * (double)stream->header.rate_den / (double)stream->header.rate_num;
}

static uint32_t find_segment(const nsdf_stream *stream, double t) {
    uint32_t low = 0, high = stream->header.segment_count; /* the segment is in [low, high) */
    while (high - low > 1) {
        const uint32_t middle = low + (high - low) / 2;
        if (nsdf_stream_frame_time(stream, stream->entries[middle].first_frame) <= t)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* Where t lies in the time of a segment's model. */
static double model_time(const nsdf_stream *stream, uint32_t segment, double t) {
    const nsdf_index_entry *e = &stream->entries[segment];
    const double start = time_of(stream, (int64_t)e->first_frame - e->lead);
    const double end = time_of(stream, (int64_t)e->last_frame + e->trail);
    const double u = end > start ? (t - start) / (end - start) : 0.0;
    return u < 0.0 ? 0.0 : u > 1.0 ? 1.0 : u;
}

/* How far the cross-fade into a segment is at time t: 0 before it, 1 after it, and smooth between them. */
static double faded_in(const nsdf_stream *stream, uint32_t segment, double t) {
    const nsdf_index_entry *e = &stream->entries[segment];
    const double start = time_of(stream, (int64_t)e->first_frame - e->fade);
    const double end = time_of(stream, (int64_t)e->first_frame + e->fade);
    if (t <= start || t >= end)
        return t < end ? 0.0 : 1.0;
    const double s = (t - start) / (end - start);
    return s * s * (3.0 - 2.0 * s);
}

nsdf_place nsdf_stream_find(const nsdf_stream *stream, double t) {
    const uint32_t segment = find_segment(stream, t);
    nsdf_place place = {segment, 1, {model_time(stream, segment, t), 0.0}, {1.0, 0.0}};
    double share = faded_in(stream, segment, t);
    if (share < 1.0) {
        place.first = segment - 1; /* the first segment has no cross-fade */
    } else {
        share = segment + 1 < stream->header.segment_count ? faded_in(stream, segment + 1, t) : 0.0;
        if (share <= 0.0)
            return place;
    }
    place.count = 2;
    for (uint32_t k = 0; k < 2; k++)
        place.u[k] = model_time(stream, place.first + k, t);
    place.share[0] = 1.0 - share;
    place.share[1] = share;
    return place;
}
