/* Extraction: whatever the file, the mesh that is given out is closed and oriented, and its numbers are finite. */
#include "fuzz_target.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int compare_edges(const void *a, const void *b) {
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Every directed edge once, and its reverse once. */
static void check_closed(const nsdf_mesh_view *view) {
    const size_t count = 3 * (size_t)view->triangle_count;
    uint64_t *edges = malloc(2 * count * sizeof *edges + 1), *reverse = edges + count;
    if (!edges)
        abort();
    for (size_t i = 0; i < count; i++) {
        const uint64_t from = view->indices[i], to = view->indices[i % 3 == 2 ? i - 2 : i + 1];
        if (from >= view->vertex_count || from == to)
            abort();
        edges[i] = from << 32 | to;
        reverse[i] = to << 32 | from;
    }
    qsort(edges, count, sizeof *edges, compare_edges);
    qsort(reverse, count, sizeof *reverse, compare_edges);
    for (size_t i = 0; i < count; i++)
        if (edges[i] != reverse[i] || (i > 0 && edges[i] == edges[i - 1]))
            abort();
    free(edges);
}

static void check_mesh(const nsdf_mesh *mesh) {
    nsdf_mesh_view view;
    if (nsdf_mesh_get_view(mesh, &view) != NSDF_OK)
        abort();
    for (size_t i = 0; i < 3 * (size_t)view.vertex_count; i++)
        if (!isfinite(view.positions[i]) || (view.normals && !isfinite(view.normals[i])))
            abort();
    check_closed(&view);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    uint8_t choice[FUZZ_CHOICES];
    nsdf_decoder_options options;
    nsdf_mesh_options mesh_options;
    nsdf_decoder *decoder = NULL;
    nsdf_mesh *mesh = NULL;
    fuzz_choices(data, &size, choice);
    fuzz_options_init(&options);
    options.max_memory = (uint64_t)16 << 20;
    nsdf_mesh_options_init(&mesh_options);
    mesh_options.resolution = 2 + (choice[0] & 15);
    mesh_options.projection = choice[0] >> 4 & 3;
    mesh_options.dense = choice[0] >> 6 & 1;
    mesh_options.all_pieces = choice[0] >> 7;
    if (nsdf_open_memory(&decoder, data, size, &options, NULL) == NSDF_OK) {
        if (nsdf_extract_mesh(decoder, 0.03, &mesh_options, &mesh) == NSDF_OK)
            check_mesh(mesh);
        if (nsdf_extract_mesh(decoder, 0.001 * choice[1], &mesh_options, &mesh) == NSDF_OK)
            check_mesh(mesh);
    }
    nsdf_close(&decoder);
    nsdf_mesh_free(&mesh);
    return 0;
}
