#include "play_options.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli_input.h"
#include "cli_list.h"
#include "cli_option.h"
#include "cli_util.h"
#include "clock.h"

enum { MOST_PIXELS = 16384, MOST_SAMPLES = 16, MOST_RESOLUTION = 1024, MOST_THREADS = 256 };

static const char help[] =
    "Usage: nsdf-play [options] [FILE.nsdf]\n"
    "       nsdf-play FILE.nsdf --offscreen out_%04d.png [options]\n"
    "\n"
    "Plays a moving surface in a window, or draws it into pictures without a display.\n"
    "FILE.nsdf may be an http:// or https:// URL.\n"
    "\n"
    "Window (h shows the keys)\n"
    "      --at SECONDS      where to begin (default 0)\n"
    "      --speed S         1/64 to 8 times as fast, also -1 or 1/8; negative plays backwards (default 1)\n"
    "      --rate R          new surfaces a second (default: the file's frame rate)\n"
    "      --paused          does not start by itself\n"
    "      --once            stops at the end; otherwise it begins again\n"
    "      --exit-after S    closes the window after so many seconds\n"
    "      --statistics      prints at the end how punctual it was, and what was transferred\n"
    "\n"
    "Pictures\n"
    "      --offscreen OUT   out_%04d.png  one file per frame, numbered; out.png for a single frame\n"
    "                        -             raw frames on standard output, for another program\n"
    "      --format FORMAT   with -: y4m (default), rgba, or png for a single frame\n"
    "      --fps RATE        frames per second, over the whole duration (default: those that were encoded)\n"
    "      --frames LIST     numbers from 0 among those frames: 7, 0-9,20 or 0-98/2\n"
    "      --times LIST      times in seconds: 0.5 or 0,0.25,1.75\n"
    "      --turntable S     turns the camera once round in S seconds of the film\n"
    "      --transparent     no background: PNG and rgba have alpha\n"
    "      --compare FOLDER  the OBJ meshes that were encoded, on the left of the decoded ones, the nearest in time\n"
    "      --heatmap         with --compare: those meshes only, coloured by their distance to the decoded surface\n"
    "      --heatmap-max E   distance at the top of the colours, as a fraction of the diagonal (default 5e-3)\n"
    "\n"
    "View\n"
    "      --size WxH        pixels (default 1280x720)\n"
    "      --camera A,E[,Z]  degrees around and above, and a zoom (default 25,12,1; 0,0 is from the front)\n"
    "      --up AXIS         which way is up: x, y, z, -x, -y or -z (default y)\n"
    "      --mode MODE       shaded (default), flat, wire or normals\n"
    "      --ghost           shows the encoded frame before, seen through\n"
    "      --no-ground       no shadow on the ground\n"
    "      --no-overlay      no text and no time bar; in pictures there are none anyway, unless --overlay\n"
    "      --overlay         in pictures: text and time bar\n"
    "      --samples N       of each pixel, 1 to 16 (default 4; windows drawn by the processor 1)\n"
    "      --resolution N    cells along the longest side of the box (default: a window finds the highest that is\n"
    "                        fast enough, up to the file's; pictures the file's)\n"
    "      --threads N       of the decoder, 1 to 256 (default 0: one per processor)\n"
    "      --timeout S       seconds without a byte after which a server is given up (default 20)\n"
    "\n"
    "Messages\n"
    "  -q, --quiet           errors only\n"
    "  -v, --verbose         says more\n"
    "  -h, --help            prints this and exits\n"
    "      --version         prints the version and exits\n"
    "\n"
    "Examples\n"
    "  nsdf-play samba.nsdf --speed 1/8\n"
    "  nsdf-play samba.nsdf --offscreen f_%03d.png --fps 50 --size 640x360\n"
    "  nsdf-play samba.nsdf --offscreen - --turntable 7 | ffmpeg -i - samba.mp4\n"
    "  nsdf-play samba.nsdf --offscreen error_%03d.png --compare samba/ --heatmap\n"
    "\n"
    "Exit code: 0 success, 1 failure, 2 wrong usage.\n";

enum {
    OPTION_AT = 256,
    OPTION_SPEED,
    OPTION_RATE,
    OPTION_PAUSED,
    OPTION_ONCE,
    OPTION_EXIT_AFTER,
    OPTION_STATISTICS,
    OPTION_OFFSCREEN,
    OPTION_FORMAT,
    OPTION_FPS,
    OPTION_FRAMES,
    OPTION_TIMES,
    OPTION_TURNTABLE,
    OPTION_TRANSPARENT,
    OPTION_COMPARE,
    OPTION_HEATMAP,
    OPTION_HEATMAP_MAX,
    OPTION_SIZE,
    OPTION_CAMERA,
    OPTION_UP,
    OPTION_MODE,
    OPTION_GHOST,
    OPTION_NO_GROUND,
    OPTION_NO_OVERLAY,
    OPTION_OVERLAY,
    OPTION_SAMPLES,
    OPTION_RESOLUTION,
    OPTION_THREADS,
    OPTION_TIMEOUT,
    OPTION_VERSION
};

