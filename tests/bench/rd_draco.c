/* Draco on a mesh sequence, for the rate-distortion bench: simplifies frames, codes their geometry with Draco, decodes
 * it, and writes the decoded meshes.
 *
 *     rd_draco [--keep PERCENT] [--place optimal|endpoint] [--qp BITS] [--every N] -o FOLDER INPUT...
 *
 * Frames 0, N, 2 N, ... of the sequence are coded (every frame by default), at compression level 10.  Standard output
 * has one line a coded frame: frame,triangles,bytes,encode_ms,decode_ms; one thread; encoding counts the
 * simplification.  FOLDER gets draco_NNNN.obj for each of them, and frames.txt, a list with one line for each frame of
 * the sequence: the latest coded mesh.  So the list has as many frames as the input, and those coded are right. */
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "draco_mesh.h"
#include "nsdf/sequence.h"
#include "rd_decimate.h"

enum { EXIT_USAGE = 2, LEVEL = 10, PATH_SIZE = 4096 };

typedef struct request {
    double keep, bits, every; /* percent of the triangles; of a coordinate; frames */
    rd_placement placement;
    const char *folder;
} request;

static double milliseconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

static int failed(const char *what, const char *why) {
    fprintf(stderr, "rd_draco: %s: %s\n", what, why);
    return -1;
}

static int load_surface(const nsdf_input_mesh *mesh, nsdf_surface *surface) {
    const size_t coordinates = 3 * (size_t)mesh->vertex_count, corners = 3 * (size_t)mesh->triangle_count;
    surface->vertex_count = mesh->vertex_count;
    surface->triangle_count = mesh->triangle_count;
    surface->positions = malloc((coordinates + 1) * sizeof *surface->positions);
    surface->indices = malloc((corners + 1) * sizeof *surface->indices);
    if (!surface->positions || !surface->indices)
        return -1;
    for (size_t i = 0; i < coordinates; i++)
        surface->positions[i] = (float)mesh->positions[i];
    memcpy(surface->indices, mesh->indices, corners * sizeof *surface->indices);
    return 0;
}

static int simplify(nsdf_surface *surface, const request *r) {
    const size_t target = (size_t)lround(r->keep / 100 * surface->triangle_count);
    return rd_decimate(surface, target, r->placement);
}

static int write_obj(const char *path, const float *positions, size_t vertex_count, const uint32_t *indices,
                     size_t triangle_count) {
    FILE *file = fopen(path, "w");
    if (!file)
        return failed(path, "cannot be written");
    for (size_t i = 0; i < vertex_count; i++)
        fprintf(file, "v %.9g %.9g %.9g\n", (double)positions[3 * i], (double)positions[3 * i + 1],
                (double)positions[3 * i + 2]);
    for (size_t i = 0; i < triangle_count; i++)
        fprintf(file, "f %u %u %u\n", indices[3 * i] + 1, indices[3 * i + 1] + 1, indices[3 * i + 2] + 1);
    const int bad = ferror(file);
    return fclose(file) || bad ? failed(path, "cannot be written") : 0;
}

static int write_decoded(const char *path, const draco_mesh_decoded *decoded) {
    const size_t vertex_count = draco_mesh_vertex_count(decoded), triangle_count = draco_mesh_triangle_count(decoded);
    float *positions = malloc((3 * vertex_count + 1) * sizeof *positions);
    uint32_t *indices = malloc((3 * triangle_count + 1) * sizeof *indices);
    int result = -1;
    if (positions && indices) {
        draco_mesh_copy(decoded, positions, indices);
        result = write_obj(path, positions, vertex_count, indices, triangle_count);
    } else {
        failed(path, "out of memory");
    }
    free(positions);
    free(indices);
    return result;
}

/* Simplifies, codes, decodes, and prints the frame's line. */
static int code_surface(nsdf_surface *surface, const request *r, uint32_t frame, const char *path) {
    const draco_mesh_options options = {.level = LEVEL, .position_bits = (int)r->bits};
    draco_mesh_bytes bytes;
    draco_mesh_error error;
    const double start = milliseconds();
    if (simplify(surface, r))
        return failed(path, "out of memory");
    if (draco_mesh_encode(surface->positions, NULL, surface->indices, surface->triangle_count, &options, &bytes,
                          &error))
        return failed(path, error.message);
    const double encoded = milliseconds();
    draco_mesh_decoded *decoded = draco_mesh_decode(bytes.data, bytes.size, &error);
    const double end = milliseconds();
    const int result = decoded ? write_decoded(path, decoded) : failed(path, error.message);
    if (result == 0)
        printf("%u,%u,%zu,%.3f,%.3f\n", frame, draco_mesh_triangle_count(decoded), bytes.size, encoded - start,
               end - encoded);
    draco_mesh_decoded_free(decoded);
    draco_mesh_bytes_free(&bytes);
    return result;
}

