/* nsdf_evaluate: world units in and out, points outside the domain, many points over all workers. */
#include "handle.h"
#include "status.h"

#include <math.h>

/* Points of a task: enough to make the task's start cheap, few enough to share small calls among workers. */
enum { TASK_POINTS = 32 * NSDF_TILE };

typedef struct request {
    nsdf_segment_field *field;
    const nsdf_file_header *header;
    const float *xyz;
    size_t count;
    float *distance, *gradient;
} request;

/* Up to NSDF_TILE points in normalised units: the nearest point of the domain and how far beyond it they lie. */
typedef struct point_tile {
    float position[3][NSDF_TILE], value[NSDF_TILE], slope[3][NSDF_TILE];
    double beyond[3][NSDF_TILE];
} point_tile;

/* A coordinate that is not a number makes `beyond` not a number, and with it the results. */
static void normalise(const nsdf_file_header *header, const float *xyz, size_t count, point_tile *tile) {
    for (int axis = 0; axis < 3; axis++) {
        const double low = (double)header->domain_min[axis], high = (double)header->domain_max[axis];
        for (size_t i = 0; i < count; i++) {
            const double x = ((double)xyz[3 * i + (size_t)axis] - header->centre[axis]) / header->scale;
            const double inside = x < low ? low : x > high ? high : x;
            tile->position[axis][i] = (float)inside;
            tile->beyond[axis][i] = x - inside;
        }
    }
}

/* One point's results.  Outside the domain: max(f, 0) at the nearest point of the domain plus the distance d to it;
 * that point moves along the axes that were not clamped only. */
static void finish_point(const point_tile *tile, size_t i, double scale, float *distance, float *gradient) {
    const double b[3] = {tile->beyond[0][i], tile->beyond[1][i], tile->beyond[2][i]};
    const double squared = b[0] * b[0] + b[1] * b[1] + b[2] * b[2];
    const float value = tile->value[i];
    if (squared == 0.0) {
        *distance = (float)((double)value * scale);
        for (int axis = 0; gradient && axis < 3; axis++)
            gradient[axis] = tile->slope[axis][i];
        return;
    }
    const double d = sqrt(squared);
    const int grows = value > 0.0f;
    *distance = (float)(((grows ? (double)value : 0.0) + d) * scale);
    for (int axis = 0; gradient && axis < 3; axis++)
        gradient[axis] = (float)(b[axis] / d) + (grows && b[axis] == 0.0 ? tile->slope[axis][i] : 0.0f);
}

static void evaluate_tile(const request *r, size_t from, size_t count, uint32_t worker) {
    point_tile tile;
    const float *const position[3] = {tile.position[0], tile.position[1], tile.position[2]};
    float *const slope[3] = {r->gradient ? tile.slope[0] : NULL, tile.slope[1], tile.slope[2]};
    normalise(r->header, r->xyz + 3 * from, count, &tile);
    nsdf_segment_field_evaluate(r->field, worker, count, position, tile.value, slope);
    for (size_t i = 0; i < count; i++)
        finish_point(&tile, i, r->header->scale, r->distance + from + i,
                     r->gradient ? r->gradient + 3 * (from + i) : NULL);
}

static void evaluate_task(void *data, uint32_t index, uint32_t worker) {
    const request *r = data;
    const size_t start = (size_t)index * TASK_POINTS;
    const size_t end = r->count - start < TASK_POINTS ? r->count : start + TASK_POINTS;
    for (size_t from = start; from < end; from += NSDF_TILE)
        evaluate_tile(r, from, end - from < NSDF_TILE ? end - from : NSDF_TILE, worker);
}

nsdf_status nsdf_evaluate(nsdf_decoder *decoder, double t, const float *xyz, size_t count, float *distance,
                          float *gradient) {
    if (!decoder)
        return NSDF_INVALID_ARGUMENT;
    if (count > 0 && (!xyz || !distance))
        return nsdf_handle_invalid(decoder, "the points or the distances are NULL");
    if (count > SIZE_MAX / (3 * sizeof(float)) || count / TASK_POINTS >= UINT32_MAX)
        return nsdf_handle_invalid(decoder, "the count of points is larger than memory can hold");
    nsdf_status status = nsdf_handle_prepare(decoder, t);
    if (status != NSDF_OK || count == 0)
        return status;
    request r = {&decoder->field, &decoder->stream.header, xyz, count, distance, gradient};
    nsdf_tasks_run(decoder->tasks, (uint32_t)((count + TASK_POINTS - 1) / TASK_POINTS), evaluate_task, &r);
    return NSDF_OK;
}
