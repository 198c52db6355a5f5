#include "cmp_options.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "cli_list.h"
#include "cli_option.h"
#include "cli_util.h"

static const char help_text[] =
    "Usage: nsdf-cmp [options] REF DEC\n"
    "\n"
    "Measures how far the moving surface DEC is from REF, frame by frame and over the whole sequence.\n"
    "REF is a sequence of OBJ or PLY meshes: a folder, a pattern (walk_%04d.obj), a glob, a list file (.txt, .lst) or\n"
    "a single file.\n"
    "DEC is another, or an .nsdf file, which is decoded at its frames.  The meshes need no common connectivity.\n"
    "\n"
    "Which frames\n"
    "      --frames LIST      frames of REF, numbered in time from 0: 7 or 0-9,20 or 1-173/2 (every second); the same "
    "ones of "
    "DEC\n"
    "      --numbers KIND     times (default): frames are as far apart as the numbers of their files; ignore: files "
    "follow\n"
    "                         each other\n"
    "      --fps F            frames per second, of times in a list or animated glTF (default: the .nsdf file's)\n"
    "      --common           if the numbers of frames differ, compare those that both have; otherwise that is an "
    "error\n"
    "      --resolution N     at which an .nsdf file is decoded, 2 to 4096 (default: the file's)\n"
    "Measuring\n"
    "      --shell T          REF as nsdf-enc --shell T fits it, open sheets closed bodies of this thickness; auto: "
    "as\n"
    "                         without that option; none (default): REF as it is\n"
    "      --outer            without surface inside of closed pieces of a mesh, which no solid has; the share is "
    "told\n"
    "      --samples N        random points on each surface, 1 to 16777216 (default 20000), besides all vertices\n"
    "      --seed N           of the random points (default 1)\n"
    "      --measures LIST    of d1, normals, fmpd, shapes, or none (default: all); distances are always measured\n"
    "      --peak P           P of the PSNR, world units (default: the longest side of the box of all of REF)\n"
    "      --threads N        0 = one per core (default); the result does not depend on it\n"
    "Result\n"
    "      --units UNITS      diagonal (default): distances as fractions of the diagonal of REF's box; or world\n"
    "      --csv, --json      instead of a table\n"
    "  -o, --output FILE      write the result there instead of to standard output\n"
    "      --heatmap OUT      out_%04d.ply: the meshes of DEC, coloured by their distance to REF\n"
    "      --heatmap-max E    distance at the top of the colours, in UNITS (default 5e-3 of the diagonal)\n"
    "\n"
    "  -q, --quiet            errors only\n"
    "  -v, --verbose          a line for each frame\n"
    "  -h, --help             this text\n"
    "      --version          version\n"
    "\n"
    "Exit code: 0 compared, 1 failure, 2 wrong usage.\n"
    "\n"
    "Example: nsdf-cmp samba/ samba.nsdf --resolution 256 --csv -o samba.csv\n";

enum {
    OPT_FRAMES = 256,
    OPT_NUMBERS,
    OPT_FPS,
    OPT_COMMON,
    OPT_RESOLUTION,
    OPT_SHELL,
    OPT_OUTER,
    OPT_SAMPLES,
    OPT_SEED,
    OPT_MEASURES,
    OPT_PEAK,
    OPT_THREADS,
    OPT_UNITS,
    OPT_CSV,
    OPT_JSON,
    OPT_HEATMAP,
    OPT_HEATMAP_MAX,
    OPT_VERSION
};

