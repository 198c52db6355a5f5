#include "cmp_frames.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli_util.h"

/* ---- Opening -------------------------------------------------------------------------------------------- */

/* Frames of meshes have the rate of the .nsdf file that they are compared with. */
static int open_meshes(nsdf_sequence **sequence, const cmp_frames *frames, const cmp_options *o, const char *input) {
    nsdf_sequence_options options;
    nsdf_encoder_error error;
    nsdf_info info;
    nsdf_sequence_options_init(&options);
    options.ignore_numbers = o->ignore_numbers;
    if (o->rate_num) {
        options.rate_num = o->rate_num;
        options.rate_den = o->rate_den;
    } else if (frames->decoder && nsdf_get_info(frames->decoder, &info) == NSDF_OK) {
        options.rate_num = info.rate_num;
        options.rate_den = info.rate_den;
    }
    if (nsdf_sequence_open(sequence, &input, 1, &options, &error) == NSDF_OK) {
        if (*nsdf_sequence_note(*sequence))
            nsdf_cli_warn("%s: %s", input, nsdf_sequence_note(*sequence));
        return NSDF_CLI_SUCCESS;
    }
    nsdf_cli_error("%s", error.message);
    return NSDF_CLI_FAILURE;
}

static int open_nsdf(cmp_frames *frames, const cmp_options *o) {
    nsdf_decoder_options options;
    nsdf_error error;
    nsdf_decoder_options_init(&options);
    options.threads = o->compare.threads;
    options.check_all = 1;
    if (o->resolution > options.max_resolution)
        options.max_resolution = o->resolution;
    if (nsdf_open_file(&frames->decoder, o->decoded, &options, &error) == NSDF_OK)
        return NSDF_CLI_SUCCESS;
    nsdf_cli_nsdf_error(o->decoded, &error);
    return NSDF_CLI_FAILURE;
}

static uint32_t decoded_count(const cmp_frames *frames) {
    nsdf_info info;
    if (frames->decoded)
        return nsdf_sequence_frame_count(frames->decoded);
    return nsdf_get_info(frames->decoder, &info) == NSDF_OK ? info.frame_count : 0;
}

/* How many frames there are to choose from; 0 after an error. */
static uint32_t common_count(const cmp_frames *frames, const cmp_options *o) {
    const uint32_t reference = nsdf_sequence_frame_count(frames->reference), decoded = decoded_count(frames);
    const uint32_t least = reference < decoded ? reference : decoded;
    if (reference == decoded)
        return reference;
    if (!o->common) {
        nsdf_cli_error("%s has %lu frames, %s has %lu: expected equal numbers (--common compares the first %lu)",
                       o->reference, (unsigned long)reference, o->decoded, (unsigned long)decoded,
                       (unsigned long)least);
        return 0;
    }
    nsdf_cli_warn("%s has %lu frames, %s has %lu: the first %lu are compared", o->reference, (unsigned long)reference,
                  o->decoded, (unsigned long)decoded, (unsigned long)least);
    return least;
}

/* Of the first `count` frames those that the reference has a mesh of: the decoded side must have them too. */
static int choose(cmp_frames *frames, const cmp_options *o, uint32_t count) {
    nsdf_cli_list *list = &frames->chosen;
    uint32_t kept = 0;
    const int result =
        o->frames ? nsdf_cli_list_parse(list, "--frames", o->frames, count) : nsdf_cli_list_all(list, count);
    if (result != NSDF_CLI_SUCCESS)
        return result;
    nsdf_cli_list_sort(list);
    for (uint32_t i = 0; i < list->count; i++) {
        const uint32_t frame = list->numbers[i];
        const int there = !frames->decoded || nsdf_sequence_frame_path(frames->decoded, frame) != NULL;
        if (!nsdf_sequence_frame_path(frames->reference, frame) || (!there && o->common))
            continue;
        if (!there) {
            nsdf_cli_error("%s has no frame %lu, %s has one (--common compares those that both have)", o->decoded,
                           (unsigned long)frame, o->reference);
            return NSDF_CLI_FAILURE;
        }
        list->numbers[kept++] = frame;
    }
    list->count = kept;
    return kept > 0 ? result : nsdf_cli_usage_error("none of the frames to compare has a mesh in %s", o->reference);
}

