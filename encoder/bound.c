#include "bound.h"

#include "fit.h"
#include "nsdf/export.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Cells along the longest side of the grid on which the bound is measured and checked. */
enum { BOUND_RESOLUTION = 64, LARGEST_CUBE = 32 };
/* Where verification follows, so many frames, or the third of more, stand for all: the field changes little from one to
 * the next. */
enum { MEASURED_FRAMES = 64, MEASURED_OF = 3 };
/* What was measured for a network is sure by itself; extraction is held against it on a few of the frames. */
enum { CHECKED_FRAMES = 12 };
static const double bound_margin = 1.15, lowest_bound = 1.0, growth = 1.25;
/* Away from its balls the size of a field of blocks is known; within them this is generous. */
static const double safe_for_blocks = 4.0;

typedef struct {
    uint32_t nodes[3];
    double h, origin[3]; /* normalised */
    float *xyz, *value;  /* world points, and normalised values, of all nodes */
    size_t count;
} grid;

static int create_grid(grid *g, const nsdf_file_header *header) {
    double longest = 0.0;
    for (int k = 0; k < 3; k++)
        longest = fmax(longest, (double)(header->domain_max[k] - header->domain_min[k]));
    g->h = longest / BOUND_RESOLUTION;
    g->count = 1;
    for (int k = 0; k < 3; k++) {
        double side = (double)(header->domain_max[k] - header->domain_min[k]);
        uint32_t cells = (uint32_t)ceil(side / g->h - 1e-6);
        g->nodes[k] = (cells < 1 ? 1 : cells) + 1;
        g->origin[k] = (double)header->domain_min[k];
        g->count *= g->nodes[k];
    }
    g->xyz = malloc(3 * g->count * sizeof(float));
    g->value = malloc(g->count * sizeof(float));
    if (!g->xyz || !g->value)
        return -1;
    for (size_t i = 0; i < g->count; i++) {
        size_t at[3] = {i % g->nodes[0], i / g->nodes[0] % g->nodes[1], i / g->nodes[0] / g->nodes[1]};
        for (int k = 0; k < 3; k++) {
            double x = fmin(g->origin[k] + (double)at[k] * g->h, (double)header->domain_max[k]);
            g->xyz[3 * i + (size_t)k] = (float)(x * header->scale + header->centre[k]);
        }
    }
    return 0;
}

static void free_grid(grid *g) {
    free(g->xyz);
    free(g->value);
}

/* Whether the cube of `size` cells at (x, y, z) has nodes of both signs. */
static int sign_changes(const grid *g, const uint32_t at[3], uint32_t size) {
    int negative = 0, positive = 0;
    uint32_t end[3];
    for (int k = 0; k < 3; k++)
        end[k] = at[k] + size < g->nodes[k] ? at[k] + size : g->nodes[k] - 1;
    for (uint32_t z = at[2]; z <= end[2]; z++)
        for (uint32_t y = at[1]; y <= end[1]; y++) {
            const float *row = g->value + ((size_t)z * g->nodes[1] + y) * g->nodes[0];
            for (uint32_t x = at[0]; x <= end[0]; x++)
                *(row[x] < 0.0f ? &negative : &positive) = 1;
            if (negative && positive)
                return 1;
        }
    return 0;
}

/* Largest |f(centre)| / half diagonal over the cubes of `size` cells that the surface passes. */
static double needed_bound(const grid *g, uint32_t size) {
    double most = 0.0, half_diagonal = 0.5 * sqrt(3.0) * size * g->h;
    uint32_t at[3];
    for (at[2] = 0; at[2] + size / 2 < g->nodes[2]; at[2] += size)
        for (at[1] = 0; at[1] + size / 2 < g->nodes[1]; at[1] += size)
            for (at[0] = 0; at[0] + size / 2 < g->nodes[0]; at[0] += size) {
                size_t centre =
                    ((size_t)(at[2] + size / 2) * g->nodes[1] + at[1] + size / 2) * g->nodes[0] + at[0] + size / 2;
                double needed = fabs((double)g->value[centre]) / half_diagonal;
                if (needed > most && sign_changes(g, at, size))
                    most = needed;
            }
    return most;
}

