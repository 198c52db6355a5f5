/* nsdf-sample: writes a moving surface as a sequence of OBJ files. */
#include "shapes.h"

#include <errno.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { EXIT_USAGE = 2, MAX_FRAMES = 9999, MIN_RESOLUTION = 8, MAX_RESOLUTION = 512 };

typedef struct request {
    const nsdf_shape *shape;
    const char *folder;
    long frames, resolution, seed;
    double fps;
    int quiet;
} request;

static void print_help(void) {
    printf("Usage: nsdf-sample [options] NAME -o FOLDER\n"
           "Writes a moving surface as FOLDER/NAME_0000.obj, NAME_0001.obj, ...  Every frame is a closed mesh with\n"
           "outward triangles; connectivity and vertices change from frame to frame.\n\n"
           "Names:\n");
    size_t count;
    const nsdf_shape *shapes = nsdf_shapes(&count);
    for (size_t i = 0; i < count; i++)
        printf("  %-10s  %s\n", shapes[i].name, shapes[i].summary);
    printf(
        "\nOptions:\n"
        "  -o, --output FOLDER   where to write; made if it is missing\n"
        "      --frames N        frames, 1 to %d (48)\n"
        "      --resolution R    detail: triangles about as small as those of a grid with R cells along the longest\n"
        "                        side of the shape's box, %d to %d (64)\n"
        "      --fps F           frames per second of the motion (24)\n"
        "      --seed S          other meshes of the same surfaces (1)\n"
        "  -q, --quiet           say nothing\n"
        "  -h, --help            this text\n",
        MAX_FRAMES, MIN_RESOLUTION, MAX_RESOLUTION);
}

static int usage_error(const char *what, const char *value) {
    fprintf(stderr, "nsdf-sample: %s%s%s (--help lists the options)\n", what, value ? ": " : "", value ? value : "");
    return EXIT_USAGE;
}

static int parse_count(const char *text, long low, long high, long *out) {
    char *end;
    errno = 0;
    *out = strtol(text, &end, 10);
    return errno || end == text || *end || *out < low || *out > high ? -1 : 0;
}

static int parse_option(int option, const char *value, request *r) {
    char *end;
    switch (option) {
    case 'o':
        r->folder = value;
        return 0;
    case 'n':
        return parse_count(value, 1, MAX_FRAMES, &r->frames) ? usage_error("bad --frames", value) : 0;
    case 'r':
        return parse_count(value, MIN_RESOLUTION, MAX_RESOLUTION, &r->resolution)
                   ? usage_error("bad --resolution", value)
                   : 0;
    case 's':
        return parse_count(value, 0, 2147483647, &r->seed) ? usage_error("bad --seed", value) : 0;
    case 'f':
        r->fps = strtod(value, &end);
        return end == value || *end || !(r->fps >= 0.001 && r->fps <= 1e6) ? usage_error("bad --fps", value) : 0;
    case 'q':
        r->quiet = 1;
        return 0;
    default:
        return usage_error("bad option", NULL);
    }
}

/* Returns -1 to go on, or the program's exit code. */
static int parse_arguments(int argc, char **argv, request *r) {
    static const struct option options[] = {{"output", required_argument, NULL, 'o'},
                                            {"frames", required_argument, NULL, 'n'},
                                            {"resolution", required_argument, NULL, 'r'},
                                            {"fps", required_argument, NULL, 'f'},
                                            {"seed", required_argument, NULL, 's'},
                                            {"quiet", no_argument, NULL, 'q'},
                                            {"help", no_argument, NULL, 'h'},
                                            {NULL, 0, NULL, 0}};
    int option;
    while ((option = getopt_long(argc, argv, "o:qh", options, NULL)) != -1) {
        if (option == 'h') {
            print_help();
            return fflush(stdout) ? EXIT_FAILURE : EXIT_SUCCESS;
        }
        int status = parse_option(option, optarg, r);
        if (status)
            return status;
    }
    if (optind + 1 != argc)
        return usage_error(optind == argc ? "which shape? give a NAME" : "one NAME only", NULL);
    r->shape = nsdf_shape_find(argv[optind]);
    if (!r->shape)
        return usage_error("no shape of that name", argv[optind]);
    return r->folder ? -1 : usage_error("where to? give -o FOLDER", NULL);
}

