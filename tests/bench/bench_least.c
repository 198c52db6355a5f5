/* How many points extraction evaluates, beside the least by the definition in docs/decoder.md: on each level the halves
 * of the cubes that the surface crosses, of the coarsest all cubes, and at last the corners of the crossed cells, or of
 * the crossed cubes of two cells.  Crossed is what has a vertex on an edge, before vertices move, all pieces.
 *
 *     bench_least FILE.nsdf RESOLUTION [STEP]
 *       every STEP-th frame */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "handle.h"
#include "mesher_internal.h"

enum { COARSEST = 32, LEVELS = 6 }; /* cubes of 32, 16, 8, 4, 2 and 1 cells */

/* Sets of cubes of one size or of corners, a byte each. */
typedef struct byte_grid {
    uint32_t size[3];
    uint8_t *set;
} byte_grid;

typedef struct tally {
    uint64_t frames, vertices, centres, corners; /* evaluated */
    uint64_t least_centres, least_by_cells, least_by_cubes;
} tally;

static void stop(const char *what, nsdf_status status) {
    fprintf(stderr, "bench_least: %s: %s\n", what, nsdf_status_string(status));
    exit(EXIT_FAILURE);
}

static byte_grid make_grid(const uint32_t cells[3], uint32_t cube, uint32_t more) {
    byte_grid g = {{0, 0, 0}, NULL};
    size_t total = 1;
    for (int a = 0; a < 3; a++) {
        g.size[a] = (cells[a] + cube - 1) / cube + more;
        total *= g.size[a];
    }
    g.set = calloc(total, 1);
    if (!g.set)
        stop("a grid", NSDF_NO_MEMORY);
    return g;
}

static void add(byte_grid *g, uint32_t x, uint32_t y, uint32_t z) {
    g->set[((size_t)z * g->size[1] + y) * g->size[0] + x] = 1;
}

static int has(const byte_grid *g, uint32_t x, uint32_t y, uint32_t z) {
    return g->set[((size_t)z * g->size[1] + y) * g->size[0] + x];
}

static uint64_t count(const byte_grid *g) {
    const size_t total = (size_t)g->size[0] * g->size[1] * g->size[2];
    uint64_t n = 0;
    for (size_t i = 0; i < total; i++)
        n += g->set[i];
    return n;
}

/* The grid edge of a vertex: its lower corner, and its axis, along which it is no corner. */
static int edge_of(const nsdf_grid *grid, const float position[3], uint32_t corner[3]) {
    int axis = -1;
    for (int a = 0; a < 3; a++) {
        const float *at = grid->corners[a];
        uint32_t low = 0, high = grid->cells[a];
        while (low < high) { /* the last corner that is not above */
            const uint32_t middle = (low + high + 1) / 2;
            if (at[middle] <= position[a])
                low = middle;
            else
                high = middle - 1;
        }
        corner[a] = low;
        if (at[low] != position[a])
            axis = a;
    }
    return axis;
}

/* The four cells around an edge. */
static void mark_cells(byte_grid *cells, const uint32_t corner[3], int axis) {
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    for (uint32_t k = 0; k < 4; k++) {
        uint32_t at[3] = {corner[0], corner[1], corner[2]};
        const uint32_t db = k & 1, dc = k >> 1;
        if (at[b] < db || at[c] < dc)
            continue;
        at[b] -= db;
        at[c] -= dc;
        if (at[b] < cells->size[b] && at[c] < cells->size[c])
            add(cells, at[0], at[1], at[2]);
    }
}

/* Adds what holds each member of `from`, whose cubes are half as large. */
static void mark_parents(const byte_grid *from, byte_grid *to) {
    for (uint32_t z = 0; z < from->size[2]; z++)
        for (uint32_t y = 0; y < from->size[1]; y++)
            for (uint32_t x = 0; x < from->size[0]; x++)
                if (has(from, x, y, z))
                    add(to, x / 2, y / 2, z / 2);
}

/* Cubes of the finer grid within members of the coarser one. */
static uint64_t count_halves(const byte_grid *coarse, const byte_grid *fine) {
    uint64_t n = 0;
    for (uint32_t z = 0; z < fine->size[2]; z++)
        for (uint32_t y = 0; y < fine->size[1]; y++)
            for (uint32_t x = 0; x < fine->size[0]; x++)
                n += (uint64_t)has(coarse, x / 2, y / 2, z / 2);
    return n;
}

/* Corners of the members, which are cubes of `cube` cells. */
static uint64_t count_corners(const byte_grid *cubes, uint32_t cube, const uint32_t cells[3]) {
    byte_grid corners = make_grid(cells, 1, 1);
    for (uint32_t z = 0; z < corners.size[2]; z++)
        for (uint32_t y = 0; y < corners.size[1]; y++)
            for (uint32_t x = 0; x < corners.size[0]; x++)
                for (uint32_t k = 0; k < 8; k++) { /* the cubes that it may be a corner of, or lie in */
                    const uint32_t dx = k & 1, dy = k >> 1 & 1, dz = k >> 2;
                    if (x < dx || y < dy || z < dz || x - dx >= cells[0] || y - dy >= cells[1] || z - dz >= cells[2])
                        continue;
                    if (has(cubes, (x - dx) / cube, (y - dy) / cube, (z - dz) / cube))
                        add(&corners, x, y, z);
                }
    const uint64_t n = count(&corners);
    free(corners.set);
    return n;
}

