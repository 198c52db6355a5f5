#include "nsdf/sequence.h"

#include <stdlib.h>

#include "input_error.h"
#include "input_file.h"
#include "sequence_paths.h"

struct nsdf_sequence {
    nsdf_path_list paths;
    nsdf_file_mesh mesh; /* of the last load */
};

static nsdf_status expand_inputs(nsdf_sequence *s, const char *const *inputs, size_t count, nsdf_encoder_error *error) {
    for (size_t i = 0; i < count; i++) {
        if (inputs[i] == NULL || inputs[i][0] == '\0') {
            return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT, "input %zu has no name", i + 1);
        }
        nsdf_status status = nsdf_expand_input(&s->paths, inputs[i], error);
        if (status != NSDF_OK) {
            return status;
        }
    }
    return s->paths.count <= UINT32_MAX ? NSDF_OK : nsdf_input_fail(error, NSDF_LIMIT, "too many frames");
}

nsdf_status nsdf_sequence_open(nsdf_sequence **sequence, const char *const *inputs, size_t input_count,
                               nsdf_encoder_error *error) {
    if (sequence == NULL || inputs == NULL || input_count == 0) {
        return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT, "a sequence needs at least one input");
    }
    nsdf_sequence *s = calloc(1, sizeof *s);
    if (s == NULL) {
        return nsdf_input_no_memory(error);
    }
    nsdf_status status = expand_inputs(s, inputs, input_count, error);
    if (status != NSDF_OK) {
        nsdf_sequence_close(&s);
        return status;
    }
    *sequence = s;
    return NSDF_OK;
}

void nsdf_sequence_close(nsdf_sequence **sequence) {
    if (sequence != NULL && *sequence != NULL) {
        nsdf_path_list_free(&(*sequence)->paths);
        nsdf_file_mesh_free(&(*sequence)->mesh);
        free(*sequence);
        *sequence = NULL;
    }
}

uint32_t nsdf_sequence_frame_count(const nsdf_sequence *sequence) {
    return sequence != NULL ? (uint32_t)sequence->paths.count : 0;
}

const char *nsdf_sequence_frame_path(const nsdf_sequence *sequence, uint32_t index) {
    return index < nsdf_sequence_frame_count(sequence) ? sequence->paths.items[index] : NULL;
}

nsdf_status nsdf_sequence_load(nsdf_sequence *sequence, uint32_t index, nsdf_input_mesh *mesh,
                               nsdf_encoder_error *error) {
    const char *path = nsdf_sequence_frame_path(sequence, index);
    if (path == NULL || mesh == NULL) {
        return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT, "the sequence has %u frames, there is no frame %u",
                               nsdf_sequence_frame_count(sequence), index);
    }
    nsdf_status status = nsdf_input_read_mesh(path, &sequence->mesh, error);
    if (status == NSDF_OK) {
        *mesh = (nsdf_input_mesh){.positions = sequence->mesh.positions,
                                  .indices = sequence->mesh.indices,
                                  .vertex_count = sequence->mesh.vertex_count,
                                  .triangle_count = sequence->mesh.triangle_count};
    }
    return status;
}