/* Makes the folder and those above it, as mkdir -p. */
static int make_folder(const char *path) {
    char *copy = strdup(path);
    if (!copy)
        return -1;
    for (char *slash = strchr(copy + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = 0;
        mkdir(copy, 0777); /* a failure that matters shows when the last folder is made */
        *slash = '/';
    }
    int status = mkdir(copy, 0777) && errno != EEXIST ? -1 : 0;
    free(copy);
    return status;
}

static int print_mesh(FILE *file, const request *r, long frame, const nsdf_implicit_mesh *mesh) {
    fprintf(file, "# nsdf-sample %s, frame %ld: %zu vertices, %zu triangles\n", r->shape->name, frame,
            mesh->vertex_count, mesh->triangle_count);
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        const double *p = mesh->positions + 3 * i;
        fprintf(file, "v %.6f %.6f %.6f\n", p[0], p[1], p[2]);
    }
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *t = mesh->triangles + 3 * i;
        fprintf(file, "f %lu %lu %lu\n", t[0] + 1ul, t[1] + 1ul, t[2] + 1ul);
    }
    return ferror(file) ? -1 : 0;
}

/* Under a temporary name first, so that no reader ever sees half a frame.  On failure errno says why. */
static int write_file(const request *r, long frame, const nsdf_implicit_mesh *mesh, const char *path,
                      const char *temporary) {
    FILE *file = fopen(temporary, "w");
    if (!file)
        return -1;
    int status = print_mesh(file, r, frame, mesh);
    if (fclose(file))
        status = -1;
    if (status == 0)
        status = rename(temporary, path);
    if (status) {
        int reason = errno;
        remove(temporary);
        errno = reason;
    }
    return status;
}

static int write_frame(const request *r, long frame, const nsdf_implicit_mesh *mesh) {
    size_t room = strlen(r->folder) + 64;
    char *path = malloc(room), *temporary = malloc(room);
    int status = -1;
    if (path && temporary) {
        snprintf(path, room, "%s/%s_%04ld.obj", r->folder, r->shape->name, frame);
        snprintf(temporary, room, "%s/%s_%04ld.obj.tmp", r->folder, r->shape->name, frame);
        status = write_file(r, frame, mesh, path, temporary);
    }
    if (status)
        fprintf(stderr, "nsdf-sample: cannot write frame %ld in %s: %s\n", frame, r->folder, strerror(errno));
    free(path);
    free(temporary);
    return status;
}

static int write_sequence(const request *r) {
    nsdf_shape_pose *pose = malloc(sizeof *pose);
    nsdf_implicit_mesh mesh = {0};
    size_t triangles = 0;
    long frame = 0;
    if (!pose)
        return -1;
    for (; frame < r->frames; frame++) {
        memset(pose, 0, sizeof *pose);
        r->shape->pose((double)frame / r->fps, pose);
        nsdf_implicit_field field = nsdf_shape_field(r->shape, pose);
        double spacing =
            1.5 * nsdf_shape_extent(r->shape) / (double)r->resolution; /* a surface cell has many triangles */
        uint64_t seed = (uint64_t)r->seed << 32 | (uint64_t)frame;
        if (nsdf_implicit_extract(&field, spacing, seed, &mesh)) {
            fprintf(stderr, "nsdf-sample: out of memory\n");
            break;
        }
        if (write_frame(r, frame, &mesh))
            break;
        triangles += mesh.triangle_count;
    }
    if (frame == r->frames && !r->quiet)
        fprintf(stderr, "nsdf-sample: %ld frames of %s, %zu triangles each on average, in %s\n", r->frames,
                r->shape->name, triangles / (size_t)r->frames, r->folder);
    nsdf_implicit_mesh_free(&mesh);
    free(pose);
    return frame == r->frames ? 0 : -1;
}

int main(int argc, char **argv) {
    request r = {.frames = 48, .resolution = 64, .seed = 1, .fps = 24};
    int status = parse_arguments(argc, argv, &r);
    if (status >= 0)
        return status;
    if (make_folder(r.folder)) {
        fprintf(stderr, "nsdf-sample: cannot make folder %s: %s\n", r.folder, strerror(errno));
        return EXIT_FAILURE;
    }
    return write_sequence(&r) ? EXIT_FAILURE : EXIT_SUCCESS;
}
