/* Checks what the decoder promises of meshes, on frames of a file: sparse and dense extraction give the same bytes, as
 * do 1, 2 and 4 threads, and handles that decoded the frames before and new ones; every mesh is closed, oriented,
 * 2-manifold and without triangles of area 0; prints how far vertices are from the zero set. usage: check_surfaces
 * FILE.nsdf RESOLUTION STEP [MOST_FAR]
 *   every STEP-th frame; MOST_FAR: the largest percentage of vertices that may be farther than 1e-6 of the diagonal */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "nsdf/decoder.h"

/* Fraction of the diagonal: vertices beyond it are counted. */
static const double far_away = 1e-6;

enum { WAYS = 3 };
static const uint32_t threads_of[WAYS] = {1, 2, 4};

typedef struct checker {
    const char *path;
    nsdf_decoder *warm[WAYS];
    nsdf_mesh *meshes[WAYS];
    nsdf_mesh *cold, *dense;
    nsdf_info info;
    uint32_t resolution, frames, failures;
    uint64_t vertices, triangles, far;
    double largest, smallest_area;
} checker;

static void stop(const char *what, nsdf_status status) {
    fprintf(stderr, "check_surfaces: %s: %s\n", what, nsdf_status_string(status));
    exit(EXIT_FAILURE);
}

static nsdf_decoder *open_with(const char *path, uint32_t threads) {
    nsdf_decoder_options options;
    nsdf_decoder *decoder = NULL;
    nsdf_decoder_options_init(&options);
    options.threads = threads;
    options.max_memory = (uint64_t)3 << 30;
    const nsdf_status status = nsdf_open_file(&decoder, path, &options, NULL);
    if (status != NSDF_OK)
        stop(path, status);
    return decoder;
}

static nsdf_mesh_view extract(nsdf_decoder *decoder, double t, uint32_t resolution, uint32_t dense, nsdf_mesh **mesh) {
    nsdf_mesh_options options;
    nsdf_mesh_view view = {0};
    nsdf_mesh_options_init(&options);
    options.resolution = resolution;
    options.dense = dense;
    nsdf_status status = nsdf_extract_mesh(decoder, t, &options, mesh);
    if (status == NSDF_OK)
        status = nsdf_mesh_get_view(*mesh, &view);
    if (status != NSDF_OK)
        stop("extraction", status);
    return view;
}

static int same(const nsdf_mesh_view *a, const nsdf_mesh_view *b) {
    const size_t vectors = 12 * (size_t)a->vertex_count;
    return a->vertex_count == b->vertex_count && a->triangle_count == b->triangle_count &&
           !memcmp(a->positions, b->positions, vectors) && !memcmp(a->normals, b->normals, vectors) &&
           !memcmp(a->indices, b->indices, 12 * (size_t)a->triangle_count);
}

static void expect(checker *c, int holds, const char *what) {
    if (holds)
        return;
    c->failures++;
    printf("frame %u of those checked: %s\n", c->frames, what);
}

/* ---- Topology ---------------------------------------------------------------------------------------------- */

typedef struct directed_edge {
    uint32_t from, to, apex; /* a triangle's edge and its third vertex */
} directed_edge;

static int compare_edges(const void *a, const void *b) {
    const directed_edge *x = a, *y = b;
    if (x->from != y->from)
        return x->from < y->from ? -1 : 1;
    return (x->to > y->to) - (x->to < y->to);
}

static directed_edge *sorted_edges(const nsdf_mesh_view *view) {
    const size_t count = 3 * (size_t)view->triangle_count;
    directed_edge *edges = malloc(count * sizeof *edges + 1);
    if (!edges)
        stop("edges", NSDF_NO_MEMORY);
    for (size_t i = 0; i < count; i++) {
        const uint32_t *t = view->indices + i / 3 * 3;
        edges[i] = (directed_edge){t[i % 3], t[(i + 1) % 3], t[(i + 2) % 3]};
    }
    qsort(edges, count, sizeof *edges, compare_edges);
    return edges;
}

