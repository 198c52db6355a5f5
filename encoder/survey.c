/* Looking over a sequence frame by frame (nsdf/survey.h). */
#include "survey.h"

#include "container_read.h"
#include "frames.h"
#include "mesh_check.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LEAST_AUTO_FRAMES = 16 };

nsdf_status nsdf_survey_create(nsdf_survey **survey, nsdf_encoder_error *error) {
    if (!survey)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given");
    nsdf_survey *s = calloc(1, sizeof *s);
    if (!s)
        return nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory");
    *survey = s;
    return NSDF_OK;
}

void nsdf_survey_close(nsdf_survey **survey) {
    if (!survey || !*survey)
        return;
    free((*survey)->frames);
    free((*survey)->spans);
    free(*survey);
    *survey = NULL;
}

/* ---- Frames ------------------------------------------------------------------------------------------------- */

static void find_box(const nsdf_input_mesh *mesh, double box_min[3], double box_max[3]) {
    for (size_t k = 0; k < 3; k++) {
        box_min[k] = INFINITY;
        box_max[k] = -INFINITY;
    }
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++)
        for (size_t k = 0; k < 3; k++) {
            const double x = mesh->positions[3 * (size_t)mesh->indices[i] + k];
            box_min[k] = fmin(box_min[k], x);
            box_max[k] = fmax(box_max[k], x);
        }
}

/* Sums over the triangles of area, of area times centre, and of area times products of the centre's coordinates (xx,
 * yy, zz, xy, yz, zx), relative to the first vertex. */
static void sum_moments(const nsdf_input_mesh *mesh, double sums[10]) {
    const double *origin = mesh->positions + 3 * (size_t)mesh->indices[0];
    memset(sums, 0, 10 * sizeof *sums);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const double *p[3];
        double u[3], v[3], centre[3];
        for (size_t k = 0; k < 3; k++)
            p[k] = mesh->positions + 3 * (size_t)mesh->indices[3 * t + k];
        for (size_t k = 0; k < 3; k++) {
            u[k] = p[1][k] - p[0][k];
            v[k] = p[2][k] - p[0][k];
            centre[k] = (p[0][k] + p[1][k] + p[2][k]) / 3.0 - origin[k];
        }
        const double n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
        const double area = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        sums[0] += area;
        for (size_t k = 0; k < 3; k++) {
            sums[1 + k] += area * centre[k];
            sums[4 + k] += area * centre[k] * centre[k];
            sums[7 + k] += area * centre[k] * centre[(k + 1) % 3];
        }
    }
}

static void find_moments(const nsdf_input_mesh *mesh, double moments[NSDF_MOMENTS]) {
    const double *origin = mesh->positions + 3 * (size_t)mesh->indices[0];
    double sums[10], mean[3];
    sum_moments(mesh, sums);
    const double area = sums[0] > 0.0 ? sums[0] : 1.0;
    for (size_t k = 0; k < 3; k++) {
        mean[k] = sums[1 + k] / area;
        moments[k] = origin[k] + mean[k];
    }
    for (size_t k = 0; k < 3; k++) {
        const size_t next = (k + 1) % 3;
        const double own = sums[4 + k] / area - mean[k] * mean[k];
        const double other = sums[4 + next] / area - mean[next] * mean[next];
        const double mixed = sums[7 + k] / area - mean[k] * mean[next];
        moments[3 + k] = sqrt(fmax(own, 0.0));
        moments[6 + k] = sqrt(fmax(0.5 * (own + other) + mixed, 0.0)); /* along the diagonal of the two axes */
    }
}

static int grow(nsdf_survey *s) {
    if (s->count < s->capacity)
        return 0;
    const uint32_t capacity = s->capacity < 64 ? 64 : 2 * s->capacity;
    nsdf_seen_frame *frames = realloc(s->frames, capacity * sizeof *frames);
    if (!frames)
        return -1;
    s->frames = frames;
    s->capacity = capacity;
    return 0;
}

static uint64_t hash_mesh(const nsdf_input_mesh *mesh) {
    uint64_t hash = nsdf_hash64(NSDF_HASH_START, mesh->positions, 3 * (size_t)mesh->vertex_count * sizeof(double));
    return nsdf_hash64(hash, mesh->indices, 3 * (size_t)mesh->triangle_count * sizeof(uint32_t));
}

nsdf_status nsdf_survey_look(uint32_t frame, const nsdf_input_mesh *mesh, nsdf_frame_look *look,
                             nsdf_encoder_error *error) {
    char name[32];
    if (!mesh || !look)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given");
    snprintf(name, sizeof name, "frame %u", frame);
    const nsdf_status status = nsdf_check_mesh(name, mesh, error);
    if (status != NSDF_OK)
        return status;
    look->triangles = mesh->triangle_count;
    look->euler = 2 * (int64_t)mesh->vertex_count - mesh->triangle_count;
    look->hash = hash_mesh(mesh);
    find_moments(mesh, look->moments);
    find_box(mesh, look->box_min, look->box_max);
    return NSDF_OK;
}

static void extend_box(nsdf_survey *s, const nsdf_frame_look *look) {
    for (int k = 0; k < 3; k++) {
        s->box_min[k] = s->count > 0 ? fmin(s->box_min[k], look->box_min[k]) : look->box_min[k];
        s->box_max[k] = s->count > 0 ? fmax(s->box_max[k], look->box_max[k]) : look->box_max[k];
    }
}

