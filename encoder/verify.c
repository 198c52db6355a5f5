#include "verify.h"

#include "bound_pieces.h"
#include "fit.h"
#include "surface_error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLES = 6000 }; /* surface points per frame and direction */
static const float stray_distance = 1e-2f;
/* A piece of this share of the input's smallest one is part of the surface, if badly fitted. */
static const float true_share = 0.75f;
/* Specks at other times than the frames', and at other resolutions, are a little larger. */
static const float speck_margin = 1.1f;

typedef struct {
    nsdf_mesh *mesh;
    nsdf_surface decoded; /* normalised copy */
    uint32_t *piece;      /* [its triangles] */
    uint32_t piece_count;
    nsdf_distance_stats stats[2]; /* to decoded, to input */
    nsdf_piece_report pieces;
    int failed;
} comparison;

typedef struct {
    const nsdf_check_job *job;
    nsdf_sample_set *strays; /* [frame] */
    comparison *items;       /* [worker count] */
    uint32_t first;          /* frame of items[0] */
} group;

static int normalised_copy(const nsdf_file_header *header, const nsdf_mesh *mesh, nsdf_surface *out) {
    nsdf_mesh_view view;
    if (nsdf_mesh_get_view(mesh, &view) != NSDF_OK)
        return -1;
    nsdf_surface s = {malloc(3 * sizeof(float) * ((size_t)view.vertex_count + 1)),
                      malloc(3 * sizeof(uint32_t) * ((size_t)view.triangle_count + 1)), view.vertex_count,
                      view.triangle_count};
    *out = s;
    if (!s.positions || !s.indices)
        return -1;
    for (size_t i = 0; i < 3 * (size_t)view.vertex_count; i++)
        s.positions[i] = (float)(((double)view.positions[i] - header->centre[i % 3]) / header->scale);
    if (view.triangle_count)
        memcpy(s.indices, view.indices, 3 * sizeof(uint32_t) * view.triangle_count);
    return 0;
}

/* Which vertices of a decoded surface are astray, found when it is asked for. */
typedef struct {
    const nsdf_surface *decoded;
    const nsdf_sdf *input;
    uint8_t *answers; /* [vertex]: 0 = not asked yet */
} astray;

enum { NEAR_INPUT = 1, ASTRAY = 2 };

/* Whether the triangle's first vertex is. */
static int is_stray(const astray *a, uint32_t triangle) {
    const uint32_t v = a->decoded->indices[3 * (size_t)triangle];
    const float *point = a->decoded->positions + 3 * (size_t)v;
    if (!a->answers[v])
        a->answers[v] = nsdf_sdf_is_within(a->input, point, stray_distance) ? NEAR_INPUT : ASTRAY;
    return a->answers[v] == ASTRAY;
}

/* Marks the pieces, but for the largest, with a vertex away from the input.  Returns 0, or -1 when memory ran out. */
static int mark_strays(const astray *a, const uint32_t *piece, uint32_t pieces, uint8_t *stray) {
    const nsdf_surface *decoded = a->decoded;
    uint32_t *size = malloc(pieces * sizeof *size);
    if (!size)
        return -1;
    const uint32_t largest = nsdf_largest_piece(decoded, piece, pieces, size);
    for (uint32_t i = 0; i < decoded->triangle_count; i++) {
        if (piece[i] == largest || stray[piece[i]])
            continue;
        stray[piece[i]] = (uint8_t)is_stray(a, i);
    }
    free(size);
    return 0;
}

/* What to take of a decoded surface: `wanted[i]` of its triangles' first vertices, spread over all of them, with the
 * distances that the field should have there. */
static int collect(const nsdf_surface *decoded, const uint8_t *wanted, const nsdf_sdf *sdf, nsdf_sample_set *set) {
    nsdf_sample_set s;
    size_t count = 0, seen = 0;
    for (uint32_t i = 0; i < decoded->triangle_count; i++)
        count += wanted[i];
    const size_t step = 1 + count / NSDF_MOST_STRAYS;
    const int failed = nsdf_sample_set_create(&s, NSDF_MOST_STRAYS);
    s.count = 0;
    for (uint32_t i = 0; !failed && i < decoded->triangle_count; i++) {
        const float *v = decoded->positions + 3 * (size_t)decoded->indices[3 * (size_t)i];
        if (!wanted[i] || seen++ % step != 0)
            continue;
        s.x[s.count] = v[0];
        s.y[s.count] = v[1];
        s.z[s.count] = v[2];
        s.d[s.count++] = nsdf_sdf_distance(sdf, v);
    }
    *set = s;
    return failed;
}