static int code_frame(nsdf_sequence *sequence, const request *r, uint32_t frame, const char *path) {
    nsdf_input_mesh mesh;
    nsdf_encoder_error error;
    if (nsdf_sequence_load(sequence, frame, &mesh, &error) != NSDF_OK)
        return failed("input", error.message);
    nsdf_surface surface = {0};
    const int result =
        load_surface(&mesh, &surface) ? failed(path, "out of memory") : code_surface(&surface, r, frame, path);
    nsdf_surface_free(&surface);
    return result;
}

static int code_sequence(nsdf_sequence *sequence, const request *r) {
    char path[PATH_SIZE + 32];
    snprintf(path, sizeof path, "%s/frames.txt", r->folder);
    FILE *list = fopen(path, "w");
    if (!list)
        return failed(path, "cannot be written");
    const uint32_t count = nsdf_sequence_frame_count(sequence), every = (uint32_t)r->every;
    int result = 0;
    for (uint32_t i = 0; i < count && result == 0; i++) {
        if (i % every == 0) {
            snprintf(path, sizeof path, "%s/draco_%04u.obj", r->folder, i);
            result = code_frame(sequence, r, i, path);
        }
        fprintf(list, "draco_%04u.obj\n", i - i % every);
    }
    const int bad = ferror(list);
    if (fclose(list) || bad)
        return failed("frames.txt", "cannot be written");
    return result;
}

static int usage_error(const char *what) {
    fprintf(stderr,
            "rd_draco: %s\n"
            "usage: rd_draco [--keep PERCENT] [--place optimal|endpoint] [--qp BITS] [--every N] -o FOLDER "
            "INPUT...\n",
            what);
    return EXIT_USAGE;
}

static int parse_number(const char *text, double low, double high, double *out) {
    char *end;
    *out = strtod(text, &end);
    return end == text || *end || !(*out >= low && *out <= high) ? -1 : 0;
}

static int parse_placement(const char *text, rd_placement *out) {
    *out = strcmp(text, "optimal") == 0 ? RD_PLACE_OPTIMAL : RD_PLACE_ENDPOINT;
    return *out == RD_PLACE_OPTIMAL || strcmp(text, "endpoint") == 0 ? 0 : -1;
}

static int parse_option(int option, const char *value, request *r) {
    switch (option) {
    case 'k':
        return parse_number(value, 0.01, 100, &r->keep);
    case 'p':
        return parse_placement(value, &r->placement);
    case 'q':
        return parse_number(value, 1, 30, &r->bits);
    case 'e':
        return parse_number(value, 1, 1e6, &r->every);
    case 'o':
        r->folder = value;
        return strlen(value) < PATH_SIZE ? 0 : -1;
    default:
        return -1;
    }
}

static int parse(int argc, char **argv, request *r) {
    static const struct option options[] = {
        {"keep", required_argument, NULL, 'k'},   {"place", required_argument, NULL, 'p'},
        {"qp", required_argument, NULL, 'q'},     {"every", required_argument, NULL, 'e'},
        {"output", required_argument, NULL, 'o'}, {NULL, 0, NULL, 0}};
    for (int option; (option = getopt_long(argc, argv, "o:", options, NULL)) != -1;)
        if (parse_option(option, optarg, r))
            return usage_error("bad option or value");
    return r->folder && optind < argc ? 0 : usage_error("-o FOLDER and an input are needed");
}

int main(int argc, char **argv) {
    request r = {.keep = 100, .bits = 11, .every = 1};
    const int code = parse(argc, argv, &r);
    if (code)
        return code;
    nsdf_sequence *sequence = NULL;
    nsdf_encoder_error error;
    int result = -1;
    if (nsdf_sequence_open(&sequence, (const char *const *)(argv + optind), (size_t)(argc - optind), NULL, &error))
        failed("input", error.message);
    else
        result = code_sequence(sequence, &r);
    nsdf_sequence_close(&sequence);
    return result ? EXIT_FAILURE : EXIT_SUCCESS;
}
