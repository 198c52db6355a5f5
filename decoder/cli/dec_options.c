#include "dec_options.h"

#include <stdio.h>
#include <string.h>

#include "cli_input.h"
#include "cli_option.h"
#include "cli_util.h"

enum { MAX_THREADS = 256, MIN_RESOLUTION = 2, MAX_RESOLUTION = 4096, MAX_PROJECTION = 8 };

static const char help[] =
    "Usage: nsdf-dec [options] FILE.nsdf -o OUT\n"
    "       nsdf-dec --info [--json] | --verify | --bench [options] FILE.nsdf\n"
    "\n"
    "Rebuilds the triangle meshes of a moving surface from an .nsdf file, which may be an http:// or https:// URL.\n"
    "\n"
    "Output\n"
    "  -o, --output OUT      where the meshes go:\n"
    "                          out_%04d.obj  one file per frame, numbered; .obj, .ply, .stl or .glb\n"
    "                          out.obj       the same for a single frame\n"
    "                          out.glb       all frames in one file of binary glTF, shown one after the other\n"
    "                          -             standard output, a single frame; glb all of them\n"
    "                          hash:         a line \"number seconds hash\" per frame on standard output\n"
    "                          null:         decodes and writes nothing\n"
    "      --format FORMAT   obj, ply, stl or glb, whatever the name ends in\n"
    "      --start-number N  number of the first file (default 0)\n"
    "      --no-normals      leaves the normals out\n"
    "\n"
    "Which frames (default: the frames that were encoded)\n"
    "      --fps RATE        frames per second, over the whole duration: 50, 29.97 or 60000/1001\n"
    "      --frames LIST     numbers from 0 among those frames: 7, 0-9,20 or\n"
    "                        0-98/2, every second of that range\n"
    "      --times LIST      times in seconds: 0.5 or 0,0.25,1.75\n"
    "\n"
    "How\n"
    "      --resolution N    cells along the longest side of the box, 2 to 4096 (default: the file's)\n"
    "      --projection N    Newton steps that move the vertices onto the surface, 0 to 8 (default 2)\n"
    "      --dense           looks for the surface in every cell; slow\n"
    "      --all-pieces      keeps pieces smaller than the file says that any is: specks and bubbles\n"
    "      --threads N       threads, 1 to 256 (default 0: one per processor)\n"
    "      --cpu-mask MASK   kernels that may be used: c, avx2, avx512, neon, or a number of bits (default: all)\n"
    "      --max-memory N    bytes that may be used; k, M and G stand for 1024, 1024^2, 1024^3 (default 1G)\n"
    "      --timeout S       seconds without a byte after which a server is given up (default 20)\n"
    "\n"
    "Instead of meshes\n"
    "      --info            prints what is in the file\n"
    "      --json            with --info: as JSON\n"
    "      --verify          checks every checksum and hash in the file\n"
    "      --bench           measures opening, extraction at 64, 128 and 192 (or --resolution), and evaluation\n"
    "\n"
    "Messages\n"
    "  -q, --quiet           errors only\n"
    "  -v, --verbose         says more; may be repeated\n"
    "  -h, --help            prints this and exits\n"
    "      --version         prints the version and exits\n"
    "\n"
    "Examples\n"
    "  nsdf-dec samba.nsdf -o samba_%04d.obj\n"
    "  nsdf-dec samba.nsdf --fps 50 --resolution 256 -o slow/samba_%04d.ply\n"
    "  nsdf-dec samba.nsdf --fps 25 --resolution 96 -o samba.glb\n"
    "  nsdf-dec samba.nsdf --times 1.25 -o - --format stl > pose.stl\n"
    "\n"
    "Exit code: 0 success, 1 failure, 2 wrong usage.  A command that fails leaves no files behind.\n";

enum {
    OPTION_FORMAT = 256,
    OPTION_START_NUMBER,
    OPTION_NO_NORMALS,
    OPTION_FPS,
    OPTION_FRAMES,
    OPTION_TIMES,
    OPTION_RESOLUTION,
    OPTION_PROJECTION,
    OPTION_DENSE,
    OPTION_ALL_PIECES,
    OPTION_THREADS,
    OPTION_CPU_MASK,
    OPTION_MAX_MEMORY,
    OPTION_TIMEOUT,
    OPTION_INFO,
    OPTION_JSON,
    OPTION_VERIFY,
    OPTION_BENCH,
    OPTION_VERSION
};