int cmp_frames_open(cmp_frames *frames, const cmp_options *o) {
    memset(frames, 0, sizeof *frames);
    for (int k = 0; k < 3; k++) {
        frames->box_min[k] = INFINITY;
        frames->box_max[k] = -INFINITY;
    }
    int result = cmp_is_nsdf(o->decoded) ? open_nsdf(frames, o) : NSDF_CLI_SUCCESS;
    if (result == NSDF_CLI_SUCCESS)
        result = open_meshes(&frames->reference, frames, o, o->reference);
    if (result == NSDF_CLI_SUCCESS && !frames->decoder)
        result = open_meshes(&frames->decoded, frames, o, o->decoded);
    const uint32_t count = result == NSDF_CLI_SUCCESS ? common_count(frames, o) : 0;
    return count > 0 ? choose(frames, o, count) : NSDF_CLI_FAILURE;
}

void cmp_frames_close(cmp_frames *frames) {
    nsdf_sequence_close(&frames->reference);
    nsdf_sequence_close(&frames->decoded);
    nsdf_mesh_free(&frames->mesh);
    nsdf_close(&frames->decoder);
    nsdf_cli_list_free(&frames->chosen);
    nsdf_repaired_mesh_free(&frames->repaired);
    free(frames->positions);
    frames->positions = NULL;
}

/* ---- Loading -------------------------------------------------------------------------------------------- */

static void extend_box(cmp_frames *frames, const nsdf_input_mesh *mesh) {
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++)
        for (int k = 0; k < 3; k++) {
            const double x = mesh->positions[3 * (size_t)mesh->indices[i] + (size_t)k];
            frames->box_min[k] = fmin(frames->box_min[k], x);
            frames->box_max[k] = fmax(frames->box_max[k], x);
        }
}

static int load_meshes(nsdf_sequence *sequence, uint32_t frame, nsdf_input_mesh *mesh) {
    nsdf_encoder_error error;
    if (nsdf_sequence_load(sequence, frame, mesh, &error) == NSDF_OK)
        return NSDF_CLI_SUCCESS;
    nsdf_cli_error("%s", error.message);
    return NSDF_CLI_FAILURE;
}

static int copy_positions(cmp_frames *frames, const nsdf_mesh_view *view) {
    const size_t count = 3 * (size_t)view->vertex_count;
    if (count > frames->capacity) {
        double *grown = realloc(frames->positions, count * sizeof *grown);
        if (!grown) {
            nsdf_cli_error("out of memory");
            return NSDF_CLI_FAILURE;
        }
        frames->positions = grown;
        frames->capacity = count;
    }
    for (size_t i = 0; i < count; i++)
        frames->positions[i] = (double)view->positions[i];
    return NSDF_CLI_SUCCESS;
}

static int report_decoder(const cmp_frames *frames, const cmp_options *o, nsdf_status status) {
    nsdf_error error;
    nsdf_cli_get_error(frames->decoder, status, &error);
    if (status == NSDF_CANCELLED)
        nsdf_cli_error("interrupted: nothing was written");
    else
        nsdf_cli_nsdf_error(o->decoded, &error);
    return NSDF_CLI_FAILURE;
}

static int decode(cmp_frames *frames, const cmp_options *o, uint32_t frame, nsdf_input_mesh *mesh) {
    nsdf_mesh_options options;
    nsdf_mesh_view view;
    double seconds = 0.0;
    nsdf_mesh_options_init(&options);
    options.resolution = o->resolution;
    options.normals = 0;
    options.cancel = nsdf_cli_is_interrupted;
    nsdf_status status = nsdf_frame_time(frames->decoder, frame, &seconds);
    if (status == NSDF_OK)
        status = nsdf_extract_mesh(frames->decoder, seconds, &options, &frames->mesh);
    if (status == NSDF_OK)
        status = nsdf_mesh_get_view(frames->mesh, &view);
    if (status != NSDF_OK)
        return report_decoder(frames, o, status);
    const int result = copy_positions(frames, &view);
    *mesh = (nsdf_input_mesh){frames->positions, view.indices, view.vertex_count, view.triangle_count};
    return result;
}

