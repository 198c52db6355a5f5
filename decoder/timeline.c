/* Frames, times and segments. */
#include "stream.h"

double nsdf_stream_frame_time(const nsdf_stream *stream, uint32_t index) {
    return (double)((uint64_t)index * stream->header.rate_den) / (double)stream->header.rate_num;
}

double nsdf_stream_duration(const nsdf_stream *stream) {
    return nsdf_stream_frame_time(stream, stream->header.frame_count - 1);
}

uint32_t nsdf_stream_find(const nsdf_stream *stream, double t, double *u) {
    uint32_t low = 0, high = stream->header.segment_count; /* the segment is in [low, high) */
    while (high - low > 1) {
        const uint32_t middle = low + (high - low) / 2;
        if (nsdf_stream_frame_time(stream, stream->entries[middle].first_frame) <= t)
            low = middle;
        else
            high = middle;
    }
    const double start = nsdf_stream_frame_time(stream, stream->entries[low].first_frame);
    const double end = nsdf_stream_frame_time(stream, stream->entries[low].last_frame);
    *u = end > start ? (t - start) / (end - start) : 0.0;
    return low;
}
