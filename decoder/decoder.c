/* The handle: opening, closing, and what is in the file. */
#include "cpu.h"
#include "handle.h"
#include "options.h"
#include "status.h"

#include <string.h>

void nsdf_close(nsdf_decoder **decoder) {
    if (!decoder || !*decoder)
        return;
    nsdf_decoder *d = *decoder;
    nsdf_handle_trim(d, NULL);
    nsdf_tasks_free(&d->tasks);
    nsdf_memory_give(&d->memory, d->parameter_counts);
    nsdf_stream_close(&d->stream, &d->memory);
    nsdf_memory memory = d->memory; /* the account lies in the block it accounts for */
    nsdf_memory_give(&memory, d);
    *decoder = NULL;
}

static nsdf_status take_counts(nsdf_decoder *d, nsdf_error *error) {
    const size_t size = d->stream.header.segment_count * sizeof *d->parameter_counts;
    void *counts;
    nsdf_status status = nsdf_memory_take(&d->memory, size, &counts);
    if (status != NSDF_OK)
        return nsdf_fail_memory(error, status, 0, 0, size);
    memset(counts, 0, size);
    d->parameter_counts = counts;
    return NSDF_OK;
}

static nsdf_status set_up(nsdf_decoder *d, nsdf_error *error) {
    nsdf_status status = nsdf_stream_open(&d->stream, &d->memory, error);
    if (status == NSDF_OK && d->options.check_all)
        status = nsdf_stream_check_all(&d->stream, &d->memory, error);
    if (status == NSDF_OK)
        status = take_counts(d, error);
    if (status != NSDF_OK)
        return status;
    status = nsdf_tasks_create(&d->memory, d->options.threads, &d->options.runner, &d->tasks);
    if (status != NSDF_OK)
        return nsdf_fail_memory(error, status, 0, 0, sizeof(void *));
    const uint32_t features = nsdf_cpu_features() & d->options.cpu_mask;
    d->field.kernels = nsdf_net_kernels_choose(features);
    d->field.block_kernels = nsdf_block_kernels_choose(features);
    return NSDF_OK;
}

/* Takes over *source, also on failure. */
static nsdf_status open_source(nsdf_decoder **decoder, nsdf_source *source, const nsdf_decoder_options *options,
                               nsdf_error *error) {
    nsdf_memory memory;
    void *block;
    nsdf_memory_init(&memory, &options->allocator, options->max_memory);
    nsdf_status status = nsdf_memory_take(&memory, sizeof(nsdf_decoder), &block);
    if (status != NSDF_OK) {
        nsdf_source_close(source);
        return nsdf_fail_memory(error, status, 0, 0, sizeof(nsdf_decoder));
    }
    nsdf_decoder *d = block;
    memset(d, 0, sizeof *d);
    d->options = *options;
    d->memory = memory;
    d->stream.source = *source;
    status = set_up(d, error);
    if (status == NSDF_OK)
        *decoder = d;
    else
        nsdf_close(&d);
    return status;
}

static nsdf_status invalid_open(nsdf_error *error) {
    return nsdf_fail(error, NSDF_INVALID_ARGUMENT, 0, 0, "the handle, the bytes, the path or the callback is NULL");
}

nsdf_status nsdf_open_memory(nsdf_decoder **decoder, const void *data, size_t size, const nsdf_decoder_options *options,
                             nsdf_error *error) {
    nsdf_decoder_options resolved;
    nsdf_source source;
    if (!decoder || !data)
        return invalid_open(error);
    nsdf_status status = nsdf_options_resolve(options, &resolved, error);
    if (status != NSDF_OK)
        return status;
    nsdf_source_memory(&source, data, size);
    return open_source(decoder, &source, &resolved, error);
}

nsdf_status nsdf_open_file(nsdf_decoder **decoder, const char *path, const nsdf_decoder_options *options,
                           nsdf_error *error) {
    nsdf_decoder_options resolved;
    nsdf_source source;
    if (!decoder || !path)
        return invalid_open(error);
    nsdf_status status = nsdf_options_resolve(options, &resolved, error);
    if (status == NSDF_OK)
        status = nsdf_source_file(&source, path, error);
    return status == NSDF_OK ? open_source(decoder, &source, &resolved, error) : status;
}