static nsdf_status measure(const nsdf_check_job *job, nsdf_decoder *decoder, grid *g, uint32_t steps, double *bound,
                           nsdf_encoder_error *error) {
    uint32_t count = job->frames->count, first = job->frames->frames[0].number;
    double began = nsdf_clock(), inverse = 1.0 / job->header->scale;
    for (uint32_t i = 0; i < count; i++) {
        double t = 0.0;
        nsdf_status status = nsdf_frame_time(decoder, job->frames->frames[i].number - first, &t);
        if (status == NSDF_OK)
            status = nsdf_evaluate(decoder, t, g->xyz, g->count, g->value, NULL);
        if (status != NSDF_OK)
            return nsdf_encoder_fail(error, status, "bound: %s", nsdf_status_string(status));
        for (size_t k = 0; k < g->count; k++)
            g->value[k] = (float)((double)g->value[k] * inverse);
        for (uint32_t size = 2; size <= LARGEST_CUBE; size *= 2)
            *bound = fmax(*bound, needed_bound(g, size));
        if (nsdf_check_progress(job, NSDF_STAGE_BOUND, began, i + 1, steps))
            return nsdf_encoder_fail(error, NSDF_CANCELLED, "cancelled");
    }
    return NSDF_OK;
}

/* ---- Extraction with the bound against a safer one --------------------------------------------------------- */

/* The bound is a field of HEAD's payload; a copy of the file with another one serves for the comparison. */
static nsdf_status open_with_bound(const nsdf_check_job *job, const nsdf_buffer *file, float bound, nsdf_buffer *copy,
                                   nsdf_decoder **decoder) {
    nsdf_file_header header = *job->header;
    nsdf_buffer payload = {NULL, 0, 0, 0};
    const size_t after = NSDF_PREAMBLE_SIZE + NSDF_CHUNK_OVERHEAD + NSDF_HEADER_PAYLOAD_SIZE;
    header.extraction_bound = bound;
    nsdf_write_preamble(copy);
    nsdf_write_header(&payload, &header);
    nsdf_write_chunk(copy, NSDF_CHUNK_HEAD, NSDF_CHUNK_CRITICAL, payload.data, payload.size);
    nsdf_buffer_append(copy, file->data + after, file->size - after);
    const int failed = copy->failed || payload.failed;
    nsdf_buffer_free(&payload);
    return failed ? NSDF_NO_MEMORY : nsdf_open_memory(decoder, copy->data, copy->size, NULL, NULL);
}

static nsdf_status hash_at(nsdf_decoder *decoder, double t, int dense, nsdf_mesh **mesh, uint64_t *hash) {
    nsdf_mesh_options options;
    nsdf_mesh_view view;
    nsdf_mesh_options_init(&options);
    options.resolution = BOUND_RESOLUTION;
    options.normals = 0;
    options.projection = 0;
    options.dense = (uint32_t)dense;
    nsdf_status status = nsdf_extract_mesh(decoder, t, &options, mesh);
    if (status == NSDF_OK)
        status = nsdf_mesh_get_view(*mesh, &view);
    if (status == NSDF_OK)
        *hash = nsdf_mesh_hash(&view);
    return status;
}

/* Progress of extractions: where they count on from, and how many steps there are in all. */
typedef struct {
    double began;
    uint32_t done, steps;
} course;

/* Hashes of all frames. */
static nsdf_status hash_frames(const nsdf_check_job *job, nsdf_decoder *decoder, int dense, const course *c,
                               uint64_t *hashes) {
    const uint32_t count = job->frames->count, first = job->frames->frames[0].number;
    nsdf_mesh *mesh = NULL;
    nsdf_status status = NSDF_OK;
    for (uint32_t i = 0; i < count && status == NSDF_OK; i++) {
        double t = 0.0;
        status = nsdf_frame_time(decoder, job->frames->frames[i].number - first, &t);
        if (status == NSDF_OK)
            status = hash_at(decoder, t, dense, &mesh, &hashes[i]);
        if (nsdf_check_progress(job, NSDF_STAGE_BOUND, c->began, c->done + i + 1, c->steps))
            status = NSDF_CANCELLED;
    }
    nsdf_mesh_free(&mesh);
    return status;
}

/* What extraction with a bound gives; or dense extraction when the bound is 0. */
static nsdf_status hash_with(const nsdf_check_job *job, const nsdf_buffer *file, float bound, const course *c,
                             uint64_t *hashes) {
    nsdf_buffer copy = {NULL, 0, 0, 0};
    nsdf_decoder *decoder = NULL;
    nsdf_status status = open_with_bound(job, file, bound > 0.0f ? bound : (float)NSDF_HIGHEST_BOUND, &copy, &decoder);
    if (status == NSDF_OK)
        status = hash_frames(job, decoder, !(bound > 0.0f), c, hashes);
    nsdf_close(&decoder);
    nsdf_buffer_free(&copy);
    return status;
}

