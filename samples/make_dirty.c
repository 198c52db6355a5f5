/* nsdf-dirty: mesh sequences with faults, to test with. */
#include "dirty_mesh.h"

#include <dirent.h>
#include <errno.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { MOST_FRAMES = 100000, MOST_LINE = 4096, EXIT_USAGE = 2 };

typedef struct {
    const char *base, *folder;
    char **faults;
    int fault_count, each;
    long frames, seed;
} request;

static const char usage[] =
    "Usage: nsdf-dirty [options] BASE [FAULT...] -o FOLDER\n"
    "Writes a mesh sequence with faults as OBJ files.  BASE is a folder of OBJ files or one of the shapes below; "
    "faults\n"
    "are applied in the order given.\n"
    "\n"
    "  -o, --output FOLDER   where to write; made if it is missing, its parent is not\n"
    "      --frames N        of a shape (8); of a folder the first N\n"
    "      --seed S          other faces are hit (1)\n"
    "      --each            other faces are hit in each frame; without it those of the same numbers\n"
    "  -h, --help            this text\n"
    "\nShapes:\n";

static int usage_error(const char *what, const char *value) {
    fprintf(stderr, "nsdf-dirty: %s%s%s (--help lists the options)\n", what, value ? ": " : "", value ? value : "");
    return EXIT_USAGE;
}

static int parse_count(const char *text, long low, long *out) {
    char *end;
    *out = strtol(text, &end, 10);
    return end == text || *end || *out < low || *out > MOST_FRAMES ? -1 : 0;
}

/* Returns -1 to go on, or the program's exit code. */
static int parse_arguments(int argc, char **argv, request *r) {
    static const struct option options[] = {
        {"output", required_argument, NULL, 'o'}, {"frames", required_argument, NULL, 'n'},
        {"seed", required_argument, NULL, 's'},   {"each", no_argument, NULL, 'e'},
        {"help", no_argument, NULL, 'h'},         {NULL, 0, NULL, 0}};
    int option;
    while ((option = getopt_long(argc, argv, "o:h", options, NULL)) != -1) {
        if (option == 'h') {
            printf("%s%s\nFaults:\n%s", usage, dirty_shapes_help, dirty_faults_help);
            return fflush(stdout) ? EXIT_FAILURE : EXIT_SUCCESS;
        }
        if (option == 'o')
            r->folder = optarg;
        else if (option == 'e')
            r->each = 1;
        else if (option != 'n' && option != 's')
            return usage_error("bad option", NULL);
        else if (parse_count(optarg, option == 'n', option == 'n' ? &r->frames : &r->seed) != 0)
            return usage_error(option == 'n' ? "bad --frames" : "bad --seed", optarg);
    }
    if (optind >= argc)
        return usage_error("what shape or folder? give a BASE", NULL);
    r->base = argv[optind];
    r->faults = argv + optind + 1;
    r->fault_count = argc - optind - 1;
    return r->folder ? -1 : usage_error("where to? give -o FOLDER", NULL);
}

/* ---- Frames ------------------------------------------------------------------------------------------------ */

static int is_obj(const struct dirent *entry) {
    const size_t length = strlen(entry->d_name);
    return length > 4 && strcmp(entry->d_name + length - 4, ".obj") == 0;
}

/* One line of an OBJ file; polygons become fans.  Positive indices only. */
static int read_line(char *line, dirty_mesh *m) {
    double p[3];
    if (line[0] == 'v' && line[1] == ' ')
        return sscanf(line + 2, "%lf %lf %lf", p, p + 1, p + 2) == 3 ? dirty_mesh_add_vertex(m, p[0], p[1], p[2]) : -1;
    if (line[0] != 'f' || line[1] != ' ')
        return 0;
    unsigned long first = 0, before = 0;
    int corners = 0;
    for (char *word = strtok(line + 2, " \t\r\n"); word; word = strtok(NULL, " \t\r\n")) {
        const unsigned long index = strtoul(word, NULL, 10);
        if (index < 1 || index > m->vertex_count ||
            (corners >= 2 && dirty_mesh_add_triangle(m, first - 1, before - 1, index - 1) != 0))
            return -1;
        first = corners == 0 ? index : first;
        before = index;
        corners++;
    }
    return 0;
}