static const struct option long_options[] = {
    {"at", required_argument, NULL, OPTION_AT},
    {"speed", required_argument, NULL, OPTION_SPEED},
    {"rate", required_argument, NULL, OPTION_RATE},
    {"paused", no_argument, NULL, OPTION_PAUSED},
    {"once", no_argument, NULL, OPTION_ONCE},
    {"exit-after", required_argument, NULL, OPTION_EXIT_AFTER},
    {"statistics", no_argument, NULL, OPTION_STATISTICS},
    {"offscreen", required_argument, NULL, OPTION_OFFSCREEN},
    {"format", required_argument, NULL, OPTION_FORMAT},
    {"fps", required_argument, NULL, OPTION_FPS},
    {"frames", required_argument, NULL, OPTION_FRAMES},
    {"times", required_argument, NULL, OPTION_TIMES},
    {"turntable", required_argument, NULL, OPTION_TURNTABLE},
    {"transparent", no_argument, NULL, OPTION_TRANSPARENT},
    {"compare", required_argument, NULL, OPTION_COMPARE},
    {"heatmap", no_argument, NULL, OPTION_HEATMAP},
    {"heatmap-max", required_argument, NULL, OPTION_HEATMAP_MAX},
    {"size", required_argument, NULL, OPTION_SIZE},
    {"camera", required_argument, NULL, OPTION_CAMERA},
    {"up", required_argument, NULL, OPTION_UP},
    {"mode", required_argument, NULL, OPTION_MODE},
    {"ghost", no_argument, NULL, OPTION_GHOST},
    {"no-ground", no_argument, NULL, OPTION_NO_GROUND},
    {"no-overlay", no_argument, NULL, OPTION_NO_OVERLAY},
    {"overlay", no_argument, NULL, OPTION_OVERLAY},
    {"samples", required_argument, NULL, OPTION_SAMPLES},
    {"resolution", required_argument, NULL, OPTION_RESOLUTION},
    {"threads", required_argument, NULL, OPTION_THREADS},
    {"timeout", required_argument, NULL, OPTION_TIMEOUT},
    {"quiet", no_argument, NULL, 'q'},
    {"verbose", no_argument, NULL, 'v'},
    {"help", no_argument, NULL, 'h'},
    {"version", no_argument, NULL, OPTION_VERSION},
    {NULL, 0, NULL, 0},
};

/* ---- Values ---------------------------------------------------------------------------------------------- */

static int parse_seconds(const char *option, const char *text, double least, double *out) {
    if (nsdf_cli_parse_double(text, out) == 0 && *out >= least)
        return NSDF_CLI_SUCCESS;
    return nsdf_cli_bad_value(option, text,
                              least > 0.0 ? "a number of seconds above 0" : "a number of seconds from 0 on");
}

/* 2, -0.5, 1/8, -1/16 */
static int parse_speed(const char *text, double *speed) {
    const int negative = text[0] == '-';
    uint32_t num, den;
    if (nsdf_cli_parse_rational(text + negative, &num, &den) != 0)
        return nsdf_cli_bad_value("--speed", text, "a speed such as 1, 1/8 or -2");
    const double size = (double)num / den;
    if (size < PLAY_SLOWEST || size > PLAY_FASTEST)
        return nsdf_cli_usage_error("--speed: %s is out of range, which is 1/64 to 8 and -8 to -1/64", text);
    *speed = negative ? -size : size;
    return NSDF_CLI_SUCCESS;
}

static int parse_rate(const char *text, double *rate) {
    uint32_t num, den;
    if (nsdf_cli_parse_rational(text, &num, &den) != 0 || num > 1000.0 * den || den > num)
        return nsdf_cli_bad_value("--rate", text, "a rate from 1 to 1000");
    *rate = (double)num / den;
    return NSDF_CLI_SUCCESS;
}

static int parse_size(const char *text, play_options *o) {
    char first[16];
    const char *x = strchr(text, 'x');
    uint32_t width, height;
    if (!x || (size_t)(x - text) >= sizeof first)
        return nsdf_cli_bad_value("--size", text, "a size such as 1280x720");
    memcpy(first, text, (size_t)(x - text));
    first[x - text] = '\0';
    if (nsdf_cli_parse_u32(first, 16, MOST_PIXELS, &width) != 0 ||
        nsdf_cli_parse_u32(x + 1, 16, MOST_PIXELS, &height) != 0)
        return nsdf_cli_usage_error("--size: '%s' is not a size such as 1280x720, each from 16 to %d", text,
                                    MOST_PIXELS);
    o->width = (int)width;
    o->height = (int)height;
    return NSDF_CLI_SUCCESS;
}