/* Closed and oriented: every directed edge once, and its reverse. */
static int is_closed(const directed_edge *edges, size_t count) {
    for (size_t i = 0; i < count; i++) {
        const directed_edge reverse = {edges[i].to, edges[i].from, 0};
        if (edges[i].from == edges[i].to || (i > 0 && compare_edges(&edges[i - 1], &edges[i]) == 0) ||
            !bsearch(&reverse, edges, count, sizeof *edges, compare_edges))
            return 0;
    }
    return 1;
}

/* The triangles around the vertex of edges[first, end) are one ring. */
static int is_ring(const directed_edge *edges, size_t first, size_t end) {
    const directed_edge *at = &edges[first];
    for (size_t steps = 1; steps <= end - first; steps++) {
        const directed_edge next = {at->from, at->apex, 0};
        at = bsearch(&next, edges + first, end - first, sizeof *edges, compare_edges);
        if (!at || at == &edges[first])
            return at && steps == end - first;
    }
    return 0;
}

static int is_manifold(const directed_edge *edges, size_t count) {
    for (size_t first = 0, end; first < count; first = end) {
        for (end = first + 1; end < count && edges[end].from == edges[first].from;)
            end++;
        if (!is_ring(edges, first, end))
            return 0;
    }
    return 1;
}

static void check_topology(checker *c, const nsdf_mesh_view *view) {
    const size_t count = 3 * (size_t)view->triangle_count;
    directed_edge *edges = sorted_edges(view);
    const int closed = is_closed(edges, count);
    expect(c, closed, "not closed and oriented");
    expect(c, closed && is_manifold(edges, count), "not a 2-manifold");
    free(edges);
}

/* ---- Geometry ---------------------------------------------------------------------------------------------- */

static double area(const nsdf_mesh_view *view, const uint32_t *t) {
    double u[3], w[3];
    for (int a = 0; a < 3; a++) {
        u[a] = (double)view->positions[3 * t[1] + (uint32_t)a] - (double)view->positions[3 * t[0] + (uint32_t)a];
        w[a] = (double)view->positions[3 * t[2] + (uint32_t)a] - (double)view->positions[3 * t[0] + (uint32_t)a];
    }
    const double x = u[1] * w[2] - u[2] * w[1], y = u[2] * w[0] - u[0] * w[2], z = u[0] * w[1] - u[1] * w[0];
    return 0.5 * sqrt(x * x + y * y + z * z);
}

static void check_areas(checker *c, const nsdf_mesh_view *view) {
    const double cell = c->info.diagonal / c->resolution;
    double least = INFINITY;
    for (size_t i = 0; i < view->triangle_count; i++)
        least = fmin(least, area(view, view->indices + 3 * i));
    expect(c, least > 0.0, "a triangle of area 0");
    c->smallest_area = fmin(c->smallest_area, least / (cell * cell));
}

/* Whether the field changes its sign within far_away of a vertex, along its gradient or an axis: it may jump there. */
static int changes_sign(checker *c, nsdf_decoder *decoder, double t, const float at[3], double value,
                        const float gradient[3]) {
    float points[8][3], values[8];
    const double x = (double)gradient[0], y = (double)gradient[1], z = (double)gradient[2];
    const double reach = far_away * c->info.diagonal, length = fmax(sqrt(x * x + y * y + z * z), 1e-30);
    for (int i = 0; i < 8; i++)
        for (int a = 0; a < 3; a++) {
            const double along = i < 6 ? (double)(i / 2 == a) : (double)gradient[a] / length;
            points[i][a] = (float)((double)at[a] + (i % 2 ? reach : -reach) * along);
        }
    if (nsdf_evaluate(decoder, t, points[0], 8, values, NULL) != NSDF_OK)
        stop("evaluation", NSDF_INTERNAL);
    for (int i = 0; i < 8; i++)
        if (((double)values[i] < 0.0) != (value < 0.0))
            return 1;
    return 0;
}