static int read_obj(const char *folder, const char *name, dirty_mesh *m) {
    char path[MOST_LINE], line[MOST_LINE];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "r");
    int failed = !file;
    while (!failed && fgets(line, sizeof line, file))
        failed = read_line(line, m) != 0;
    if (file)
        fclose(file);
    return failed ? -1 : 0;
}

static int write_obj(const request *r, long frame, const dirty_mesh *m) {
    char path[MOST_LINE];
    snprintf(path, sizeof path, "%s/dirty_%04ld.obj", r->folder, frame);
    FILE *file = fopen(path, "w");
    if (!file)
        return -1;
    for (size_t i = 0; i < m->vertex_count; i++)
        fprintf(file, "v %.9g %.9g %.9g\n", m->positions[3 * i], m->positions[3 * i + 1], m->positions[3 * i + 2]);
    for (size_t i = 0; i < m->triangle_count; i++)
        fprintf(file, "f %lu %lu %lu\n", m->triangles[3 * i] + 1ul, m->triangles[3 * i + 1] + 1ul,
                m->triangles[3 * i + 2] + 1ul);
    const int failed = ferror(file);
    return fclose(file) || failed ? -1 : 0;
}

/* `name` is the file's, or NULL for a shape. */
static int make_frame(const request *r, const char *name, long frame, long count) {
    dirty_mesh m = {0};
    const double time = count > 1 ? (double)frame / (double)(count - 1) : 0.0;
    int status = name ? read_obj(r->base, name, &m) : dirty_shape(r->base, time, &m);
    if (status) {
        dirty_mesh_free(&m);
        if (status > 0)
            return usage_error("no folder or shape of that name", r->base);
        fprintf(stderr, "nsdf-dirty: cannot make '%s%s%s'\n", r->base, name ? "/" : "", name ? name : "");
        return EXIT_FAILURE;
    }
    const uint64_t seed = (uint64_t)r->seed + (r->each ? (uint64_t)(frame + 1) << 20 : 0);
    for (int i = 0; i < r->fault_count && !status; i++)
        status = dirty_apply(r->faults[i], seed, &m) > 0 ? usage_error("no such fault, or amount", r->faults[i]) : 0;
    if (!status && write_obj(r, frame, &m) != 0) {
        fprintf(stderr, "nsdf-dirty: cannot write frame %ld in %s: %s\n", frame, r->folder, strerror(errno));
        status = EXIT_FAILURE;
    }
    dirty_mesh_free(&m);
    return status;
}

static int is_shape(const char *name) {
    dirty_mesh m = {0};
    const int status = dirty_shape(name, 0.0, &m);
    dirty_mesh_free(&m);
    return status != 1;
}

int main(int argc, char **argv) {
    request r = {.seed = 1};
    int status = parse_arguments(argc, argv, &r);
    if (status >= 0)
        return status;
    if (mkdir(r.folder, 0777) && errno != EEXIST) {
        fprintf(stderr, "nsdf-dirty: cannot make folder %s: %s\n", r.folder, strerror(errno));
        return EXIT_FAILURE;
    }
    struct dirent **names = NULL;
    const int found = is_shape(r.base) ? -1 : scandir(r.base, &names, is_obj, alphasort);
    const long all = found >= 0 ? found : 8, count = r.frames > 0 && (found < 0 || r.frames < all) ? r.frames : all;
    status = EXIT_SUCCESS;
    for (long i = 0; i < count && status == EXIT_SUCCESS; i++)
        status = make_frame(&r, found >= 0 ? names[i]->d_name : NULL, i, count);
    for (int i = 0; i < found; i++)
        free(names[i]);
    free(names);
    return status;
}