typedef struct numbers {
    double value[3];
    int count;
} numbers;

static int add_number(void *user, const char *text) {
    numbers *n = user;
    if (n->count == 3 || nsdf_cli_parse_double(text, &n->value[n->count]) != 0)
        return nsdf_cli_bad_value("--camera", text,
                                  "one of two angles in degrees and a zoom, such as 25,12 or 25,12,1.5");
    n->count++;
    return NSDF_CLI_SUCCESS;
}

static int parse_camera(const char *text, play_options *o) {
    numbers n = {.count = 0};
    const int result = nsdf_cli_each_item(text, add_number, &n);
    if (result != NSDF_CLI_SUCCESS)
        return result;
    if (n.count < 2 || fabs(n.value[1]) > 89.0 || (n.count == 3 && (n.value[2] < 0.05 || n.value[2] > 50.0)))
        return nsdf_cli_bad_value("--camera", text,
                                  "an angle around, one above from -89 to 89, and a zoom from 0.05 to 50");
    o->azimuth = n.value[0];
    o->elevation = n.value[1];
    o->zoom = n.count == 3 ? n.value[2] : 1.0;
    return NSDF_CLI_SUCCESS;
}

/* Which of the names a text is, or -1. */
static int find_name(const char *text, const char *const *names, int count) {
    for (int i = 0; i < count; i++)
        if (strcmp(text, names[i]) == 0)
            return i;
    return -1;
}

static int parse_format(const char *text, play_options *o) {
    static const char *const names[] = {"png", "rgba", "y4m"};
    const int found = find_name(text, names, 3);
    if (found < 0)
        return nsdf_cli_bad_value("--format", text, "y4m, rgba or png");
    o->picture = (play_picture)found;
    o->has_picture = 1;
    return NSDF_CLI_SUCCESS;
}

static int parse_mode(const char *text, play_options *o) {
    static const char *const names[PLAY_MODES] = {"shaded", "flat", "wire", "normals"};
    const int found = find_name(text, names, PLAY_MODES);
    if (found < 0)
        return nsdf_cli_bad_value("--mode", text, "shaded, flat, wire or normals");
    o->mode = (play_mode)found;
    return NSDF_CLI_SUCCESS;
}

/* ---- Options --------------------------------------------------------------------------------------------- */

static int set_count(const char *option, const char *text, uint32_t max, int *out) {
    uint32_t value = 0;
    const int result = nsdf_cli_take_count(option, text, 1, max, &value);
    if (result == NSDF_CLI_SUCCESS)
        *out = (int)value;
    return result;
}

static int set_window_value(int option, const char *text, play_options *o) {
    switch (option) {
    case OPTION_AT:
        return parse_seconds("--at", text, 0.0, &o->at);
    case OPTION_SPEED:
        return parse_speed(text, &o->speed);
    case OPTION_RATE:
        return parse_rate(text, &o->rate);
    default: /* OPTION_EXIT_AFTER */
        return parse_seconds("--exit-after", text, 1e-3, &o->exit_after);
    }
}

static int set_value(int option, const char *text, play_options *o) {
    switch (option) {
    case OPTION_OFFSCREEN:
        o->action = PLAY_OFFSCREEN;
        o->output = text;
        return NSDF_CLI_SUCCESS;
    case OPTION_FORMAT:
        return parse_format(text, o);
    case OPTION_FPS:
        return nsdf_cli_take_rate("--fps", text, &o->choice.rate_num, &o->choice.rate_den);
    case OPTION_FRAMES:
        o->choice.frames = text;
        return NSDF_CLI_SUCCESS;
    case OPTION_TIMES:
        o->choice.times = text;
        return NSDF_CLI_SUCCESS;
    case OPTION_TURNTABLE:
        return parse_seconds("--turntable", text, 1e-3, &o->turntable);
    case OPTION_COMPARE:
        o->compare = text;
        return NSDF_CLI_SUCCESS;
    case OPTION_HEATMAP_MAX:
        o->heatmap = 1;
        if (nsdf_cli_parse_double(text, &o->heatmap_max) == 0 && o->heatmap_max > 0.0)
            return NSDF_CLI_SUCCESS;
        return nsdf_cli_bad_value("--heatmap-max", text, "a fraction of the diagonal above 0");
    case OPTION_SIZE:
        return parse_size(text, o);
    case OPTION_CAMERA:
        return parse_camera(text, o);
    case OPTION_UP:
        return play_up_parse(text, &o->up) == 0 ? NSDF_CLI_SUCCESS
                                                : nsdf_cli_bad_value("--up", text, "one of x, y, z, -x, -y and -z");
    case OPTION_MODE:
        return parse_mode(text, o);
    case OPTION_SAMPLES:
        return set_count("--samples", text, MOST_SAMPLES, &o->samples);
    case OPTION_RESOLUTION:
        return nsdf_cli_take_count("--resolution", text, 2, MOST_RESOLUTION, &o->resolution);
    case OPTION_THREADS:
        return nsdf_cli_take_count("--threads", text, 0, MOST_THREADS, &o->threads);
    case OPTION_TIMEOUT:
        return nsdf_cli_take_count("--timeout", text, 1, 86400, &o->timeout);
    default:
        return set_window_value(option, text, o);
    }
}