static const struct option long_options[] = {
    {"output", required_argument, NULL, 'o'},
    {"quiet", no_argument, NULL, 'q'},
    {"verbose", no_argument, NULL, 'v'},
    {"help", no_argument, NULL, 'h'},
    {"frames", required_argument, NULL, OPT_FRAMES},
    {"numbers", required_argument, NULL, OPT_NUMBERS},
    {"fps", required_argument, NULL, OPT_FPS},
    {"common", no_argument, NULL, OPT_COMMON},
    {"resolution", required_argument, NULL, OPT_RESOLUTION},
    {"shell", required_argument, NULL, OPT_SHELL},
    {"outer", no_argument, NULL, OPT_OUTER},
    {"samples", required_argument, NULL, OPT_SAMPLES},
    {"seed", required_argument, NULL, OPT_SEED},
    {"measures", required_argument, NULL, OPT_MEASURES},
    {"peak", required_argument, NULL, OPT_PEAK},
    {"threads", required_argument, NULL, OPT_THREADS},
    {"units", required_argument, NULL, OPT_UNITS},
    {"csv", no_argument, NULL, OPT_CSV},
    {"json", no_argument, NULL, OPT_JSON},
    {"heatmap", required_argument, NULL, OPT_HEATMAP},
    {"heatmap-max", required_argument, NULL, OPT_HEATMAP_MAX},
    {"version", no_argument, NULL, OPT_VERSION},
    {NULL, 0, NULL, 0},
};

int cmp_is_nsdf(const char *path) {
    const size_t length = strlen(path);
    return length >= 5 && strcasecmp(path + length - 5, ".nsdf") == 0;
}

static int bad_value(const char *option, const char *text, const char *expected) {
    return nsdf_cli_usage_error("--%s: '%s' is not %s", option, text, expected);
}

static int add_measure(void *user, const char *text) {
    static const struct {
        const char *name;
        uint32_t bit;
    } known[] = {{"d1", NSDF_COMPARE_POINTS},
                 {"normals", NSDF_COMPARE_NORMALS},
                 {"fmpd", NSDF_COMPARE_FMPD},
                 {"shapes", NSDF_COMPARE_SHAPES},
                 {"distance", 0},
                 {"none", 0}};
    uint32_t *measures = user;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (strcmp(known[i].name, text) == 0) {
            *measures |= known[i].bit;
            return NSDF_CLI_SUCCESS;
        }
    return bad_value("measures", text, "one of d1, normals, fmpd, shapes, none");
}

static int set_measures(cmp_options *o, const char *text) {
    o->compare.measures = 0;
    return nsdf_cli_each_item(text, add_measure, &o->compare.measures);
}

static int set_number(const char *name, const char *text, uint32_t low, uint32_t high, uint32_t *out) {
    char expected[64];
    snprintf(expected, sizeof expected, "a whole number from %lu to %lu", (unsigned long)low, (unsigned long)high);
    return nsdf_cli_parse_u32(text, low, high, out) == 0 ? 0 : bad_value(name, text, expected);
}

static int set_positive(const char *name, const char *text, double *out) {
    return nsdf_cli_parse_double(text, out) == 0 && *out > 0.0 ? 0 : bad_value(name, text, "a positive number");
}

static int set_units(cmp_options *o, const char *text) {
    o->world = strcmp(text, "world") == 0;
    return o->world || strcmp(text, "diagonal") == 0 ? 0 : bad_value("units", text, "diagonal or world");
}

static int set_numbers(cmp_options *o, const char *text) {
    o->ignore_numbers = strcmp(text, "ignore") == 0;
    return o->ignore_numbers || strcmp(text, "times") == 0 ? 0 : bad_value("numbers", text, "times or ignore");
}

static int set_shell(cmp_options *o, const char *text) {
    const int none = strcmp(text, "none") == 0, automatic = strcmp(text, "auto") == 0;
    o->shell = none ? CMP_SHELL_NONE : automatic ? CMP_SHELL_AUTO : CMP_SHELL_GIVEN;
    if (none || automatic || (nsdf_cli_parse_double(text, &o->thickness) == 0 && o->thickness > 0.0))
        return 0;
    return bad_value("shell", text, "a thickness above 0, auto or none");
}