nsdf_status nsdf_survey_add_look(nsdf_survey *survey, uint32_t frame, const nsdf_frame_look *look,
                                 nsdf_encoder_error *error) {
    if (!survey || !look)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given");
    if (survey->count > 0 && frame <= survey->frames[survey->count - 1].number)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "frame %u was added after frame %u", frame,
                                 survey->frames[survey->count - 1].number);
    if (survey->count == INT32_MAX || grow(survey) != 0)
        return nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory for frame %u", frame);
    extend_box(survey, look);
    nsdf_seen_frame *seen = &survey->frames[survey->count++];
    *seen = (nsdf_seen_frame){frame, look->triangles, look->euler, look->hash, {0.0}};
    memcpy(seen->moments, look->moments, sizeof seen->moments);
    return NSDF_OK;
}

nsdf_status nsdf_survey_add(nsdf_survey *survey, uint32_t frame, const nsdf_input_mesh *mesh,
                            nsdf_encoder_error *error) {
    nsdf_frame_look look;
    if (!survey)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given");
    const nsdf_status status = nsdf_survey_look(frame, mesh, &look, error);
    return status == NSDF_OK ? nsdf_survey_add_look(survey, frame, &look, error) : status;
}

uint32_t nsdf_survey_frame_count(const nsdf_survey *survey) {
    return survey ? survey->count : 0;
}

nsdf_status nsdf_survey_box(const nsdf_survey *survey, double box_min[3], double box_max[3]) {
    if (!survey || survey->count == 0 || !box_min || !box_max)
        return NSDF_INVALID_ARGUMENT;
    memcpy(box_min, survey->box_min, sizeof survey->box_min);
    memcpy(box_max, survey->box_max, sizeof survey->box_max);
    return NSDF_OK;
}

uint64_t nsdf_survey_hash(const nsdf_survey *survey, uint32_t first, uint32_t count) {
    uint64_t hash = NSDF_HASH_START;
    for (uint32_t i = first; survey && i < survey->count && i - first < count; i++) {
        const uint64_t words[2] = {survey->frames[i].number, survey->frames[i].hash};
        hash = nsdf_hash64(hash, words, sizeof words);
    }
    return hash;
}

uint64_t nsdf_survey_span_hash(const nsdf_survey *survey, const nsdf_span *span, const nsdf_encoder_options *options) {
    if (!survey || !span)
        return 0;
    const uint32_t first = span->first - span->lead;
    const uint64_t words[4] = {nsdf_encoder_options_hash(options),
                               nsdf_survey_hash(survey, first, span->last + span->trail - first + 1), span->lead,
                               span->trail};
    uint64_t hash = nsdf_hash64(NSDF_HASH_START, words, sizeof words);
    hash = nsdf_hash64(hash, survey->box_min, sizeof survey->box_min);
    return nsdf_hash64(hash, survey->box_max, sizeof survey->box_max);
}

/* ---- The plan ----------------------------------------------------------------------------------------------- */

void nsdf_plan_options_init(nsdf_plan_options *options) {
    const nsdf_plan_options defaults = {sizeof *options, 0, 2};
    if (options)
        *options = defaults;
}

static uint32_t most_frames(const nsdf_survey *s, uint32_t asked) {
    uint64_t triangles = 0;
    if (asked > 0)
        return asked;
    for (uint32_t i = 0; i < s->count; i++)
        triangles += s->frames[i].triangles;
    const double fits = (double)NSDF_SEGMENT_TRIANGLES * s->count / (double)triangles;
    return fits >= NSDF_SEGMENT_FRAMES ? NSDF_SEGMENT_FRAMES
           : fits <= LEAST_AUTO_FRAMES ? LEAST_AUTO_FRAMES
                                       : (uint32_t)fits;
}

/* As much of the overlap as the neighbour has, and at most half of it, so that cross-fades do not meet. */
static uint32_t reach(const nsdf_span *neighbour, uint32_t overlap) {
    const uint32_t half = (neighbour->last - neighbour->first) / 2;
    return overlap < half ? overlap : half;
}

static void reach_over(nsdf_span *spans, uint32_t count, uint32_t overlap) {
    for (uint32_t i = 0; i + 1 < count; i++) {
        const uint32_t before = reach(&spans[i], overlap), behind = reach(&spans[i + 1], overlap);
        spans[i].trail = spans[i + 1].lead = before < behind ? before : behind;
    }
}

nsdf_status nsdf_survey_plan(nsdf_survey *survey, const nsdf_plan_options *options, const nsdf_span **spans,
                             uint32_t *count, nsdf_encoder_error *error) {
    nsdf_plan_options defaults;
    nsdf_plan_options_init(&defaults);
    const nsdf_plan_options *o = options ? options : &defaults;
    if (!survey || !spans || !count)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given");
    if (survey->count == 0 || o->struct_size != sizeof *o || o->most_frames == 1)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT,
                                 "no frames, options without nsdf_plan_options_init, or segments of a single frame");
    uint32_t *cuts = NULL;
    const uint32_t segments = nsdf_plan_cuts(survey->frames, survey->count, most_frames(survey, o->most_frames), &cuts);
    nsdf_span *planned = segments > 0 ? calloc(segments, sizeof *planned) : NULL;
    for (uint32_t i = 0; planned && i < segments; i++) {
        planned[i].first = i > 0 ? cuts[i - 1] : 0;
        planned[i].last = cuts[i];
    }
    free(cuts);
    if (!planned)
        return nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory");
    reach_over(planned, segments, o->overlap);
    free(survey->spans);
    survey->spans = planned;
    *spans = planned;
    *count = segments;
    return NSDF_OK;
}