static void set_flag(int option, play_options *o) {
    switch (option) {
    case OPTION_PAUSED:
        o->paused = 1;
        break;
    case OPTION_ONCE:
        o->once = 1;
        break;
    case OPTION_STATISTICS:
        o->statistics = 1;
        break;
    case OPTION_TRANSPARENT:
        o->transparent = 1;
        break;
    case OPTION_HEATMAP:
        o->heatmap = 1;
        break;
    case OPTION_GHOST:
        o->ghost = 1;
        break;
    case OPTION_NO_GROUND:
        o->ground = 0;
        break;
    case OPTION_NO_OVERLAY:
        o->overlay = 0;
        break;
    case OPTION_OVERLAY:
        o->overlay = 1;
        break;
    case 'q':
        nsdf_cli_set_verbosity(-1);
        break;
    default: /* 'v' */
        nsdf_cli_set_verbosity(1);
        break;
    }
}

static int check_pictures(play_options *o) {
    const int to_stdout = strcmp(o->output, "-") == 0;
    if (!o->input)
        return nsdf_cli_usage_error("no input file: name an .nsdf file");
    if (!*o->output)
        return nsdf_cli_usage_error("--offscreen: no name; for example out_%%04d.png");
    if (o->has_picture && !to_stdout && o->picture != PLAY_PNG)
        return nsdf_cli_usage_error("--format rgba and y4m go with --offscreen - only");
    if (!o->has_picture)
        o->picture = to_stdout ? PLAY_Y4M : PLAY_PNG;
    if (o->choice.times && (o->choice.frames || o->choice.rate_num))
        return nsdf_cli_usage_error("--times does not go with --fps or --frames");
    if (o->transparent && o->picture == PLAY_Y4M)
        return nsdf_cli_usage_error("--transparent goes with PNG and rgba only");
    if (o->heatmap && !o->compare)
        return nsdf_cli_usage_error("--heatmap goes with --compare");
    return NSDF_CLI_SUCCESS;
}

static int check(play_options *o) {
    if (o->overlay < 0)
        o->overlay = o->action == PLAY_WINDOW || o->compare;
    if (o->action == PLAY_OFFSCREEN)
        return check_pictures(o);
    if (o->choice.times || o->choice.frames || o->choice.rate_num || o->has_picture || o->transparent)
        return nsdf_cli_usage_error("--times, --fps, --frames, --format and --transparent go with --offscreen");
    if (o->compare || o->heatmap)
        return nsdf_cli_usage_error("--compare and --heatmap go with --offscreen");
    return NSDF_CLI_SUCCESS;
}

int play_options_parse(int argc, char **argv, play_options *options) {
    *options = (play_options){.action = PLAY_WINDOW,
                              .width = 1280,
                              .height = 720,
                              .up = PLAY_UP_Y,
                              .azimuth = 25.0,
                              .elevation = 12.0,
                              .zoom = 1.0,
                              .ground = 1,
                              .overlay = -1,
                              .speed = 1.0,
                              .heatmap_max = 5e-3,
                              .timeout = NSDF_CLI_TIMEOUT};
    opterr = 0;
    for (int option; (option = getopt_long(argc, argv, ":qvh", long_options, NULL)) != -1;) {
        int result = NSDF_CLI_SUCCESS;
        if (option == ':' || option == '?')
            return nsdf_cli_refuse_option(option, argc, argv, long_options);
        if (option == 'h' || option == OPTION_VERSION) {
            options->action = PLAY_NOTHING;
            if (option == 'h')
                fputs(help, stdout);
            else
                printf("nsdf-play %s\n", nsdf_version_string());
            return NSDF_CLI_SUCCESS;
        }
        if (nsdf_cli_takes_value(option, long_options))
            result = set_value(option, optarg, options);
        else
            set_flag(option, options);
        if (result != NSDF_CLI_SUCCESS)
            return result;
    }
    if (argc - optind > 1)
        return nsdf_cli_usage_error("one input file at a time, not also '%s'", argv[optind + 1]);
    if (argc > optind)
        options->input = argv[optind];
    return check(options);
}