nsdf_status nsdf_open_callbacks(nsdf_decoder **decoder, const nsdf_io *io, const nsdf_decoder_options *options,
                                nsdf_error *error) {
    nsdf_decoder_options resolved;
    nsdf_source source;
    if (!decoder || !io || !io->read_at)
        return invalid_open(error);
    nsdf_status status = nsdf_options_resolve(options, &resolved, error);
    if (status != NSDF_OK)
        return status;
    nsdf_source_callbacks(&source, io);
    return open_source(decoder, &source, &resolved, error);
}

nsdf_status nsdf_get_error(const nsdf_decoder *decoder, nsdf_error *error) {
    if (!decoder || !error)
        return NSDF_INVALID_ARGUMENT;
    *error = decoder->error;
    return NSDF_OK;
}

static void fill_quality(const nsdf_quality_record *from, nsdf_quality *to) {
    to->mean_to_decoded = from->mean[0];
    to->mean_to_input = from->mean[1];
    to->rms_to_decoded = from->rms[0];
    to->rms_to_input = from->rms[1];
    to->max_to_decoded = from->max[0];
    to->max_to_input = from->max[1];
    to->resolution = from->resolution;
    to->frames = from->frames;
}

static float least_piece(const nsdf_stream *stream) {
    float least = stream->entries[0].smallest_piece;
    for (uint32_t i = 1; i < stream->header.segment_count; i++)
        least = stream->entries[i].smallest_piece < least ? stream->entries[i].smallest_piece : least;
    return least;
}

static void fill_geometry(const nsdf_file_header *header, nsdf_info *info) {
    for (int axis = 0; axis < 3; axis++) {
        info->box_min[axis] = header->box_min[axis];
        info->box_max[axis] = header->box_max[axis];
        info->domain_min[axis] = (double)header->domain_min[axis] * header->scale + header->centre[axis];
        info->domain_max[axis] = (double)header->domain_max[axis] * header->scale + header->centre[axis];
    }
    info->diagonal = header->scale;
    info->default_resolution = header->default_resolution;
    info->extraction_bound = (double)header->extraction_bound;
}

/* The sum over all segments, or 0 while one of them is unknown. */
static uint64_t known_parameters(const nsdf_decoder *decoder) {
    uint64_t total = 0;
    for (uint32_t i = 0; i < decoder->stream.header.segment_count; i++) {
        if (decoder->parameter_counts[i] == 0)
            return 0;
        total += decoder->parameter_counts[i];
    }
    return total;
}

/* One segment: its hash.  Several: the hash of their hashes' little-endian bytes. */
static uint64_t combined_hash(const nsdf_stream *stream) {
    if (stream->header.segment_count == 1)
        return stream->entries[0].parameter_hash;
    uint64_t hash = NSDF_HASH_START;
    for (uint32_t i = 0; i < stream->header.segment_count; i++) {
        uint8_t bytes[8];
        for (int k = 0; k < 8; k++)
            bytes[k] = (uint8_t)(stream->entries[i].parameter_hash >> 8 * k);
        hash = nsdf_hash64(hash, bytes, sizeof bytes);
    }
    return hash;
}

nsdf_status nsdf_get_info(const nsdf_decoder *decoder, nsdf_info *info) {
    if (!decoder || !info)
        return NSDF_INVALID_ARGUMENT;
    const nsdf_stream *stream = &decoder->stream;
    memset(info, 0, sizeof *info);
    info->format_major = stream->version.major;
    info->format_minor = stream->version.minor;
    info->file_size = stream->source.io.size;
    info->rate_num = stream->header.rate_num;
    info->rate_den = stream->header.rate_den;
    info->frame_count = stream->header.frame_count;
    info->duration = nsdf_stream_duration(stream);
    info->segment_count = stream->header.segment_count;
    fill_geometry(&stream->header, info);
    info->smallest_piece = (double)least_piece(stream) * stream->header.scale;
    info->parameter_count = known_parameters(decoder);
    info->parameter_hash = combined_hash(stream);
    fill_quality(&stream->quality, &info->quality);
    return NSDF_OK;
}

uint32_t nsdf_metadata_count(const nsdf_decoder *decoder) {
    return decoder ? decoder->stream.pair_count : 0;
}

nsdf_status nsdf_get_metadata(const nsdf_decoder *decoder, uint32_t index, const char **key, const char **value) {
    if (!decoder || !key || !value || index >= decoder->stream.pair_count)
        return NSDF_INVALID_ARGUMENT;
    *key = decoder->stream.strings[2 * (size_t)index];
    *value = decoder->stream.strings[2 * (size_t)index + 1];
    return NSDF_OK;
}