/* Vertices of stray pieces; of blocks, all that are astray, since theirs often hang on the true surface. */
static int collect_strays(const astray *a, const uint32_t *piece, const uint8_t *stray, int blocks,
                          const nsdf_frame *frame, nsdf_sample_set *set) {
    const nsdf_surface *decoded = a->decoded;
    uint8_t *wanted = malloc((size_t)decoded->triangle_count + 1);
    int any = 0, failed = !wanted;
    for (uint32_t i = 0; wanted && i < decoded->triangle_count; i++) {
        wanted[i] = blocks ? (uint8_t)is_stray(a, i) : stray[piece[i]];
        any |= wanted[i];
    }
    if (any) {
        nsdf_sdf *sdf = nsdf_frame_sdf(frame);
        failed = !sdf || collect(decoded, wanted, sdf, set) != 0;
        nsdf_sdf_free(sdf);
    }
    free(wanted);
    return failed ? -1 : 0;
}

/* Adds the pieces of a decoded frame to a report. */
static int report_pieces(const nsdf_surface *decoded, const uint32_t *piece, const uint8_t *stray, uint32_t count,
                         nsdf_piece_report *report) {
    float *size = malloc(count * sizeof *size);
    if (!size || nsdf_piece_sizes(decoded, piece, count, size) != 0) {
        free(size);
        return -1;
    }
    for (uint32_t p = 0; p < count; p++) {
        report->stray += stray[p];
        if (stray[p])
            report->largest_stray = fmaxf(report->largest_stray, size[p]);
        else
            report->smallest_true = fminf(report->smallest_true, size[p]);
    }
    free(size);
    return 0;
}

static int find_strays(comparison *c, const nsdf_sdf *input, const nsdf_frame *frame, int blocks,
                       nsdf_sample_set *set) {
    const nsdf_surface *decoded = &c->decoded;
    const astray a = {decoded, input, calloc((size_t)decoded->vertex_count + 1, 1)};
    c->piece = malloc(sizeof *c->piece * ((size_t)decoded->triangle_count + 1));
    const int64_t pieces = c->piece ? nsdf_surface_components(decoded, c->piece) : -1;
    uint8_t *stray = pieces > 0 ? calloc((size_t)pieces, 1) : NULL;
    int failed = !a.answers || pieces < 0 || (pieces > 0 && !stray);
    c->piece_count = pieces > 0 ? (uint32_t)pieces : 0;
    if (stray && a.answers) {
        failed = mark_strays(&a, c->piece, c->piece_count, stray) != 0 ||
                 report_pieces(decoded, c->piece, stray, c->piece_count, &c->pieces) != 0;
        if (!failed && (blocks || c->pieces.stray))
            failed = collect_strays(&a, c->piece, stray, blocks, frame, set) != 0;
    }
    free(a.answers);
    free(stray);
    return failed ? -1 : 0;
}

static void forget_frame(comparison *c) {
    nsdf_surface_free(&c->decoded);
    free(c->piece);
    c->piece = NULL;
    c->piece_count = 0;
}

/* An empty decoded frame is as far away as the domain is large. */
static void missing(comparison *c) {
    c->stats[0] = (nsdf_distance_stats){1.0, 1.0, 1.0, 1};
    c->stats[1] = c->stats[0];
}

static void compare_one(void *data, uint32_t index, uint32_t worker) {
    group *g = data;
    comparison *c = &g->items[index];
    const nsdf_frame *frame = &g->job->frames->frames[g->first + index];
    (void)worker;
    c->failed = 1;
    memset(c->stats, 0, sizeof c->stats);
    c->pieces = (nsdf_piece_report){0, 0.0f, INFINITY, 0.0};
    if (normalised_copy(g->job->header, c->mesh, &c->decoded) == 0) {
        nsdf_sdf *input = nsdf_sdf_create_unsigned(&frame->surface);
        nsdf_sdf *decoded = c->decoded.triangle_count ? nsdf_sdf_create_unsigned(&c->decoded) : NULL;
        nsdf_random random = nsdf_random_start(g->job->options->seed, 0x100000000u + frame->number);
        if (c->decoded.triangle_count == 0) {
            missing(c);
            c->failed = 0;
        } else if (input && decoded) {
            c->failed = nsdf_add_surface_distances(&frame->surface, decoded, SAMPLES, &random, &c->stats[0]) != 0 ||
                        nsdf_add_surface_distances(&c->decoded, input, SAMPLES, &random, &c->stats[1]) != 0 ||
                        find_strays(c, input, frame, g->job->options->blocks > 0, &g->strays[g->first + index]) != 0;
        }
        nsdf_sdf_free(input);
        nsdf_sdf_free(decoded);
    }
}

static void add_to_quality(const comparison *c, nsdf_quality_record *q) {
    for (int k = 0; k < 2; k++) {
        double n = c->stats[k].count ? (double)c->stats[k].count : 1.0;
        q->mean[k] += c->stats[k].sum / n;
        q->rms[k] += c->stats[k].sum_squares / n;
        q->max[k] = fmax(q->max[k], c->stats[k].max);
    }
    q->frames++;
}

