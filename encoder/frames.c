#include "frames.h"

#include "mesh_check.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

nsdf_status nsdf_encoder_fail(nsdf_encoder_error *error, nsdf_status status, const char *format, ...) {
    if (!error)
        return status;
    va_list args;
    va_start(args, format);
    error->status = status;
    vsnprintf(error->message, sizeof error->message, format, args);
    va_end(args);
    return status;
}

void nsdf_frames_free(nsdf_frames *frames) {
    for (uint32_t i = 0; i < frames->count; i++) {
        nsdf_surface_free(&frames->frames[i].surface);
        free(frames->frames[i].outer.indices);
    }
    free(frames->frames);
    memset(frames, 0, sizeof *frames);
}

nsdf_frames nsdf_frames_pick(const nsdf_frames *all, uint32_t count, nsdf_frame *picked) {
    nsdf_frames some = *all;
    some.frames = picked;
    some.count = all->count < count ? all->count : count;
    for (uint32_t i = 0; i < some.count; i++)
        picked[i] = all->frames[(uint64_t)i * all->count / some.count];
    return some;
}

/* ---- Adding --------------------------------------------------------------------------------------------- */

static int grow(nsdf_frames *frames) {
    if (frames->count < frames->capacity)
        return 0;
    uint32_t capacity = frames->capacity ? 2 * frames->capacity : 64;
    nsdf_frame *f = realloc(frames->frames, capacity * sizeof *f);
    if (!f)
        return -1;
    frames->frames = f;
    frames->capacity = capacity;
    return 0;
}

/* Only vertices that a triangle uses belong to the surface. */
static void extend_box(nsdf_frames *frames, const nsdf_input_mesh *mesh) {
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++)
        for (int k = 0; k < 3; k++) {
            double x = mesh->positions[3 * (size_t)mesh->indices[i] + (size_t)k];
            if (x < frames->box_min[k])
                frames->box_min[k] = x;
            if (x > frames->box_max[k])
                frames->box_max[k] = x;
        }
}

nsdf_status nsdf_frames_add(nsdf_frames *frames, uint32_t number, const nsdf_input_mesh *mesh,
                            nsdf_encoder_error *error) {
    char name[32];
    snprintf(name, sizeof name, "frame %u", number);
    nsdf_status status = nsdf_check_mesh(name, mesh, error);
    if (status != NSDF_OK)
        return status;
    if (frames->count > 0 && number <= frames->frames[frames->count - 1].number)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "frame %u was added after frame %u", number,
                                 frames->frames[frames->count - 1].number);
    if (frames->count > 0 && number - frames->frames[0].number == UINT32_MAX)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "frame %u is too far from frame %u: a file counts to %u",
                                 number, frames->frames[0].number, UINT32_MAX);
    size_t positions = 3 * (size_t)mesh->vertex_count, indices = 3 * (size_t)mesh->triangle_count;
    nsdf_surface s = {malloc(positions * sizeof(float)), malloc(indices * sizeof(uint32_t)), mesh->vertex_count,
                      mesh->triangle_count};
    if (!s.positions || !s.indices || grow(frames) != 0) {
        nsdf_surface_free(&s);
        return nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory for frame %u", number);
    }
    if (frames->count == 0)
        for (int k = 0; k < 3; k++) {
            frames->origin[k] = mesh->positions[3 * (size_t)mesh->indices[0] + (size_t)k];
            frames->box_min[k] = frames->box_max[k] = frames->origin[k];
        }
    for (size_t i = 0; i < positions; i++)
        s.positions[i] = isfinite(mesh->positions[i]) ? (float)(mesh->positions[i] - frames->origin[i % 3]) : 0.0f;
    memcpy(s.indices, mesh->indices, indices * sizeof *s.indices);
    extend_box(frames, mesh);
    frames->triangles += mesh->triangle_count;
    frames->frames[frames->count++] = (nsdf_frame){.number = number, .surface = s};
    return NSDF_OK;
}

nsdf_status nsdf_frames_set_box(nsdf_frames *frames, const double box_min[3], const double box_max[3],
                                nsdf_encoder_error *error) {
    for (int k = 0; k < 3; k++)
        if (!(box_min[k] <= frames->box_min[k] && box_max[k] >= frames->box_max[k]))
            return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT,
                                     "the box goes from %g to %g along axis %d, the frames from %g to %g", box_min[k],
                                     box_max[k], k, frames->box_min[k], frames->box_max[k]);
    memcpy(frames->box_min, box_min, sizeof frames->box_min);
    memcpy(frames->box_max, box_max, sizeof frames->box_max);
    return NSDF_OK;
}

uint32_t nsdf_frames_span(const nsdf_frames *frames) {
    return frames->frames[frames->count - 1].number - frames->frames[0].number + 1;
}

uint32_t nsdf_frames_find(const nsdf_frames *frames, uint32_t number) {
    uint32_t i = 0;
    while (i < frames->count && frames->frames[i].number != number)
        i++;
    return i;
}

/* ---- Normalising ---------------------------------------------------------------------------------------- */

nsdf_status nsdf_frames_normalise(nsdf_frames *frames, double margin, nsdf_file_header *header,
                                  nsdf_encoder_error *error) {
    double diagonal = 0.0;
    for (int k = 0; k < 3; k++) {
        double side = frames->box_max[k] - frames->box_min[k];
        diagonal += side * side;
        header->box_min[k] = frames->box_min[k];
        header->box_max[k] = frames->box_max[k];
        header->centre[k] = 0.5 * (frames->box_min[k] + frames->box_max[k]);
    }
    diagonal = sqrt(diagonal);
    if (!(diagonal > 0.0) || !isfinite(diagonal))
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT,
                                 "the sequence has no extent: all its faces are in one point");
    header->scale = diagonal;
    for (int k = 0; k < 3; k++) {
        double half = 0.5 * (frames->box_max[k] - frames->box_min[k]) / diagonal + margin;
        header->domain_min[k] = (float)-half;
        header->domain_max[k] = (float)half;
    }
    for (uint32_t i = 0; i < frames->count; i++) {
        nsdf_surface *s = &frames->frames[i].surface;
        for (size_t j = 0; j < 3 * (size_t)s->vertex_count; j++)
            s->positions[j] =
                (float)(((double)s->positions[j] + frames->origin[j % 3] - header->centre[j % 3]) / diagonal);
    }
    return NSDF_OK;
}

/* ---- Repair --------------------------------------------------------------------------------------------- */

int nsdf_frame_repair(nsdf_frame *frame, const nsdf_repair_rule *rule) {
    memset(&frame->report, 0, sizeof frame->report);
    if (nsdf_repair_surface(&frame->surface, rule, &frame->filled, &frame->report) != 0)
        return -1;
    frame->sign = frame->report.open_bodies ? NSDF_SIGN_WINDING : NSDF_SIGN_PSEUDO_NORMAL;
    return 0;
}
