#include "nsdf/sequence.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "frame_numbers.h"
#include "input_error.h"
#include "input_file.h"
#include "sequence_paths.h"

struct nsdf_sequence {
    nsdf_path_list files;
    uint32_t *numbers;   /* [files.count], of their frames */
    nsdf_file_mesh mesh; /* of the last load */
};

static nsdf_status expand_inputs(nsdf_sequence *s, const char *const *inputs, size_t count, nsdf_encoder_error *error) {
    for (size_t i = 0; i < count; i++) {
        if (inputs[i] == NULL || inputs[i][0] == '\0') {
            return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT, "input %zu has no name", i + 1);
        }
        nsdf_status status = nsdf_expand_input(&s->files, inputs[i], error);
        if (status != NSDF_OK) {
            return status;
        }
    }
    if (s->files.timed_list != NULL && count > 1) {
        return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT, "%s: a list with times must be the only input",
                               nsdf_show_path(s->files.timed_list).text);
    }
    return s->files.count < UINT32_MAX ? NSDF_OK : nsdf_input_fail(error, NSDF_LIMIT, "too many frames");
}

void nsdf_sequence_options_init(nsdf_sequence_options *options) {
    if (options != NULL) {
        *options = (nsdf_sequence_options){sizeof *options, 25, 1, 0};
    }
}

static nsdf_status open_files(nsdf_sequence *s, const char *const *inputs, size_t count,
                              const nsdf_sequence_options *options, nsdf_encoder_error *error) {
    nsdf_status status = expand_inputs(s, inputs, count, error);
    if (status != NSDF_OK) {
        return status;
    }
    s->numbers = calloc(s->files.count, sizeof *s->numbers);
    return s->numbers != NULL ? nsdf_number_frames(&s->files, options, s->numbers, error) : nsdf_input_no_memory(error);
}

nsdf_status nsdf_sequence_open(nsdf_sequence **sequence, const char *const *inputs, size_t input_count,
                               const nsdf_sequence_options *options, nsdf_encoder_error *error) {
    nsdf_sequence_options defaults;
    nsdf_sequence_options_init(&defaults);
    const nsdf_sequence_options *o = options != NULL ? options : &defaults;
    if (sequence == NULL || inputs == NULL || input_count == 0) {
        return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT, "a sequence needs at least one input");
    }
    if (o->struct_size != sizeof *o || o->rate_num == 0 || o->rate_den == 0) {
        return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT,
                               "options without nsdf_sequence_options_init, or a frame rate of 0");
    }
    nsdf_sequence *s = calloc(1, sizeof *s);
    if (s == NULL) {
        return nsdf_input_no_memory(error);
    }
    nsdf_status status = open_files(s, inputs, input_count, o, error);
    if (status != NSDF_OK) {
        nsdf_sequence_close(&s);
        return status;
    }
    *sequence = s;
    return NSDF_OK;
}

void nsdf_sequence_close(nsdf_sequence **sequence) {
    if (sequence != NULL && *sequence != NULL) {
        nsdf_path_list_free(&(*sequence)->files);
        nsdf_file_mesh_free(&(*sequence)->mesh);
        free((*sequence)->numbers);
        free(*sequence);
        *sequence = NULL;
    }
}

/* ---- Frames ---- */

uint32_t nsdf_sequence_mesh_count(const nsdf_sequence *sequence) {
    return sequence != NULL ? (uint32_t)sequence->files.count : 0;
}

uint32_t nsdf_sequence_mesh_frame(const nsdf_sequence *sequence, uint32_t i) {
    return i < nsdf_sequence_mesh_count(sequence) ? sequence->numbers[i] : UINT32_MAX;
}

uint32_t nsdf_sequence_frame_count(const nsdf_sequence *sequence) {
    const uint32_t count = nsdf_sequence_mesh_count(sequence);
    return count > 0 ? sequence->numbers[count - 1] + 1 : 0;
}

static int compare_numbers(const void *a, const void *b) {
    const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

const char *nsdf_sequence_frame_path(const nsdf_sequence *sequence, uint32_t frame) {
    if (sequence == NULL) {
        return NULL;
    }
    const uint32_t *found =
        bsearch(&frame, sequence->numbers, sequence->files.count, sizeof *sequence->numbers, compare_numbers);
    return found != NULL ? sequence->files.items[found - sequence->numbers].path : NULL;
}

/* ---- Missing files ---- */

static void name_missing(char *text, size_t size, uint64_t first, uint64_t last) {
    const size_t used = strlen(text);
    const char *comma = used > 0 ? ", " : "";
    const unsigned long long a = first, b = last;
    if (used + 60 <= size) {
        snprintf(text + used, size - used, first == last ? "%s%llu" : "%s%llu-%llu", comma, a, b);
    } else if (used >= 4 && used + 8 < size && strcmp(text + used - 3, "...") != 0) {
        snprintf(text + used, size - used, ", ...");
    }
}

uint32_t nsdf_sequence_missing(const nsdf_sequence *sequence, char *text, size_t size) {
    uint32_t missing = 0;
    if (size > 0) {
        text[0] = '\0';
    }
    for (size_t i = 1; i < nsdf_sequence_mesh_count(sequence); i++) {
        uint64_t n[2];
        const nsdf_frame_file *files = sequence->files.items;
        const uint32_t gap = sequence->numbers[i] - sequence->numbers[i - 1];
        missing += gap - 1;
        if (gap > 1 && sequence->files.timed_list == NULL && nsdf_number_pair(files[i - 1].path, files[i].path, n)) {
            const uint64_t step = (n[1] - n[0]) / gap;
            name_missing(text, size, n[0] + step, n[1] - step);
        }
    }
    return missing;
}

/* ---- Meshes ---- */

nsdf_status nsdf_sequence_load(nsdf_sequence *sequence, uint32_t frame, nsdf_input_mesh *mesh,
                               nsdf_encoder_error *error) {
    const char *path = nsdf_sequence_frame_path(sequence, frame);
    if (path == NULL || mesh == NULL) {
        const uint32_t count = nsdf_sequence_frame_count(sequence);
        return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT,
                               frame < count ? "the sequence has %u frames, but frame %u has no mesh"
                                             : "the sequence has %u frames, there is no frame %u",
                               count, frame);
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
