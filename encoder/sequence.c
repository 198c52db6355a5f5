#include "nsdf/sequence.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "film_frames.h"
#include "frame_numbers.h"
#include "input_error.h"
#include "input_file.h"
#include "sequence_paths.h"

struct nsdf_sequence {
    nsdf_path_list files;
    uint32_t *numbers;    /* [files.count], of their frames */
    nsdf_gltf_film *film; /* of the one file, or NULL */
    uint32_t film_frames;
    uint32_t rate_num, rate_den;
    char note[256];
    bool is_shared;      /* all above is another handle's */
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
        *options = (nsdf_sequence_options){sizeof *options, 0, 0, 0};
    }
}

/* ---- Animations ---- */

static nsdf_status open_film(nsdf_sequence *s, const char *path, nsdf_encoder_error *error) {
    char *text = NULL, keys[120] = "";
    size_t size = 0;
    nsdf_status status = nsdf_input_read(path, &text, &size, error);
    if (status == NSDF_OK) {
        status = nsdf_gltf_film_open(&s->film, path, text, size, error);
        free(text);
    }
    if (status != NSDF_OK || s->film == NULL) {
        return status;
    }
    const nsdf_gltf_film_info info = nsdf_gltf_film_describe(s->film);
    status = nsdf_film_frames(&info, path, &s->rate_num, &s->rate_den, &s->film_frames, keys, sizeof keys, error);
    snprintf(s->note, sizeof s->note, "%.120s%s%s", info.note, *info.note != '\0' && *keys != '\0' ? "; " : "", keys);
    return status;
}

static nsdf_status load_film(nsdf_sequence *s, uint32_t frame, nsdf_encoder_error *error) {
    const double interval = (double)s->rate_den / s->rate_num;
    return nsdf_gltf_film_mesh(s->film, frame * interval, NSDF_FILM_SLACK * interval, &s->mesh, error);
}

/* ---- Opening ---- */

static bool is_gltf(const char *path) {
    return nsdf_input_has_suffix(path, ".glb") || nsdf_input_has_suffix(path, ".gltf");
}

static nsdf_status open_files(nsdf_sequence *s, const char *const *inputs, size_t count, int ignore_numbers,
                              nsdf_encoder_error *error) {
    nsdf_status status = expand_inputs(s, inputs, count, error);
    if (status == NSDF_OK && s->files.count == 1 && is_gltf(s->files.items[0].path)) {
        status = open_film(s, s->files.items[0].path, error);
    }
    if (status != NSDF_OK || s->film != NULL) {
        return status;
    }
    if (s->rate_num == 0) {
        s->rate_num = 25;
        s->rate_den = 1;
    }
    s->numbers = calloc(s->files.count, sizeof *s->numbers);
    const nsdf_sequence_options options = {sizeof options, s->rate_num, s->rate_den, ignore_numbers};
    return s->numbers != NULL ? nsdf_number_frames(&s->files, &options, s->numbers, error)
                              : nsdf_input_no_memory(error);
}

nsdf_status nsdf_sequence_open(nsdf_sequence **sequence, const char *const *inputs, size_t input_count,
                               const nsdf_sequence_options *options, nsdf_encoder_error *error) {
    nsdf_sequence_options defaults;
    nsdf_sequence_options_init(&defaults);
    const nsdf_sequence_options *o = options != NULL ? options : &defaults;
    if (sequence == NULL || inputs == NULL || input_count == 0) {
        return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT, "a sequence needs at least one input");
    }
    if (o->struct_size != sizeof *o || (o->rate_num == 0) != (o->rate_den == 0)) {
        return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT,
                               "options without nsdf_sequence_options_init, or half a frame rate");
    }
    nsdf_sequence *s = calloc(1, sizeof *s);
    if (s == NULL) {
        return nsdf_input_no_memory(error);
    }
    s->rate_num = o->rate_num;
    s->rate_den = o->rate_den;
    nsdf_status status = open_files(s, inputs, input_count, o->ignore_numbers, error);
    if (status != NSDF_OK) {
        nsdf_sequence_close(&s);
        return status;
    }
    *sequence = s;
    return NSDF_OK;
}

