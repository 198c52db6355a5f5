/* nsdf-render: draws OBJ meshes side by side into a PNG picture, all seen by the same camera. */
#include "png_write.h"
#include "render_draw.h"

#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EXIT_USAGE = 2, MAX_COLOURS = 16, MAX_PIXELS = 1 << 28 };

typedef struct request {
    const char *output;
    char **inputs;
    uint32_t input_count, size, columns, colour_count;
    double turn, rise, colours[MAX_COLOURS][3];
} request;

static const char help[] = "Usage: nsdf-render [options] -o PICTURE.png MESH.obj...\n"
                           "Draws the meshes side by side, all of them seen by the same camera.\n\n"
                           "  -o, --output FILE     the PNG picture to write\n"
                           "      --size N          width and height of each mesh's tile in pixels, 16 to 4096 (480)\n"
                           "      --columns N       tiles in a row (all in one row)\n"
                           "      --turn DEGREES    turn the camera around the vertical axis (30)\n"
                           "      --rise DEGREES    lift the camera above the horizon, -89 to 89 (12)\n"
                           "      --colours LIST    RRGGBB,RRGGBB,...: surface colours, used in turn (c8c2b8)\n"
                           "  -h, --help            this text\n";

static int usage_error(const char *what, const char *value) {
    fprintf(stderr, "nsdf-render: %s%s%s (--help lists the options)\n", what, value ? ": " : "", value ? value : "");
    return EXIT_USAGE;
}

static int parse_number(const char *text, double low, double high, double *out) {
    char *end;
    *out = strtod(text, &end);
    return end == text || *end || !(*out >= low && *out <= high) ? -1 : 0;
}

static int parse_count(const char *text, uint32_t low, uint32_t high, uint32_t *out) {
    double value;
    if (parse_number(text, low, high, &value) || value != floor(value))
        return -1;
    *out = (uint32_t)value;
    return 0;
}

static int parse_colours(const char *text, request *r) {
    r->colour_count = 0;
    for (;;) {
        char *end;
        unsigned long rgb = strtoul(text, &end, 16);
        if (end != text + 6 || r->colour_count == MAX_COLOURS)
            return -1;
        for (int i = 0; i < 3; i++)
            r->colours[r->colour_count][i] = pow((double)(rgb >> (16 - 8 * i) & 255) / 255, 2.2);
        r->colour_count++;
        if (*end != ',')
            return *end ? -1 : 0;
        text = end + 1;
    }
}

static int parse_option(int option, const char *value, request *r) {
    switch (option) {
    case 'o':
        r->output = value;
        return 0;
    case 's':
        return parse_count(value, 16, 4096, &r->size) ? usage_error("bad --size", value) : 0;
    case 'n':
        return parse_count(value, 1, 1000, &r->columns) ? usage_error("bad --columns", value) : 0;
    case 't':
        return parse_number(value, -1e6, 1e6, &r->turn) ? usage_error("bad --turn", value) : 0;
    case 'r':
        return parse_number(value, -89, 89, &r->rise) ? usage_error("bad --rise", value) : 0;
    case 'c':
        return parse_colours(value, r) ? usage_error("bad --colours", value) : 0;
    default:
        return usage_error("bad option", NULL);
    }
}

/* Returns -1 to go on, or the program's exit code. */
static int parse_arguments(int argc, char **argv, request *r) {
    static const struct option options[] = {
        {"output", required_argument, NULL, 'o'},  {"size", required_argument, NULL, 's'},
        {"columns", required_argument, NULL, 'n'}, {"turn", required_argument, NULL, 't'},
        {"rise", required_argument, NULL, 'r'},    {"colours", required_argument, NULL, 'c'},
        {"help", no_argument, NULL, 'h'},          {NULL, 0, NULL, 0}};
    int option;
    while ((option = getopt_long(argc, argv, "o:h", options, NULL)) != -1) {
        if (option == 'h')
            return fputs(help, stdout) < 0 || fflush(stdout) ? EXIT_FAILURE : EXIT_SUCCESS;
        int status = parse_option(option, optarg, r);
        if (status)
            return status;
    }
    r->inputs = argv + optind;
    r->input_count = (uint32_t)(argc - optind);
    if (!r->input_count)
        return usage_error("which meshes? give OBJ files", NULL);
    if (!r->output)
        return usage_error("where to? give -o PICTURE.png", NULL);
    if (!r->columns || r->columns > r->input_count)
        r->columns = r->input_count;
    uint64_t rows = (r->input_count + r->columns - 1) / r->columns;
    if (rows * r->columns * r->size * r->size > MAX_PIXELS)
        return usage_error("the picture would be too large", NULL);
    return -1;
}

static void grow_box(nsdf_render_view *view, const nsdf_render_mesh *mesh) {
    for (size_t i = 0; i < 3 * mesh->vertex_count; i++) {
        view->box_min[i % 3] = fmin(view->box_min[i % 3], mesh->positions[i]);
        view->box_max[i % 3] = fmax(view->box_max[i % 3], mesh->positions[i]);
    }
}

static int read_meshes(const request *r, nsdf_render_mesh *meshes, nsdf_render_view *view) {
    for (uint32_t i = 0; i < r->input_count; i++) {
        const char *failure = nsdf_render_mesh_read(r->inputs[i], &meshes[i]);
        if (failure) {
            fprintf(stderr, "nsdf-render: %s: %s\n", r->inputs[i], failure);
            return -1;
        }
        grow_box(view, &meshes[i]);
    }
    return 0;
}

static int draw_sheet(const request *r, const nsdf_render_mesh *meshes, nsdf_render_view *view) {
    uint32_t rows = (r->input_count + r->columns - 1) / r->columns;
    size_t stride = (size_t)r->columns * r->size * 3;
    uint8_t *rgb = malloc(stride * rows * r->size);
    int status = rgb ? 0 : -1;
    if (rgb)
        memset(rgb, 255, stride * rows * r->size);
    for (uint32_t i = 0; status == 0 && i < r->input_count; i++) {
        uint8_t *tile = rgb + i / r->columns * stride * r->size + (size_t)(i % r->columns) * r->size * 3;
        memcpy(view->colour, r->colours[i % r->colour_count], sizeof view->colour);
        status = nsdf_render_draw(&meshes[i], view, r->size, tile, stride);
    }
    if (status)
        fprintf(stderr, "nsdf-render: out of memory\n");
    else if ((status = nsdf_png_write(r->output, rgb, r->columns * r->size, rows * r->size)) != 0)
        fprintf(stderr, "nsdf-render: cannot write %s: %s\n", r->output, strerror(errno));
    free(rgb);
    return status;
}

int main(int argc, char **argv) {
    request r = {.size = 480, .turn = 30, .rise = 12};
    parse_colours("c8c2b8", &r);
    int status = parse_arguments(argc, argv, &r);
    if (status >= 0)
        return status;
    nsdf_render_view view = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, r.turn, r.rise, {0}};
    nsdf_render_mesh *meshes = calloc(r.input_count, sizeof *meshes);
    status = meshes && read_meshes(&r, meshes, &view) == 0 ? draw_sheet(&r, meshes, &view) : -1;
    for (uint32_t i = 0; meshes && i < r.input_count; i++)
        nsdf_render_mesh_free(&meshes[i]);
    free(meshes);
    return status ? EXIT_FAILURE : EXIT_SUCCESS;
}