/* Raises the bound from `start` until extraction gives what it does with `safe`. */
static nsdf_status raise_bound(const nsdf_check_job *job, const nsdf_buffer *file, double start, double safe, course c,
                               float *bound) {
    const uint32_t count = job->frames->count;
    uint64_t *wanted = malloc(count * sizeof *wanted), *found = malloc(count * sizeof *found);
    nsdf_status status = wanted && found ? hash_with(job, file, (float)safe, &c, wanted) : NSDF_NO_MEMORY;
    c.done += count;
    for (double b = start; status == NSDF_OK; b *= growth) {
        *bound = (float)fmin(b, NSDF_HIGHEST_BOUND);
        if (b >= NSDF_HIGHEST_BOUND || (safe > 0.0 && b >= safe))
            break;
        status = hash_with(job, file, *bound, &c, found);
        if (status == NSDF_OK && memcmp(wanted, found, count * sizeof *wanted) == 0)
            break;
    }
    free(wanted);
    free(found);
    return status;
}

static uint32_t smaller(uint32_t a, uint32_t b) {
    return a < b ? a : b;
}

static nsdf_status measure_network(const nsdf_check_job *job, const nsdf_buffer *file, uint32_t steps, double *needed,
                                   nsdf_encoder_error *error) {
    nsdf_decoder *decoder = NULL;
    grid g;
    memset(&g, 0, sizeof g);
    nsdf_status status = nsdf_open_memory(&decoder, file->data, file->size, NULL, NULL);
    if (status != NSDF_OK)
        return nsdf_encoder_fail(error, status, "bound: %s", nsdf_status_string(status));
    if (create_grid(&g, job->header) != 0)
        status = nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory");
    else
        status = measure(job, decoder, &g, steps, needed, error);
    free_grid(&g);
    nsdf_close(&decoder);
    return status;
}

static nsdf_status raise_or_fail(const nsdf_check_job *job, const nsdf_buffer *file, double start, double safe,
                                 course c, float *bound, nsdf_encoder_error *error) {
    const nsdf_status status = raise_bound(job, file, start, safe, c, bound);
    return status == NSDF_OK ? status : nsdf_encoder_fail(error, status, "bound: %s", nsdf_status_string(status));
}

static nsdf_status bound_of_network(const nsdf_check_job *job, const nsdf_buffer *file, float *bound,
                                    nsdf_encoder_error *error) {
    const uint32_t checked = smaller(job->frames->count, CHECKED_FRAMES), steps = job->frames->count + 2 * checked;
    nsdf_check_part part;
    double needed = 0.0;
    nsdf_status status = nsdf_check_part_pick(&part, job, checked) == 0
                             ? measure_network(job, file, steps, &needed, error)
                             : nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory");
    if (status == NSDF_OK) {
        const course c = {nsdf_clock(), job->frames->count, steps};
        const double start = fmin(fmax(needed * bound_margin, lowest_bound), NSDF_HIGHEST_BOUND);
        status = raise_or_fail(&part.job, file, start, 0.0, c, bound, error);
    }
    nsdf_check_part_free(&part);
    return status;
}

static uint32_t measured_frames(const nsdf_check_job *job) {
    const uint32_t count = job->frames->count, share = (count + MEASURED_OF - 1) / MEASURED_OF;
    if (!job->options->verify || count <= MEASURED_FRAMES)
        return count;
    return share > MEASURED_FRAMES ? share : MEASURED_FRAMES;
}

nsdf_status nsdf_measure_bound(const nsdf_check_job *job, const nsdf_buffer *file, int blocks, float *bound,
                               nsdf_encoder_error *error) {
    nsdf_check_part part;
    nsdf_status status;
    if (nsdf_check_part_pick(&part, job, measured_frames(job)) != 0) {
        status = nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory");
    } else if (blocks) {
        const course c = {nsdf_clock(), 0, 2 * part.frames.count};
        status = raise_or_fail(&part.job, file, lowest_bound, safe_for_blocks, c, bound, error);
    } else {
        status = bound_of_network(&part.job, file, bound, error);
    }
    nsdf_check_part_free(&part);
    return status;
}

double nsdf_bound_work(const nsdf_check_job *job) {
    const uint32_t measured = measured_frames(job);
    return 0.5 * ((double)measured + smaller(measured, CHECKED_FRAMES));
}
