/* Keeping segments, scratch memory and the time in step. */
#include "handle.h"
#include "status.h"

#include <math.h>

nsdf_status nsdf_handle_invalid(nsdf_decoder *decoder, const char *message) {
    return nsdf_fail(&decoder->error, NSDF_INVALID_ARGUMENT, 0, 0, "%s", message);
}

void nsdf_handle_trim(nsdf_decoder *decoder, const nsdf_segment *const keep[2]) {
    nsdf_mesher_free(&decoder->mesher);
    nsdf_mesh_storage_free(&decoder->memory, &decoder->into);
    nsdf_cache_clear(&decoder->cache, &decoder->memory, keep);
    if (!keep) {
        nsdf_memory_give(&decoder->memory, decoder->field.scratch);
        decoder->field.scratch = NULL;
        decoder->scratch_floats = 0;
    }
}

/* `count` consecutive segments, which fit into the cache together. */
static nsdf_status get_segments(nsdf_decoder *decoder, uint32_t first, uint32_t count, nsdf_segment **segments) {
    nsdf_status status = NSDF_OK;
    for (uint32_t k = 0; status == NSDF_OK && k < count; k++) {
        status = nsdf_cache_get(&decoder->cache, &decoder->stream, &decoder->memory, first + k, &segments[k],
                                &decoder->error);
        if (status == NSDF_OK)
            decoder->parameter_counts[first + k] = segments[k]->parameter_count;
    }
    return status;
}

static nsdf_status load_segments(nsdf_decoder *decoder, uint32_t first, uint32_t count, nsdf_segment **segments) {
    nsdf_status status = get_segments(decoder, first, count, segments);
    if (status == NSDF_LIMIT) {
        nsdf_handle_trim(decoder, NULL);
        status = get_segments(decoder, first, count, segments);
    }
    return status;
}

nsdf_status nsdf_handle_segment(nsdf_decoder *decoder, uint32_t index, nsdf_segment **segment) {
    return load_segments(decoder, index, 1, segment);
}

/* Scratch memory for all workers, taken here, on the calling thread, because tasks may not allocate. */
static nsdf_status take_scratch(nsdf_decoder *decoder, nsdf_segment *const segments[2]) {
    const uint64_t needs[2] = {nsdf_segment_scratch(segments[0]), segments[1] ? nsdf_segment_scratch(segments[1]) : 0};
    const uint64_t stride = ((needs[0] > needs[1] ? needs[0] : needs[1]) + 15) / 16 * 16;
    const uint64_t total = stride * nsdf_tasks_workers(decoder->tasks);
    decoder->field.scratch_stride = (size_t)stride;
    if (total <= decoder->scratch_floats)
        return NSDF_OK;
    nsdf_memory_give(&decoder->memory, decoder->field.scratch);
    decoder->field.scratch = NULL;
    decoder->scratch_floats = 0;
    void *block;
    const uint64_t size = total * sizeof(float);
    nsdf_status status = nsdf_memory_take(&decoder->memory, size, &block);
    if (status == NSDF_LIMIT) {
        const nsdf_segment *const keep[2] = {segments[0], segments[1]};
        nsdf_handle_trim(decoder, keep);
        status = nsdf_memory_take(&decoder->memory, size, &block);
    }
    if (status != NSDF_OK)
        return nsdf_fail_memory(&decoder->error, status, 0, 0, size);
    decoder->field.scratch = block;
    decoder->scratch_floats = total;
    return NSDF_OK;
}

nsdf_status nsdf_handle_prepare(nsdf_decoder *decoder, double t) {
    if (isnan(t))
        return nsdf_handle_invalid(decoder, "the time is not a number");
    const double duration = nsdf_stream_duration(&decoder->stream);
    const double clamped = t < 0.0 ? 0.0 : t > duration ? duration : t;
    const nsdf_place place = nsdf_stream_find(&decoder->stream, clamped);
    nsdf_segment *segments[2] = {NULL, NULL};
    nsdf_status status = load_segments(decoder, place.first, place.count, segments);
    if (status == NSDF_OK)
        status = take_scratch(decoder, segments);
    if (status != NSDF_OK)
        return status;
    for (uint32_t k = 0; k < 2; k++) {
        decoder->field.segments[k] = segments[k];
        decoder->field.share[k] = (float)place.share[k];
        if (segments[k])
            nsdf_segment_compose(segments[k], place.u[k], decoder->tasks);
    }
    const nsdf_index_entry *entries = &decoder->stream.entries[place.first];
    decoder->smallest_piece = entries[0].smallest_piece;
    if (place.count > 1 && entries[1].smallest_piece < decoder->smallest_piece)
        decoder->smallest_piece = entries[1].smallest_piece;
    return NSDF_OK;
}
