#include "verify.h"

#include "bound_pieces.h"
#include "decoded_surface.h"
#include "fit.h"
#include "lost_pieces.h"
#include "surface_error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLES = 6000 }; /* surface points per frame and direction */
typedef struct {
    nsdf_mesh *mesh;
    nsdf_surface decoded; /* normalised copy */
    uint32_t *piece;      /* [its triangles] */
    uint32_t piece_count;
    uint32_t frame;
    double time; /* of the frame, seconds */
    nsdf_frame_check check;
    int failed;
} comparison;

typedef struct {
    const nsdf_check_job *job;
    nsdf_sample_set *strays;  /* [frame] */
    nsdf_frame_check *checks; /* [frame] */
    comparison *items;        /* [worker count] */
    uint32_t next;            /* frame to be looked at */
    float size;               /* of the file's smallest piece */
} group;

/* Which vertices of a decoded surface are astray, found when it is asked for. */
typedef struct {
    const nsdf_surface *decoded;
    const nsdf_sdf *input;
    uint8_t *answers; /* [vertex]: 0 = not asked yet */
} astray;

enum { NEAR_INPUT = 1, ASTRAY = 2 };

/* Of the triangles of a piece that counts as stray, so many at least are away from the input: on a true piece there may
 * be a little that should not be there. */
static const double stray_share = 0.05;

/* Whether the triangle's first vertex is. */
static int is_stray(const astray *a, uint32_t triangle) {
    const uint32_t v = a->decoded->indices[3 * (size_t)triangle];
    const float *point = a->decoded->positions + 3 * (size_t)v;
    if (!a->answers[v])
        a->answers[v] = nsdf_sdf_is_within(a->input, point, NSDF_STRAY_DISTANCE) ? NEAR_INPUT : ASTRAY;
    return a->answers[v] == ASTRAY;
}

/* Marks the pieces, but for the largest, of which a part is away from the input.  Returns 0, or -1 when memory ran out.
 */