void nsdf_sequence_close(nsdf_sequence **sequence) {
    if (sequence == NULL || *sequence == NULL) {
        return;
    }
    nsdf_sequence *s = *sequence;
    if (!s->is_shared) {
        nsdf_path_list_free(&s->files);
        nsdf_gltf_film_free(s->film);
        free(s->numbers);
    }
    nsdf_file_mesh_free(&s->mesh);
    free(s);
    *sequence = NULL;
}

nsdf_status nsdf_sequence_share(const nsdf_sequence *sequence, nsdf_sequence **other, nsdf_encoder_error *error) {
    if (sequence == NULL || other == NULL) {
        return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given");
    }
    nsdf_sequence *s = malloc(sizeof *s);
    if (s == NULL) {
        return nsdf_input_no_memory(error);
    }
    *s = *sequence;
    s->is_shared = true;
    memset(&s->mesh, 0, sizeof s->mesh);
    *other = s;
    return NSDF_OK;
}

/* ---- Frames ---- */

uint32_t nsdf_sequence_mesh_count(const nsdf_sequence *sequence) {
    return sequence == NULL ? 0 : sequence->film != NULL ? sequence->film_frames : (uint32_t)sequence->files.count;
}

uint32_t nsdf_sequence_mesh_frame(const nsdf_sequence *sequence, uint32_t i) {
    if (i >= nsdf_sequence_mesh_count(sequence)) {
        return UINT32_MAX;
    }
    return sequence->film != NULL ? i : sequence->numbers[i];
}

uint32_t nsdf_sequence_frame_count(const nsdf_sequence *sequence) {
    const uint32_t count = nsdf_sequence_mesh_count(sequence);
    return count > 0 ? nsdf_sequence_mesh_frame(sequence, count - 1) + 1 : 0;
}

void nsdf_sequence_rate(const nsdf_sequence *sequence, uint32_t *rate_num, uint32_t *rate_den) {
    *rate_num = sequence->rate_num;
    *rate_den = sequence->rate_den;
}

const char *nsdf_sequence_note(const nsdf_sequence *sequence) {
    return sequence->note;
}

static int compare_numbers(const void *a, const void *b) {
    const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

const char *nsdf_sequence_frame_path(const nsdf_sequence *sequence, uint32_t frame) {
    if (sequence == NULL) {
        return NULL;
    }
    if (sequence->film != NULL) {
        return frame < sequence->film_frames ? sequence->files.items[0].path : NULL;
    }
    const uint32_t *found =
        bsearch(&frame, sequence->numbers, sequence->files.count, sizeof *sequence->numbers, compare_numbers);
    return found != NULL ? sequence->files.items[found - sequence->numbers].path : NULL;
}

void nsdf_sequence_name_frame(const nsdf_sequence *sequence, uint32_t frame, char *text, size_t size) {
    const char *path = nsdf_sequence_frame_path(sequence, frame);
    if (path != NULL && sequence->film != NULL) {
        snprintf(text, size, "%s, frame %u", path, frame);
    } else if (size > 0) {
        snprintf(text, size, "%s", path != NULL ? path : "");
    }
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
    if (sequence == NULL || sequence->film != NULL) {
        return 0;
    }
    for (size_t i = 1; i < sequence->files.count; i++) {
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
    nsdf_status status =
        sequence->film != NULL ? load_film(sequence, frame, error) : nsdf_input_read_mesh(path, &sequence->mesh, error);
    if (status == NSDF_OK) {
        *mesh = (nsdf_input_mesh){.positions = sequence->mesh.positions,
                                  .indices = sequence->mesh.indices,
                                  .vertex_count = sequence->mesh.vertex_count,
                                  .triangle_count = sequence->mesh.triangle_count};
    }
    return status;
}
