#include "container.h"

#include "network_write.h"
#include "quantise_model.h"

#include <stdlib.h>

int nsdf_code_segment(nsdf_model *model, const float *parameters, nsdf_coded_segment *segment) {
    size_t count = (size_t)model->parameter_count;
    int32_t *q = malloc(count * sizeof *q);
    float *decoded = malloc(count * sizeof *decoded);
    int result = -1;
    if (q && decoded && nsdf_quantise_parameters(model, parameters, q) == 0) {
        nsdf_write_segment_start(&segment->payload, 1);
        result = nsdf_write_network_part(&segment->payload, &model->desc, q);
        nsdf_round_parameters(model, parameters, decoded);
        segment->hash = nsdf_hash_floats(NSDF_HASH_START, decoded, count);
    }
    free(q);
    free(decoded);
    return segment->payload.failed ? -1 : result;
}

int nsdf_assemble_file(const nsdf_file_header *header, const nsdf_index_entry *entry, const nsdf_coded_segment *segment,
                       const nsdf_quality_record *quality, nsdf_buffer *file) {
    nsdf_buffer metadata = {NULL, 0, 0, 0};
    nsdf_index_entry only = *entry;
    only.first_frame = only.fade = 0;
    only.last_frame = header->frame_count - 1;
    only.parameter_hash = segment->hash;
    nsdf_write_metadata(&metadata, "encoder", "nsdf");
    nsdf_file_parts parts = {*header, &segment->payload, &only, &metadata, quality, NULL, 0};
    file->size = 0;
    int result = metadata.failed ? -1 : nsdf_write_file(file, &parts);
    nsdf_buffer_free(&metadata);
    return result;
}