static int mark_strays(const astray *a, const uint32_t *piece, uint32_t pieces, uint8_t *stray) {
    const nsdf_surface *decoded = a->decoded;
    uint32_t *size = calloc(2 * (size_t)pieces, sizeof *size);
    if (!size)
        return -1;
    uint32_t *away = size + pieces;
    const uint32_t largest = nsdf_largest_piece(decoded, piece, pieces, size);
    for (uint32_t i = 0; i < decoded->triangle_count; i++)
        if (piece[i] != largest)
            away[piece[i]] += (uint32_t)is_stray(a, i);
    for (uint32_t p = 0; p < pieces; p++)
        stray[p] = (double)away[p] > stray_share * (double)size[p];
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

static int report_pieces(const nsdf_surface *decoded, const uint32_t *piece, const uint8_t *stray, uint32_t count,
                         nsdf_frame_check *check) {
    nsdf_piece_report *report = &check->pieces;
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
        check->smallest = fminf(check->smallest, size[p]);
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
                 report_pieces(decoded, c->piece, stray, c->piece_count, &c->check) != 0;
        if (!failed && (blocks || c->check.pieces.stray))
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

static void note_distances(nsdf_frame_check *check, int side, const nsdf_distance_stats *stats) {
    const double n = stats->count ? (double)stats->count : 1.0;
    check->mean[side] = stats->sum / n;
    check->mean_square[side] = stats->sum_squares / n;
    check->max[side] = stats->max;
}

static int measure_distances(comparison *c, const nsdf_surface *input_surface, const nsdf_sdf *input, uint64_t seed,
                             uint64_t stream) {
    nsdf_sdf *decoded = nsdf_sdf_create_unsigned(&c->decoded);
    nsdf_random random = nsdf_random_start(seed, stream);
    nsdf_distance_stats stats[2];
    memset(stats, 0, sizeof stats);
    const int failed = !decoded ||
                       nsdf_add_surface_distances(input_surface, decoded, SAMPLES, &random, &stats[0]) != 0 ||
                       nsdf_add_surface_distances(&c->decoded, input, SAMPLES, &random, &stats[1]) != 0;
    for (int side = 0; side < 2; side++)
        note_distances(&c->check, side, &stats[side]);
    nsdf_sdf_free(decoded);
    return failed;
}

/* An empty decoded frame is as far away as the domain is large. */
static void note_missing(nsdf_frame_check *check) {
    for (int side = 0; side < 2; side++)
        check->mean[side] = check->mean_square[side] = check->max[side] = 1.0;
}

static void compare_one(void *data, uint32_t index, uint32_t worker) {
    group *g = data;
    comparison *c = &g->items[index];
    const nsdf_frame *frame = &g->job->frames->frames[c->frame];
    (void)worker;
    nsdf_sample_set_free(&g->strays[c->frame]);
    c->failed = nsdf_decoded_surface(g->job->header, c->mesh, &c->decoded) != 0;
    if (c->failed)
        return;
    if (c->decoded.triangle_count == 0) {
        note_missing(&c->check);
        return;
    }
    nsdf_sdf *input = nsdf_sdf_create_unsigned(&frame->surface);
    c->failed = !input ||
                measure_distances(c, &frame->surface, input, g->job->options->seed, 0x100000000u + frame->number) ||
                find_strays(c, input, frame, g->job->options->blocks > 0, &g->strays[c->frame]) != 0;
    nsdf_sdf_free(input);
}

/* ---- Frames ------------------------------------------------------------------------------------------------ */

/* Pieces are measured before vertices move onto the surface, which this allows for. */
static const float size_margin = 1.2f;

/* A larger size may take more pieces away, a smaller one brings some back. */
static bool still_holds(const nsdf_frame_check *check, float size) {
    if (!check->is_done || (size > check->size && !(check->smallest > size_margin * size)))
        return false;
    return !(size < check->size) || check->dropped == 0;
}

static nsdf_status decode(const group *g, nsdf_decoder *decoder, comparison *c) {
    const nsdf_frames *frames = g->job->frames;
    nsdf_extraction_stats done;
    c->check = (nsdf_frame_check){.pieces = {0, 0.0f, INFINITY, INFINITY, 0.0}, .smallest = INFINITY, .size = g->size};
    nsdf_status status = nsdf_frame_time(decoder, frames->frames[c->frame].number - frames->frames[0].number, &c->time);
    if (status == NSDF_OK)
        status = nsdf_extract_mesh(decoder, c->time, NULL, &c->mesh);
    if (status == NSDF_OK)
        status = nsdf_get_extraction_stats(decoder, &done);
    if (status == NSDF_OK)
        c->check.dropped = done.dropped_pieces;
    return status;
}

/* The bound that the pieces need, and whether what the decoder left out belongs to the surface; the latter only where
 * much of it is missing. */
static nsdf_status look_at_pieces(const group *g, nsdf_decoder *decoder, comparison *c) {
    const nsdf_file_header *header = g->job->header;
    nsdf_piece_report *pieces = &c->check.pieces;
    nsdf_status status =
        nsdf_bound_of_pieces(decoder, c->time, header, &c->decoded, c->piece, c->piece_count, &pieces->bound);
    if (status == NSDF_OK && c->check.dropped > 0 && c->check.max[0] > (double)NSDF_LEAST_LOST)
        status = nsdf_find_lost_pieces(decoder, c->time, header, &g->job->frames->frames[c->frame].surface,
                                       &pieces->smallest_lost);
    return status;
}

static nsdf_status fail_at(const group *g, uint32_t frame, nsdf_status status, nsdf_encoder_error *error) {
    return nsdf_encoder_fail(error, status, "verify: frame %u: %s", g->job->frames->frames[frame].number,
                             nsdf_status_string(status));
}

static nsdf_status verify_group(group *g, nsdf_decoder *decoder, nsdf_workers *workers, uint32_t count,
                                nsdf_encoder_error *error) {
    for (uint32_t i = 0; i < count; i++) {
        const nsdf_status status = decode(g, decoder, &g->items[i]);
        if (status != NSDF_OK)
            return fail_at(g, g->items[i].frame, status, error);
    }
    nsdf_workers_run(workers, count, compare_one, g);
    nsdf_status status = NSDF_OK;
    for (uint32_t i = 0; i < count; i++) {
        comparison *c = &g->items[i];
        if (status == NSDF_OK) {
            status = c->failed ? NSDF_NO_MEMORY : look_at_pieces(g, decoder, c);
            if (status != NSDF_OK)
                (void)fail_at(g, c->frame, status, error);
        }
        c->check.is_done = status == NSDF_OK;
        g->checks[c->frame] = c->check;
        forget_frame(c);
    }
    return status;
}

/* The next frames that have to be verified, at most `most`, and with the last of them what is left. */
static uint32_t take_group(group *g, uint32_t most) {
    uint32_t count = 0;
    for (; g->next < g->job->frames->count; g->next++) {
        if (still_holds(&g->checks[g->next], g->size))
            continue;
        if (count == most)
            break;
        g->items[count++].frame = g->next;
    }
    return count;
}

static nsdf_status verify_all(group *g, nsdf_decoder *decoder, nsdf_workers *workers, nsdf_encoder_error *error) {
    const uint32_t frames = g->job->frames->count;
    const double began = nsdf_clock();
    nsdf_status status = NSDF_OK;
    for (uint32_t n; status == NSDF_OK && (n = take_group(g, nsdf_workers_count(workers))) > 0;) {
        status = verify_group(g, decoder, workers, n, error);
        if (status == NSDF_OK && nsdf_check_progress(g->job, NSDF_STAGE_VERIFY, began, g->next, frames))
            status = nsdf_encoder_fail(error, NSDF_CANCELLED, "cancelled");
    }
    return status;
}

nsdf_status nsdf_verify_file(const nsdf_check_job *job, nsdf_workers *workers, const nsdf_buffer *file,
                             nsdf_frame_check *checks, nsdf_sample_set *strays, nsdf_encoder_error *error) {
    const uint32_t stretch = nsdf_workers_count(workers);
    nsdf_decoder *decoder = NULL;
    nsdf_info info;
    group g = {job, strays, checks, calloc(stretch, sizeof *g.items), 0, 0.0f};
    nsdf_status status = g.items ? nsdf_open_memory(&decoder, file->data, file->size, NULL, NULL) : NSDF_NO_MEMORY;
    if (status == NSDF_OK)
        status = nsdf_get_info(decoder, &info);
    if (status == NSDF_OK) {
        g.size = (float)(info.smallest_piece / info.diagonal);
        status = verify_all(&g, decoder, workers, error);
    } else {
        (void)nsdf_encoder_fail(error, status, "verify: %s", nsdf_status_string(status));
    }
    for (uint32_t i = 0; g.items && i < stretch; i++)
        nsdf_mesh_free(&g.items[i].mesh);
    free(g.items);
    nsdf_close(&decoder);
    return status;
}

/* ---- All frames together ----------------------------------------------------------------------------------- */

nsdf_quality_record nsdf_quality_of_checks(const nsdf_frame_check *checks, uint32_t frames, uint32_t resolution) {
    nsdf_quality_record q = {.resolution = resolution, .frames = frames};
    for (uint32_t f = 0; f < frames; f++)
        for (int side = 0; side < 2; side++) {
            q.mean[side] += checks[f].mean[side];
            q.rms[side] += checks[f].mean_square[side];
            q.max[side] = fmax(q.max[side], checks[f].max[side]);
        }
    for (int side = 0; side < 2 && frames > 0; side++) {
        q.mean[side] /= frames;
        q.rms[side] = sqrt(q.rms[side] / frames);
    }
    return q;
}

nsdf_piece_report nsdf_pieces_of_checks(const nsdf_frame_check *checks, uint32_t frames) {
    nsdf_piece_report all = {0, 0.0f, INFINITY, INFINITY, 0.0};
    for (uint32_t f = 0; f < frames; f++) {
        const nsdf_piece_report *one = &checks[f].pieces;
        all.stray += one->stray;
        all.largest_stray = fmaxf(all.largest_stray, one->largest_stray);
        all.smallest_true = fminf(all.smallest_true, one->smallest_true);
        all.smallest_lost = fminf(all.smallest_lost, one->smallest_lost);
        all.bound = fmax(all.bound, one->bound);
    }
    return all;
}