static const struct option long_options[] = {
    {"output", required_argument, NULL, 'o'},
    {"format", required_argument, NULL, OPTION_FORMAT},
    {"start-number", required_argument, NULL, OPTION_START_NUMBER},
    {"no-normals", no_argument, NULL, OPTION_NO_NORMALS},
    {"fps", required_argument, NULL, OPTION_FPS},
    {"frames", required_argument, NULL, OPTION_FRAMES},
    {"times", required_argument, NULL, OPTION_TIMES},
    {"resolution", required_argument, NULL, OPTION_RESOLUTION},
    {"projection", required_argument, NULL, OPTION_PROJECTION},
    {"dense", no_argument, NULL, OPTION_DENSE},
    {"all-pieces", no_argument, NULL, OPTION_ALL_PIECES},
    {"threads", required_argument, NULL, OPTION_THREADS},
    {"cpu-mask", required_argument, NULL, OPTION_CPU_MASK},
    {"max-memory", required_argument, NULL, OPTION_MAX_MEMORY},
    {"timeout", required_argument, NULL, OPTION_TIMEOUT},
    {"info", no_argument, NULL, OPTION_INFO},
    {"json", no_argument, NULL, OPTION_JSON},
    {"verify", no_argument, NULL, OPTION_VERIFY},
    {"bench", no_argument, NULL, OPTION_BENCH},
    {"quiet", no_argument, NULL, 'q'},
    {"verbose", no_argument, NULL, 'v'},
    {"help", no_argument, NULL, 'h'},
    {"version", no_argument, NULL, OPTION_VERSION},
    {NULL, 0, NULL, 0},
};

static int parse_format(const char *text, dec_options *options) {
    static const char *const names[] = {"obj", "ply", "stl", "glb"};
    for (int i = 0; i < 4; i++) {
        if (strcmp(text, names[i]) != 0)
            continue;
        options->format = (dec_format)i;
        options->has_format = 1;
        return NSDF_CLI_SUCCESS;
    }
    return nsdf_cli_bad_value("--format", text, "obj, ply, stl or glb");
}

static int parse_cpu_mask(const char *text, uint32_t *mask) {
    if (strcmp(text, "c") == 0)
        return *mask = 0, NSDF_CLI_SUCCESS;
    if (strcmp(text, "avx2") == 0)
        return *mask = NSDF_CPU_AVX2, NSDF_CLI_SUCCESS;
    if (strcmp(text, "avx512") == 0)
        return *mask = NSDF_CPU_AVX2 | NSDF_CPU_AVX512, NSDF_CLI_SUCCESS;
    if (strcmp(text, "neon") == 0)
        return *mask = NSDF_CPU_NEON, NSDF_CLI_SUCCESS;
    if (nsdf_cli_parse_u32(text, 0, UINT32_MAX, mask) == 0)
        return NSDF_CLI_SUCCESS;
    return nsdf_cli_bad_value("--cpu-mask", text, "c, avx2, avx512, neon or a number");
}

static int set_action(dec_options *options, dec_action action) {
    if (options->action != DEC_EXTRACT && options->action != action)
        return nsdf_cli_usage_error("--info, --verify and --bench exclude each other");
    options->action = action;
    return NSDF_CLI_SUCCESS;
}