static int apply_measuring(cmp_options *o, int code, const char *text) {
    switch (code) {
    case OPT_SHELL:
        return set_shell(o, text);
    case OPT_OUTER:
        o->compare.outer = NSDF_COMPARE_REFERENCE;
        return 0;
    case OPT_SAMPLES:
        return set_number("samples", text, 1, 1 << 24, &o->compare.samples);
    case OPT_SEED:
        return nsdf_cli_parse_u64(text, &o->compare.seed) == 0 ? 0 : bad_value("seed", text, "a whole number");
    case OPT_MEASURES:
        return set_measures(o, text);
    case OPT_PEAK:
        return set_positive("peak", text, &o->peak);
    case OPT_THREADS:
        return set_number("threads", text, 0, 256, &o->compare.threads);
    case OPT_RESOLUTION:
        return set_number("resolution", text, 2, 4096, &o->resolution);
    default:
        return -1;
    }
}

static int apply(cmp_options *o, int code, const char *text) {
    switch (code) {
    case 'o':
        o->output = text;
        return 0;
    case 'q':
        o->quiet = 1;
        return 0;
    case 'v':
        o->verbose++;
        return 0;
    case OPT_FRAMES:
        o->frames = text;
        return 0;
    case OPT_NUMBERS:
        return set_numbers(o, text);
    case OPT_FPS:
        return nsdf_cli_parse_rational(text, &o->rate_num, &o->rate_den) == 0
                   ? 0
                   : bad_value("fps", text, "a rate such as 25, 29.97 or 60000/1001");
    case OPT_COMMON:
        o->common = 1;
        return 0;
    case OPT_UNITS:
        return set_units(o, text);
    case OPT_CSV:
        o->format = CMP_CSV;
        return 0;
    case OPT_JSON:
        o->format = CMP_JSON;
        return 0;
    case OPT_HEATMAP:
        o->heatmap = text;
        return 0;
    case OPT_HEATMAP_MAX:
        return set_positive("heatmap-max", text, &o->heatmap_max);
    default:
        return apply_measuring(o, code, text);
    }
}

static int parse_options(cmp_options *o, int argc, char **argv) {
    opterr = 0;
    for (int code; (code = getopt_long(argc, argv, ":o:qvh", long_options, NULL)) != -1;) {
        if (code == ':' || code == '?')
            return nsdf_cli_refuse_option(code, argc, argv, long_options);
        if (code == 'h') {
            fputs(help_text, stdout);
            return NSDF_CLI_SUCCESS;
        }
        if (code == OPT_VERSION) {
            printf("nsdf-cmp %s\n", nsdf_version_string());
            return NSDF_CLI_SUCCESS;
        }
        const int failed = apply(o, code, optarg);
        if (failed)
            return failed;
    }
    return -1;
}

int cmp_options_parse(cmp_options *options, int argc, char **argv) {
    memset(options, 0, sizeof *options);
    nsdf_compare_options_init(&options->compare);
    const int done = parse_options(options, argc, argv);
    if (done >= 0)
        return done;
    if (argc - optind != 2)
        return nsdf_cli_usage_error("%d inputs were named, expected two: REF and DEC", argc - optind);
    options->reference = argv[optind];
    options->decoded = argv[optind + 1];
    if (cmp_is_nsdf(options->reference))
        return nsdf_cli_usage_error("REF '%s' is an .nsdf file: it must be meshes", options->reference);
    if (options->resolution && !cmp_is_nsdf(options->decoded))
        return nsdf_cli_usage_error("--resolution is for an .nsdf file, but DEC '%s' is meshes", options->decoded);
    if (options->compare.outer && !cmp_is_nsdf(options->decoded))
        options->compare.outer |= NSDF_COMPARE_DECODED; /* a decoded file hides nothing */
    if (options->output && options->heatmap && strcmp(options->output, options->heatmap) == 0)
        return nsdf_cli_usage_error("-o and --heatmap name the same file");
    return -1;
}