static nsdf_status time_of(const group *g, nsdf_decoder *decoder, uint32_t i, double *t) {
    const nsdf_frames *frames = g->job->frames;
    return nsdf_frame_time(decoder, frames->frames[g->first + i].number - frames->frames[0].number, t);
}

static nsdf_status find_bound(const group *g, nsdf_decoder *decoder, uint32_t i, double *bound) {
    const comparison *c = &g->items[i];
    double t = 0.0;
    const nsdf_status status = time_of(g, decoder, i, &t);
    return status == NSDF_OK
               ? nsdf_bound_of_pieces(decoder, t, g->job->header, &c->decoded, c->piece, c->piece_count, bound)
               : status;
}

static void add_to_report(const nsdf_piece_report *found, nsdf_piece_report *report) {
    report->stray += found->stray;
    report->largest_stray = fmaxf(report->largest_stray, found->largest_stray);
    report->smallest_true = fminf(report->smallest_true, found->smallest_true);
}

static nsdf_status fail_at(const group *g, uint32_t i, nsdf_status status, nsdf_encoder_error *error) {
    return nsdf_encoder_fail(error, status, "verify: frame %u: %s", g->job->frames->frames[g->first + i].number,
                             nsdf_status_string(status));
}

static nsdf_status verify_group(group *g, nsdf_decoder *decoder, nsdf_workers *workers, uint32_t count,
                                nsdf_quality_record *quality, nsdf_piece_report *pieces, nsdf_encoder_error *error) {
    for (uint32_t i = 0; i < count; i++) {
        double t = 0.0;
        nsdf_status status = time_of(g, decoder, i, &t);
        if (status == NSDF_OK)
            status = nsdf_extract_mesh(decoder, t, NULL, &g->items[i].mesh);
        if (status != NSDF_OK)
            return fail_at(g, i, status, error);
    }
    nsdf_workers_run(workers, count, compare_one, g);
    nsdf_status status = NSDF_OK;
    for (uint32_t i = 0; i < count; i++) {
        if (status == NSDF_OK)
            status = g->items[i].failed ? NSDF_NO_MEMORY : find_bound(g, decoder, i, &pieces->bound);
        if (status != NSDF_OK)
            (void)fail_at(g, i, status, error);
        add_to_quality(&g->items[i], quality);
        add_to_report(&g->items[i].pieces, pieces);
        forget_frame(&g->items[i]);
    }
    return status;
}

bool nsdf_specks_can_go(const nsdf_piece_report *pieces, const nsdf_frames *frames, const nsdf_encoder_options *options,
                        float *size) {
    const float least = pieces->largest_stray * speck_margin;
    const float most = fminf(pieces->smallest_true, true_share * nsdf_frames_smallest_piece(frames));
    if (options->smallest_piece >= 0.0 || pieces->stray == 0 || !(least < most))
        return false;
    *size = least;
    return true;
}

nsdf_status nsdf_verify_file(const nsdf_check_job *job, nsdf_workers *workers, const nsdf_buffer *file,
                             nsdf_quality_record *quality, nsdf_piece_report *pieces, nsdf_sample_set *strays,
                             nsdf_encoder_error *error) {
    uint32_t count = job->frames->count, stretch = nsdf_workers_count(workers);
    nsdf_decoder *decoder = NULL;
    group g = {job, strays, calloc(stretch, sizeof *g.items), 0};
    nsdf_status status = g.items ? nsdf_open_memory(&decoder, file->data, file->size, NULL, NULL) : NSDF_NO_MEMORY;
    double began = nsdf_clock();
    memset(quality, 0, sizeof *quality);
    *pieces = (nsdf_piece_report){0, 0.0f, INFINITY, 0.0};
    if (status != NSDF_OK)
        (void)nsdf_encoder_fail(error, status, "verify: %s", nsdf_status_string(status));
    for (; status == NSDF_OK && g.first < count; g.first += stretch) {
        uint32_t n = count - g.first < stretch ? count - g.first : stretch;
        status = verify_group(&g, decoder, workers, n, quality, pieces, error);
        if (status == NSDF_OK && nsdf_check_progress(job, NSDF_STAGE_VERIFY, began, g.first + n, count))
            status = nsdf_encoder_fail(error, NSDF_CANCELLED, "cancelled");
    }
    for (int k = 0; k < 2 && quality->frames; k++) {
        quality->mean[k] /= quality->frames;
        quality->rms[k] = sqrt(quality->rms[k] / quality->frames);
    }
    quality->resolution = job->options->resolution;
    for (uint32_t i = 0; g.items && i < stretch; i++)
        nsdf_mesh_free(&g.items[i].mesh);
    free(g.items);
    nsdf_close(&decoder);
    return status;
}
