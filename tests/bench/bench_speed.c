/* The speed bench's measures as CSV rows on standard output, after lines "# what: value" about the machine and the
 * build.  The script `speed` beside it makes the input and puts everything together.
 *
 *     bench_speed [--quick | --tiny] [--sections LIST] [--frames INPUT] FILE.nsdf */
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench_peak.h"
#include "bench_speed.h"
#include "fit_kernels.h"

enum { EXIT_USAGE = 2 };

static const char usage[] = "usage: bench_speed [--quick | --tiny] [--sections LIST] [--frames INPUT] FILE.nsdf\n"
                            "  --quick           fewer runs and frames\n"
                            "  --tiny            as little as there can be of everything: for tests\n"
                            "  --sections LIST   of sdf,fit,decode,draco, with commas between them (all)\n"
                            "  --frames INPUT    the frames that the file was made from: a folder, or what nsdf-enc "
                            "takes else; their first mesh\n"
                            "                    answers the distance queries, and Draco codes some of them\n";

static const struct {
    const char *name;
    int (*run)(const bench_speed_options *options);
} sections[] = {
    {"sdf", bench_speed_sdf}, {"fit", bench_speed_fit}, {"decode", bench_speed_decode}, {"draco", bench_speed_draco}};

static const bench_speed_options full = {{40, 7, 15.0, 0.004}, {1, 2}, 20000, 1 << 16, 2048, {32, 64, 80, 128, 256},
                                         {64, 128, 256, 512},  5,      NULL,  NULL};
static const bench_speed_options quick = {{15, 4, 4.0, 0.003}, {1, 2}, 10000, 1 << 15, 2048, {32, 64, 80, 128, 256},
                                          {64, 128, 256, 512}, 2,      NULL,  NULL};
static const bench_speed_options tiny = {{1, 1, 0.0, 0.0},       {1, 2},   100, 1 << 10, 64,
                                         {32, 64, 80, 128, 256}, {16, 32}, 2,   NULL,    NULL};

typedef struct request {
    bench_speed_options options;
    const char *sections;
} request;

/* ---- About the machine ------------------------------------------------------------------------------------- */

static void print_cpu(void) {
    char line[256];
    FILE *file = fopen("/proc/cpuinfo", "r");
    while (file && fgets(line, sizeof line, file)) {
        const char *value = strchr(line, ':');
        if (strncmp(line, "model name", strlen("model name")) == 0 && value) {
            printf("# cpu: %s", value + 2);
            break;
        }
    }
    if (file)
        fclose(file);
}

static void print_context(void) {
    nsdf_workers *all = bench_checked(nsdf_workers_create(0));
    print_cpu();
    printf("# cores: %lu\n", (unsigned long)nsdf_workers_count(all));
    printf("# fastest instruction set: %s\n", bench_isa_name(bench_isa_best()));
#if defined(__clang__)
    printf("# compiler: %s\n", __VERSION__);
#else
    printf("# compiler: gcc %s\n", __VERSION__);
#endif
    printf("# OpenBLAS: %s\n", bench_peak_blas());
    printf("# Draco: %s\n", bench_speed_draco_version());
    nsdf_workers_free(all);
}

/* ---- The request ------------------------------------------------------------------------------------------- */

static int is_listed(const char *list, const char *name) {
    const size_t length = strlen(name);
    for (const char *at = list; at; at = strchr(at, ',')) {
        at += *at == ',';
        if (strncmp(at, name, length) == 0 && (at[length] == ',' || at[length] == '\0'))
            return 1;
    }
    return 0;
}

/* 0, or -1 for an option that is not known. */
static int parse(int argc, char **argv, request *r) {
    static const struct option names[] = {{"quick", no_argument, NULL, 'q'},
                                          {"tiny", no_argument, NULL, 't'},
                                          {"sections", required_argument, NULL, 's'},
                                          {"frames", required_argument, NULL, 'f'},
                                          {NULL, 0, NULL, 0}};
    const char *input = NULL;
    *r = (request){full, "sdf,fit,decode,draco"};
    for (int option; (option = getopt_long(argc, argv, "", names, NULL)) != -1;) {
        if (option == '?')
            return -1;
        if (option == 'q' || option == 't')
            r->options = option == 'q' ? quick : tiny;
        if (option == 's')
            r->sections = optarg;
        if (option == 'f')
            input = optarg;
    }
    r->options.input = input;
    r->options.file = argv[optind];
    return argc - optind == 1 ? 0 : -1;
}

int main(int argc, char **argv) {
    request r;
    int failed = 0;
    if (parse(argc, argv, &r) != 0) {
        fputs(usage, stderr);
        return EXIT_USAGE;
    }
    print_context();
    bench_print_header();
    for (size_t i = 0; i < sizeof sections / sizeof *sections && !failed; i++)
        if (is_listed(r.sections, sections[i].name)) {
            fprintf(stderr, "bench_speed: %s\n", sections[i].name);
            failed = sections[i].run(&r.options);
        }
    return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