/* |f| / |gradient| is the distance to the zero set, as far as the field is linear there. */
static void measure_distances(checker *c, nsdf_decoder *decoder, double t, const nsdf_mesh_view *view) {
    float *const memory = malloc(4 * (size_t)view->vertex_count * sizeof *memory + 1);
    float *const gradient = memory + view->vertex_count;
    if (!memory)
        stop("distances", NSDF_NO_MEMORY);
    const nsdf_status status = nsdf_evaluate(decoder, t, view->positions, view->vertex_count, memory, gradient);
    if (status != NSDF_OK)
        stop("evaluation", status);
    for (size_t i = 0; i < view->vertex_count; i++) {
        const double x = (double)gradient[3 * i], y = (double)gradient[3 * i + 1], z = (double)gradient[3 * i + 2];
        const double distance = fabs((double)memory[i]) / sqrt(x * x + y * y + z * z) / c->info.diagonal;
        const int far = distance > far_away &&
                        !changes_sign(c, decoder, t, view->positions + 3 * i, (double)memory[i], gradient + 3 * i);
        c->far += far ? 1 : 0;
        c->largest = fmax(c->largest, far || distance <= far_away ? distance : far_away);
    }
    free(memory);
}

/* ---- Frames ------------------------------------------------------------------------------------------------ */

static void check_frame(checker *c, uint32_t frame) {
    double t;
    const nsdf_status status = nsdf_frame_time(c->warm[0], frame, &t);
    if (status != NSDF_OK)
        stop("time", status);
    const nsdf_mesh_view first = extract(c->warm[0], t, c->resolution, 0, &c->meshes[0]);
    for (int i = 1; i < WAYS; i++) {
        const nsdf_mesh_view other = extract(c->warm[i], t, c->resolution, 0, &c->meshes[i]);
        expect(c, same(&first, &other), "the number of threads changes the mesh");
    }
    nsdf_decoder *fresh = open_with(c->path, 2);
    const nsdf_mesh_view cold = extract(fresh, t, c->resolution, 0, &c->cold);
    expect(c, same(&first, &cold), "a new handle gives another mesh");
    const nsdf_mesh_view dense = extract(fresh, t, c->resolution, 1, &c->dense);
    expect(c, same(&first, &dense), "dense extraction gives another mesh");
    nsdf_close(&fresh);
    check_topology(c, &first);
    check_areas(c, &first);
    measure_distances(c, c->warm[0], t, &first);
    c->frames++;
    c->vertices += first.vertex_count;
    c->triangles += first.triangle_count;
}

static void close_all(checker *c) {
    for (int i = 0; i < WAYS; i++) {
        nsdf_mesh_free(&c->meshes[i]);
        nsdf_close(&c->warm[i]);
    }
    nsdf_mesh_free(&c->cold);
    nsdf_mesh_free(&c->dense);
}

int main(int argc, char **argv) {
    checker c = {.smallest_area = INFINITY};
    if (argc < 4) {
        fprintf(stderr, "usage: check_surfaces FILE.nsdf RESOLUTION STEP [MOST_FAR]\n");
        return 2;
    }
    const uint32_t step = (uint32_t)strtoul(argv[3], NULL, 10);
    const double limit = argc > 4 ? strtod(argv[4], NULL) : INFINITY;
    c.path = argv[1];
    c.resolution = (uint32_t)strtoul(argv[2], NULL, 10);
    for (int i = 0; i < WAYS; i++)
        c.warm[i] = open_with(c.path, threads_of[i]);
    const nsdf_status status = nsdf_get_info(c.warm[0], &c.info);
    if (status != NSDF_OK || step == 0)
        stop("the file or the step", status);
    for (uint32_t frame = 0; frame < c.info.frame_count; frame += step)
        check_frame(&c, frame);
    close_all(&c);
    expect(&c, c.vertices > 0, "no surface");
    const double far = 100.0 * (double)c.far / (double)c.vertices;
    expect(&c, far <= limit, "too many vertices far from the zero set");
    printf(
        "%s at %u: %u frames, %.0f vertices a frame, at most %.2e of the diagonal from the zero set, %.4f %% of them "
        "more than %.0e, least area %.2e of a squared cell; %u broken promises\n",
        c.path, c.resolution, c.frames, (double)c.vertices / c.frames, c.largest, far, far_away, c.smallest_area,
        c.failures);
    return c.failures ? EXIT_FAILURE : EXIT_SUCCESS;
}