static int set_value(int option, const char *text, dec_options *o) {
    switch (option) {
    case 'o':
        o->output = text;
        return NSDF_CLI_SUCCESS;
    case OPTION_FORMAT:
        return parse_format(text, o);
    case OPTION_START_NUMBER:
        return nsdf_cli_take_count("--start-number", text, 0, INT32_MAX, &o->start_number);
    case OPTION_FPS:
        return nsdf_cli_take_rate("--fps", text, &o->choice.rate_num, &o->choice.rate_den);
    case OPTION_FRAMES:
        o->choice.frames = text;
        return NSDF_CLI_SUCCESS;
    case OPTION_TIMES:
        o->choice.times = text;
        return NSDF_CLI_SUCCESS;
    case OPTION_RESOLUTION:
        return nsdf_cli_take_count("--resolution", text, MIN_RESOLUTION, MAX_RESOLUTION, &o->resolution);
    case OPTION_PROJECTION:
        return nsdf_cli_take_count("--projection", text, 0, MAX_PROJECTION, &o->projection);
    case OPTION_THREADS:
        return nsdf_cli_take_count("--threads", text, 0, MAX_THREADS, &o->threads);
    case OPTION_CPU_MASK:
        return parse_cpu_mask(text, &o->cpu_mask);
    case OPTION_TIMEOUT:
        return nsdf_cli_take_count("--timeout", text, 1, 86400, &o->timeout);
    default: /* OPTION_MAX_MEMORY */
        if (nsdf_cli_parse_bytes(text, &o->max_memory) == 0 && o->max_memory > 0)
            return NSDF_CLI_SUCCESS;
        return nsdf_cli_bad_value("--max-memory", text, "a number of bytes such as 500M");
    }
}

static int set_flag(int option, dec_options *o) {
    switch (option) {
    case OPTION_NO_NORMALS:
        o->normals = 0;
        return NSDF_CLI_SUCCESS;
    case OPTION_DENSE:
        o->dense = 1;
        return NSDF_CLI_SUCCESS;
    case OPTION_ALL_PIECES:
        o->all_pieces = 1;
        return NSDF_CLI_SUCCESS;
    case OPTION_JSON:
        o->json = 1;
        return NSDF_CLI_SUCCESS;
    case OPTION_INFO:
        return set_action(o, DEC_INFO);
    case OPTION_VERIFY:
        return set_action(o, DEC_VERIFY);
    case OPTION_BENCH:
        return set_action(o, DEC_BENCH);
    case 'q':
        nsdf_cli_set_verbosity(-1);
        return NSDF_CLI_SUCCESS;
    default: /* 'v' */
        nsdf_cli_set_verbosity(nsdf_cli_verbosity() < 0 ? 1 : nsdf_cli_verbosity() + 1);
        return NSDF_CLI_SUCCESS;
    }
}

static int check(dec_options *o) {
    if (!o->input)
        return nsdf_cli_usage_error("no input file: name an .nsdf file");
    if (o->json && o->action != DEC_INFO)
        return nsdf_cli_usage_error("--json goes with --info");
    if (o->action != DEC_EXTRACT && o->output)
        return nsdf_cli_usage_error("--output does not go with --info, --verify or --bench");
    if (o->action == DEC_EXTRACT && (!o->output || !*o->output))
        return nsdf_cli_usage_error("no output: use -o, for example -o out_%%04d.obj");
    if (o->choice.times && (o->choice.frames || o->choice.rate_num))
        return nsdf_cli_usage_error("--times does not go with --fps or --frames");
    return NSDF_CLI_SUCCESS;
}

int dec_options_parse(int argc, char **argv, dec_options *options) {
    memset(options, 0, sizeof *options);
    options->action = DEC_EXTRACT;
    options->normals = 1;
    options->projection = 2;
    options->cpu_mask = NSDF_CPU_ALL;
    options->timeout = NSDF_CLI_TIMEOUT;
    opterr = 0;
    for (int option; (option = getopt_long(argc, argv, ":o:qvh", long_options, NULL)) != -1;) {
        if (option == ':' || option == '?')
            return nsdf_cli_refuse_option(option, argc, argv, long_options);
        if (option == 'h' || option == OPTION_VERSION) {
            options->action = DEC_NOTHING;
            if (option == 'h')
                fputs(help, stdout);
            else
                printf("nsdf-dec %s\n", nsdf_version_string());
            return NSDF_CLI_SUCCESS;
        }
        const int result =
            nsdf_cli_takes_value(option, long_options) ? set_value(option, optarg, options) : set_flag(option, options);
        if (result != NSDF_CLI_SUCCESS)
            return result;
    }
    if (argc - optind > 1)
        return nsdf_cli_usage_error("one input file at a time, not also '%s'", argv[optind + 1]);
    if (argc > optind)
        options->input = argv[optind];
    return check(options);
}