void cmp_frames_name_decoded(const cmp_frames *frames, const cmp_options *o, uint32_t i, char *name, size_t size) {
    const uint32_t frame = frames->chosen.numbers[i];
    if (frames->decoded)
        nsdf_sequence_name_frame(frames->decoded, frame, name, size);
    else
        snprintf(name, size, "%s, frame %lu", o->decoded, (unsigned long)frame);
}

/* That of the box that the encoder had, or of the reference's. */
static int find_diagonal(cmp_frames *frames) {
    nsdf_info info;
    double square = 0.0;
    if (frames->decoder && nsdf_get_info(frames->decoder, &info) == NSDF_OK) {
        frames->diagonal = info.diagonal;
        return NSDF_CLI_SUCCESS;
    }
    const int result = cmp_frames_read_box(frames);
    for (int k = 0; k < 3; k++)
        square += (frames->box_max[k] - frames->box_min[k]) * (frames->box_max[k] - frames->box_min[k]);
    frames->diagonal = sqrt(square);
    return result;
}

/* Puts the mesh that is fitted in place of the reference's. */
static int repair(cmp_frames *frames, const cmp_options *o, uint32_t frame, nsdf_input_mesh *mesh) {
    nsdf_encoder_error error;
    char name[400];
    nsdf_repaired_mesh_free(&frames->repaired);
    const nsdf_status status = nsdf_encoder_repair_mesh(mesh, o->shell == CMP_SHELL_GIVEN ? o->thickness : 0.0,
                                                        frames->diagonal, &frames->repaired, &error);
    if (status != NSDF_OK) {
        nsdf_sequence_name_frame(frames->reference, frame, name, sizeof name);
        nsdf_cli_error("%s: %s", name, error.message);
        return NSDF_CLI_FAILURE;
    }
    *mesh = (nsdf_input_mesh){frames->repaired.positions, frames->repaired.indices, frames->repaired.vertex_count,
                              frames->repaired.triangle_count};
    return NSDF_CLI_SUCCESS;
}

int cmp_frames_load(cmp_frames *frames, const cmp_options *o, uint32_t i, nsdf_input_mesh *reference,
                    nsdf_input_mesh *decoded) {
    const uint32_t frame = frames->chosen.numbers[i];
    int result = o->shell && !(frames->diagonal > 0.0) ? find_diagonal(frames) : NSDF_CLI_SUCCESS;
    if (result == NSDF_CLI_SUCCESS)
        result = load_meshes(frames->reference, frame, reference);
    if (result == NSDF_CLI_SUCCESS) {
        extend_box(frames, reference);
        if (o->shell)
            result = repair(frames, o, frame, reference);
    }
    if (result == NSDF_CLI_SUCCESS)
        result = frames->decoded ? load_meshes(frames->decoded, frame, decoded) : decode(frames, o, frame, decoded);
    return result;
}

static int add_to_box(cmp_frames *frames, uint32_t frame) {
    nsdf_input_mesh mesh;
    if (load_meshes(frames->reference, frame, &mesh) != NSDF_CLI_SUCCESS)
        return NSDF_CLI_FAILURE;
    if (nsdf_cli_interrupts() > 0) {
        nsdf_cli_error("interrupted: nothing was written");
        return NSDF_CLI_FAILURE;
    }
    extend_box(frames, &mesh);
    return NSDF_CLI_SUCCESS;
}

int cmp_frames_read_box(cmp_frames *frames) {
    int result = NSDF_CLI_SUCCESS;
    for (uint32_t i = 0; i < nsdf_sequence_mesh_count(frames->reference) && result == NSDF_CLI_SUCCESS; i++)
        result = add_to_box(frames, nsdf_sequence_mesh_frame(frames->reference, i));
    return result;
}

int cmp_frames_finish_box(cmp_frames *frames) {
    int result = NSDF_CLI_SUCCESS;
    uint32_t next = 0; /* chosen numbers ascend */
    for (uint32_t i = 0; i < nsdf_sequence_mesh_count(frames->reference) && result == NSDF_CLI_SUCCESS; i++) {
        const uint32_t frame = nsdf_sequence_mesh_frame(frames->reference, i);
        if (next < frames->chosen.count && frames->chosen.numbers[next] == frame)
            next++;
        else
            result = add_to_box(frames, frame);
    }
    return result;
}
