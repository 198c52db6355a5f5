#include "lost_pieces.h"

#include "decoded_surface.h"
#include "sdf.h"
#include "surface_error.h"

#include <math.h>
#include <stdlib.h>

/* Vertices of a piece's triangles, and those that are not astray. */
typedef struct {
    uint32_t all, near;
} tally;

static void count_near(const nsdf_surface *decoded, const uint32_t *piece, const float *size, const nsdf_sdf *input,
                       tally *tallies) {
    for (uint32_t i = 0; i < decoded->triangle_count; i++) {
        tally *of = &tallies[piece[i]];
        if (size[piece[i]] < NSDF_LEAST_LOST)
            continue;
        of->all++;
        of->near += nsdf_sdf_is_within(input, decoded->positions + 3 * (size_t)decoded->indices[3 * (size_t)i],
                                       NSDF_STRAY_DISTANCE);
    }
}

static int find(const nsdf_surface *decoded, const nsdf_sdf *input, float *smallest) {
    uint32_t *piece = malloc(((size_t)decoded->triangle_count + 1) * sizeof *piece);
    const int64_t count = piece ? nsdf_surface_components(decoded, piece) : -1;
    float *size = count > 0 ? malloc((size_t)count * sizeof *size) : NULL;
    tally *tallies = count > 0 ? calloc((size_t)count, sizeof *tallies) : NULL;
    int failed = count < 0 || (count > 0 && (!size || !tallies));
    if (count > 0 && !failed)
        failed = nsdf_piece_sizes(decoded, piece, (uint32_t)count, size) != 0;
    if (count > 0 && !failed) {
        count_near(decoded, piece, size, input, tallies);
        for (int64_t p = 0; p < count; p++)
            if (tallies[p].all > 0 && 2 * tallies[p].near >= tallies[p].all)
                *smallest = fminf(*smallest, size[p]);
    }
    free(tallies);
    free(size);
    free(piece);
    return failed ? -1 : 0;
}

nsdf_status nsdf_find_lost_pieces(nsdf_decoder *decoder, double t, const nsdf_file_header *header,
                                  const nsdf_surface *input, float *smallest) {
    nsdf_mesh_options options;
    nsdf_mesh *mesh = NULL;
    nsdf_surface decoded = {0};
    nsdf_mesh_options_init(&options);
    options.normals = 0;
    options.all_pieces = 1;
    nsdf_status status = nsdf_extract_mesh(decoder, t, &options, &mesh);
    nsdf_sdf *sdf = status == NSDF_OK ? nsdf_sdf_create_unsigned(input) : NULL;
    if (status == NSDF_OK &&
        (!sdf || nsdf_decoded_surface(header, mesh, &decoded) != 0 || find(&decoded, sdf, smallest) != 0))
        status = NSDF_NO_MEMORY;
    nsdf_sdf_free(sdf);
    nsdf_surface_free(&decoded);
    nsdf_mesh_free(&mesh);
    return status;
}