static void fill_shape(const nsdf_segment *segment, nsdf_segment_info *info) {
    if (segment->part_count == 0)
        return;
    const nsdf_segment_part *part = &segment->parts[0];
    const char *entropy = nsdf_entropy_name((nsdf_entropy_kind)nsdf_segment_tensors(part)->entropy);
    if (entropy)
        memcpy(info->entropy, entropy, strlen(entropy) + 1);
    for (uint32_t i = 0; i < segment->part_count; i++) {
        if (segment->parts[i].kind != NSDF_PART_BLOCKS)
            continue;
        info->blocks += segment->parts[i].desc.blocks.block_count;
        info->bones += segment->parts[i].desc.blocks.bone_count;
    }
    for (; part->kind != NSDF_PART_NETWORK; part++)
        if (part + 1 == segment->parts + segment->part_count)
            return;
    const nsdf_network_desc *desc = &part->desc.network;
    info->layers = desc->layer_count;
    for (uint32_t l = 0; l < desc->layer_count; l++)
        info->width = desc->layers[l].width > info->width ? desc->layers[l].width : info->width;
}

nsdf_status nsdf_get_segment_extent(const nsdf_decoder *decoder, uint32_t index, nsdf_segment_info *info) {
    if (!decoder || !info || index >= decoder->stream.header.segment_count)
        return NSDF_INVALID_ARGUMENT;
    const nsdf_index_entry *entry = &decoder->stream.entries[index];
    memset(info, 0, sizeof *info);
    info->start = nsdf_stream_frame_time(&decoder->stream, entry->first_frame);
    info->end = nsdf_stream_frame_time(&decoder->stream, entry->last_frame);
    info->fade = nsdf_stream_frame_time(&decoder->stream, entry->fade);
    info->smallest_piece = (double)entry->smallest_piece * decoder->stream.header.scale;
    info->offset = entry->offset;
    info->size = entry->size;
    return NSDF_OK;
}

nsdf_status nsdf_get_segment_info(nsdf_decoder *decoder, uint32_t index, nsdf_segment_info *info) {
    if (!decoder)
        return NSDF_INVALID_ARGUMENT;
    if (!info || index >= decoder->stream.header.segment_count)
        return nsdf_handle_invalid(decoder, "the info is NULL or there is no segment of that index");
    nsdf_segment *segment;
    nsdf_status status = nsdf_handle_segment(decoder, index, &segment);
    if (status != NSDF_OK)
        return status;
    status = nsdf_get_segment_extent(decoder, index, info);
    info->parameter_count = segment->parameter_count;
    fill_shape(segment, info);
    return status;
}

nsdf_status nsdf_get_memory_use(const nsdf_decoder *decoder, nsdf_memory_use *use) {
    if (!decoder || !use)
        return NSDF_INVALID_ARGUMENT;
    use->held = decoder->memory.used;
    use->most = decoder->memory.peak;
    return NSDF_OK;
}

nsdf_status nsdf_frame_time(const nsdf_decoder *decoder, uint32_t index, double *seconds) {
    if (!decoder || !seconds || index >= decoder->stream.header.frame_count)
        return NSDF_INVALID_ARGUMENT;
    *seconds = nsdf_stream_frame_time(&decoder->stream, index);
    return NSDF_OK;
}

nsdf_status nsdf_verify(nsdf_decoder *decoder) {
    if (!decoder)
        return NSDF_INVALID_ARGUMENT;
    nsdf_handle_trim(decoder, NULL); /* what is loaded already would not be read again */
    nsdf_status status = nsdf_stream_check_all(&decoder->stream, &decoder->memory, &decoder->error);
    for (uint32_t i = 0; status == NSDF_OK && i < decoder->stream.header.segment_count; i++) {
        nsdf_segment *segment;
        status = nsdf_handle_segment(decoder, i, &segment);
    }
    return status;
}

const char *nsdf_kernel_name(const nsdf_decoder *decoder) {
    return decoder ? decoder->field.kernels->name : "";
}

nsdf_status nsdf_prepare(nsdf_decoder *decoder, double t) {
    return decoder ? nsdf_handle_prepare(decoder, t) : NSDF_INVALID_ARGUMENT;
}
