/* Writes the blocks of a file at one time as an OBJ: each is drawn as the part of its own surface, the zero set of its
 * polynomial, that lies in a share of its ball, so that neighbours can be told apart.
 *
 *     draw_blocks FILE.nsdf SECONDS OUTPUT.obj [SHARE] */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "handle.h"

enum { CORNERS = 16, STEPS = 4 };

/* Value and gradient of the block's polynomial at d from its centre. */
static double polynomial(const nsdf_block *block, uint32_t degree, const double d[3], double gradient[3]) {
    double sum = 0;
    memset(gradient, 0, 3 * sizeof *gradient);
    for (uint32_t a = 0; a <= degree; a++)
        for (uint32_t b = 0; a + b <= degree; b++)
            for (uint32_t c = 0; a + b + c <= degree; c++) {
                const double k = (double)block->terms[nsdf_block_term(a, b, c)];
                const double x = pow(d[0], a), y = pow(d[1], b), z = pow(d[2], c);
                sum += k * x * y * z;
                gradient[0] += a ? k * a * pow(d[0], a - 1) * y * z : 0;
                gradient[1] += b ? k * b * x * pow(d[1], b - 1) * z : 0;
                gradient[2] += c ? k * c * x * y * pow(d[2], c - 1) : 0;
            }
    return sum;
}

/* Moves d onto the zero set along the gradient. */
static void project(const nsdf_block *block, uint32_t degree, double d[3]) {
    for (int step = 0; step < STEPS; step++) {
        double g[3];
        const double f = polynomial(block, degree, d, g), square = g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
        for (int i = 0; i < 3 && square > 0; i++)
            d[i] -= f * g[i] / square;
    }
}

/* How far the ball's rim is from its centre along a vector, over the vector's length. */
static double rim(const nsdf_block *block, const double v[3]) {
    const float *q = block->shape;
    return 1.0 / sqrt((double)q[0] * v[0] * v[0] + (double)q[1] * v[0] * v[1] + (double)q[2] * v[0] * v[2] +
                      (double)q[3] * v[1] * v[1] + (double)q[4] * v[1] * v[2] + (double)q[5] * v[2] * v[2]);
}

static void write_vertex(FILE *file, const nsdf_block *block, const nsdf_file_header *header, const double d[3]) {
    double x[3];
    for (int k = 0; k < 3; k++)
        x[k] = ((double)block->centre[k] + d[k]) * header->scale + header->centre[k];
    fprintf(file, "v %.6g %.6g %.6g\n", x[0], x[1], x[2]);
}

/* Two vectors across n that make a right-handed system with it. */
static void across(const double n[3], double s[3], double t[3]) {
    const int least = fabs(n[0]) < fabs(n[1]) ? (fabs(n[0]) < fabs(n[2]) ? 0 : 2) : (fabs(n[1]) < fabs(n[2]) ? 1 : 2);
    double e[3] = {0, 0, 0}, length = 0;
    e[least] = 1;
    for (int i = 0; i < 3; i++)
        s[i] = e[(i + 1) % 3] * n[(i + 2) % 3] - e[(i + 2) % 3] * n[(i + 1) % 3];
    for (int i = 0; i < 3; i++)
        length += s[i] * s[i];
    for (int i = 0; i < 3; i++)
        s[i] /= sqrt(length);
    for (int i = 0; i < 3; i++)
        t[i] = n[(i + 1) % 3] * s[(i + 2) % 3] - n[(i + 2) % 3] * s[(i + 1) % 3];
}

/* A disc of triangles round the middle; returns the vertices written. */
static uint32_t write_patch(FILE *file, const nsdf_block *block, uint32_t degree, const nsdf_file_header *header,
                            double share, uint32_t first) {
    double middle[3] = {0, 0, 0}, n[3], s[3], t[3], length = 0;
    project(block, degree, middle);
    (void)polynomial(block, degree, middle, n);
    for (int i = 0; i < 3; i++)
        length += n[i] * n[i];
    for (int i = 0; i < 3; i++)
        n[i] /= sqrt(length);
    across(n, s, t);
    write_vertex(file, block, header, middle);
    for (int c = 0; c < CORNERS; c++) {
        const double angle = 2 * acos(-1.0) * c / CORNERS;
        double way[3], d[3];
        for (int i = 0; i < 3; i++)
            way[i] = cos(angle) * s[i] + sin(angle) * t[i];
        for (int i = 0; i < 3; i++)
            d[i] = middle[i] + share * rim(block, way) * way[i];
        project(block, degree, d);
        write_vertex(file, block, header, d);
    }
    for (uint32_t c = 0; c < CORNERS; c++)
        fprintf(file, "f %u %u %u\n", first, first + 1 + c, first + 1 + (c + 1) % CORNERS);
    return CORNERS + 1;
}

static int write_blocks(FILE *file, nsdf_decoder *decoder, double share) {
    const nsdf_segment_part *part = decoder->field.segments[0]->parts;
    uint32_t first = 1;
    if (part->kind != NSDF_PART_BLOCKS)
        return -1;
    for (uint32_t k = 0; k < part->desc.blocks.block_count; k++) {
        const nsdf_block *block = &part->at.blocks.blocks[k];
        if (block->radius > 0.0f && block->life > 0.5f)
            first += write_patch(file, block, part->desc.blocks.degree, &decoder->stream.header, share, first);
    }
    return 0;
}

int main(int argc, char **argv) {
    nsdf_decoder *decoder = NULL;
    nsdf_error error;
    if (argc < 4) {
        fprintf(stderr, "usage: draw_blocks FILE.nsdf SECONDS OUTPUT.obj [SHARE]\n");
        return 2;
    }
    nsdf_status status = nsdf_open_file(&decoder, argv[1], NULL, &error);
    if (status == NSDF_OK)
        status = nsdf_handle_prepare(decoder, strtod(argv[2], NULL));
    FILE *file = status == NSDF_OK ? fopen(argv[3], "w") : NULL;
    int failed = !file || write_blocks(file, decoder, argc > 4 ? strtod(argv[4], NULL) : 0.4) != 0;
    failed |= file && fclose(file) != 0;
    nsdf_close(&decoder);
    if (failed)
        fprintf(stderr, "draw_blocks: %s has no blocks, or a file cannot be used\n", argv[1]);
    return failed;
}