static void count_least(const nsdf_grid *grid, const nsdf_mesh_storage *mesh, tally *t) {
    byte_grid level[LEVELS]; /* from single cells up */
    for (int i = 0; i < LEVELS; i++)
        level[i] = make_grid(grid->cells, 1u << i, 0);
    for (uint32_t v = 0; v < mesh->vertex_count; v++) {
        uint32_t corner[3];
        const int axis = edge_of(grid, mesh->positions + 3 * (size_t)v, corner);
        if (axis < 0)
            stop("a vertex is on no edge", NSDF_INTERNAL);
        mark_cells(&level[0], corner, axis);
    }
    for (int i = 1; i < LEVELS; i++)
        mark_parents(&level[i - 1], &level[i]);
    const byte_grid *coarsest = &level[LEVELS - 1];
    t->least_centres += (uint64_t)coarsest->size[0] * coarsest->size[1] * coarsest->size[2];
    for (int i = LEVELS - 1; i > 1; i--)
        t->least_centres += count_halves(&level[i], &level[i - 1]);
    t->least_by_cells += count_corners(&level[0], 1, grid->cells);
    t->least_by_cubes += count_corners(&level[1], 2, grid->cells);
    for (int i = 0; i < LEVELS; i++)
        free(level[i].set);
}

/* Vertices stay on their edges, in normalised units. */
static nsdf_mesher_job job_of(nsdf_decoder *decoder, uint32_t resolution) {
    const nsdf_file_header *header = &decoder->stream.header;
    nsdf_mesher_job job;
    memset(&job, 0, sizeof job);
    job.field = nsdf_segment_field_view(&decoder->field);
    memcpy(job.domain_min, header->domain_min, sizeof job.domain_min);
    memcpy(job.domain_max, header->domain_max, sizeof job.domain_max);
    job.scale = 1;
    job.resolution = resolution;
    job.bound = header->extraction_bound;
    return job;
}

static void count_frame(nsdf_decoder *decoder, double at, uint32_t resolution, tally *t) {
    nsdf_mesh_storage mesh = {0};
    nsdf_status status = nsdf_handle_prepare(decoder, at);
    if (status == NSDF_OK && !decoder->mesher)
        status = nsdf_mesher_create(&decoder->memory, decoder->tasks, &decoder->mesher);
    if (status != NSDF_OK)
        stop("a frame", status);
    const nsdf_mesher_job job = job_of(decoder, resolution);
    status = nsdf_mesher_run(decoder->mesher, &job, &decoder->memory, &mesh);
    if (status != NSDF_OK)
        stop("a mesh", status);
    const nsdf_mesher_stats stats = nsdf_mesher_get_stats(decoder->mesher);
    t->frames++;
    t->vertices += mesh.vertex_count;
    t->centres += stats.centres;
    t->corners += stats.corner_points;
    count_least(&decoder->mesher->grid, &mesh, t);
    nsdf_mesh_storage_free(&decoder->memory, &mesh);
}

static void print(const char *path, uint32_t resolution, const tally *t) {
    const double n = t->frames ? (double)t->frames : 1.0;
    const double all = (double)(t->centres + t->corners), centres = (double)t->least_centres;
    printf("%s at %u: %lu frames, %.0f vertices a frame\n", path, resolution, (unsigned long)t->frames,
           (double)t->vertices / n);
    printf("  centres  %9.0f, the least %9.0f\n", (double)t->centres / n, centres / n);
    printf("  corners  %9.0f, the least %9.0f of crossed cells, %9.0f of crossed cubes of two\n",
           (double)t->corners / n, (double)t->least_by_cells / n, (double)t->least_by_cubes / n);
    printf("  all over the least: %.3f by cells, %.3f by cubes of two\n", all / (centres + (double)t->least_by_cells),
           all / (centres + (double)t->least_by_cubes));
}

int main(int argc, char **argv) {
    nsdf_decoder_options options;
    nsdf_decoder *decoder = NULL;
    nsdf_info info;
    tally t = {0};
    const uint32_t resolution = argc > 2 ? (uint32_t)strtoul(argv[2], NULL, 10) : 0;
    const uint32_t step = argc > 3 ? (uint32_t)strtoul(argv[3], NULL, 10) : 1;
    if (argc < 3 || resolution < 2 || step == 0) {
        fprintf(stderr, "usage: bench_least FILE.nsdf RESOLUTION [STEP]\n");
        return 2;
    }
    nsdf_decoder_options_init(&options);
    options.threads = 1;
    nsdf_status status = nsdf_open_file(&decoder, argv[1], &options, NULL);
    if (status == NSDF_OK)
        status = nsdf_get_info(decoder, &info);
    for (uint32_t frame = 0; status == NSDF_OK && frame < info.frame_count; frame += step) {
        double at;
        status = nsdf_frame_time(decoder, frame, &at);
        if (status == NSDF_OK)
            count_frame(decoder, at, resolution, &t);
    }
    if (status != NSDF_OK)
        stop(argv[1], status);
    print(argv[1], resolution, &t);
    nsdf_close(&decoder);
    return 0;
}
