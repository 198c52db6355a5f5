/* Keeping segments, scratch memory and the time in step. */
#include "handle.h"
#include "status.h"

#include <math.h>

nsdf_status nsdf_handle_invalid(nsdf_decoder *decoder, const char *message) {
    return nsdf_fail(&decoder->error, NSDF_INVALID_ARGUMENT, 0, 0, "%s", message);
}

void nsdf_handle_trim(nsdf_decoder *decoder, const nsdf_segment *keep) {
    nsdf_mesher_free(&decoder->mesher);
    nsdf_mesh_storage_free(&decoder->memory, &decoder->into);
    nsdf_cache_clear(&decoder->cache, &decoder->memory, keep);
    if (!keep) {
        nsdf_memory_give(&decoder->memory, decoder->field.scratch);
        decoder->field.scratch = NULL;
        decoder->scratch_floats = 0;
    }
}

nsdf_status nsdf_handle_segment(nsdf_decoder *decoder, uint32_t index, nsdf_segment **segment) {
    nsdf_status status =
        nsdf_cache_get(&decoder->cache, &decoder->stream, &decoder->memory, index, segment, &decoder->error);
    if (status == NSDF_LIMIT) {
        nsdf_handle_trim(decoder, NULL);
        status = nsdf_cache_get(&decoder->cache, &decoder->stream, &decoder->memory, index, segment, &decoder->error);
    }
    if (status == NSDF_OK)
        decoder->parameter_counts[index] = (*segment)->parameter_count;
    return status;
}

/* Scratch memory for all workers, taken here, on the calling thread, because tasks may not allocate. */
static nsdf_status take_scratch(nsdf_decoder *decoder, const nsdf_segment *segment) {
    const uint64_t stride = (nsdf_segment_scratch(segment) + 15) / 16 * 16;
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
        nsdf_handle_trim(decoder, segment);
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
    double u;
    nsdf_segment *segment;
    nsdf_status status = nsdf_handle_segment(decoder, nsdf_stream_find(&decoder->stream, clamped, &u), &segment);
    if (status == NSDF_OK)
        status = take_scratch(decoder, segment);
    if (status != NSDF_OK)
        return status;
    nsdf_segment_compose(segment, u);
    decoder->field.segment = segment;
    return NSDF_OK;
}
