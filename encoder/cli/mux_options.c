#include "mux_options.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli_option.h"
#include "cli_util.h"

static const char help[] =
    "Usage: nsdf-mux [options] FILE.nsdf... -o OUT.nsdf\n"
    "       nsdf-mux --info FILE.nsdf\n"
    "       nsdf-mux --validate FILE.nsdf...\n"
    "\n"
    "Cuts, joins and changes .nsdf files.  Nothing is fitted or coded again.\n"
    "\n"
    "Joining (several files; rate, box and domain must be the same)\n"
    "      --shared          the first frame of a file is the last of the one before; otherwise it comes after it\n"
    "      --fade N          cross-fades over N frames before and after a join, which the models must reach; 0 = none\n"
    "                        (default: up to 2, where a file goes on with the surface that the one before ends with)\n"
    "\n"
    "Segments of other files\n"
    "      --replace A-B     puts the segments of another file in place of segments A to B, which begin at 0\n"
    "      --with FILE       that file, which must have as many frames as they\n"
    "\n"
    "Cutting (A-B, A- or A)\n"
    "      --frames A-B      keeps frames A to B, which begin at 0\n"
    "      --times A-B       keeps the frames from A to B seconds, and those next to them\n"
    "      --segments A-B    keeps segments A to B, which begin at 0\n"
    "\n"
    "Changing\n"
    "      --fps RATE        plays the same frames at another rate: 50, 29.97 or 60000/1001\n"
    "      --hold N          lets the last frame stay for N frames more\n"
    "      --set KEY=VALUE   metadata: sets a pair; may be repeated\n"
    "      --remove KEY      metadata: removes a key; may be repeated\n"
    "\n"
    "Instead of a file\n"
    "      --info            prints what is in the file, as JSON\n"
    "      --validate        checks structure, every checksum and every hash, and prints what is wrong and where\n"
    "\n"
    "Output and messages\n"
    "  -o, --output OUT      the file to write; - is standard output\n"
    "  -q, --quiet           errors only\n"
    "  -v, --verbose         says more\n"
    "  -h, --help            prints this and exits\n"
    "      --version         prints the version and exits\n"
    "\n"
    "Files are joined first, then segments replaced, then cut, then changed.\n"
    "\n"
    "Examples\n"
    "  nsdf-mux day.nsdf --times 600-660 -o minute.nsdf\n"
    "  nsdf-mux morning.nsdf noon.nsdf evening.nsdf -o day.nsdf\n"
    "  nsdf-mux walk.nsdf --replace 3 --with better.nsdf -o walk2.nsdf\n"
    "  nsdf-mux walk.nsdf --fps 50 --set title='Walk, twice as fast' -o fast.nsdf\n"
    "\n"
    "Exit code: 0 success, 1 failure, 2 wrong usage.  A command that fails leaves no files behind.\n";

enum {
    OPTION_SHARED = 256,
    OPTION_FADE,
    OPTION_REPLACE,
    OPTION_WITH,
    OPTION_FRAMES,
    OPTION_TIMES,
    OPTION_SEGMENTS,
    OPTION_FPS,
    OPTION_HOLD,
    OPTION_SET,
    OPTION_REMOVE,
    OPTION_INFO,
    OPTION_VALIDATE,
    OPTION_VERSION
};

static const struct option long_options[] = {
    {"shared", no_argument, NULL, OPTION_SHARED},
    {"fade", required_argument, NULL, OPTION_FADE},
    {"replace", required_argument, NULL, OPTION_REPLACE},
    {"with", required_argument, NULL, OPTION_WITH},
    {"frames", required_argument, NULL, OPTION_FRAMES},
    {"times", required_argument, NULL, OPTION_TIMES},
    {"segments", required_argument, NULL, OPTION_SEGMENTS},
    {"fps", required_argument, NULL, OPTION_FPS},
    {"hold", required_argument, NULL, OPTION_HOLD},
    {"set", required_argument, NULL, OPTION_SET},
    {"remove", required_argument, NULL, OPTION_REMOVE},
    {"info", no_argument, NULL, OPTION_INFO},
    {"validate", no_argument, NULL, OPTION_VALIDATE},
    {"output", required_argument, NULL, 'o'},
    {"quiet", no_argument, NULL, 'q'},
    {"verbose", no_argument, NULL, 'v'},
    {"help", no_argument, NULL, 'h'},
    {"version", no_argument, NULL, OPTION_VERSION},
    {NULL, 0, NULL, 0},
};

/* ---- Values ---------------------------------------------------------------------------------------------------- */

/* Splits "A-B"; *second becomes "" for "A-" and NULL for "A".  0, or -1 when it does not fit. */
static int split_range(const char *text, char first[32], const char **second) {
    const char *dash = strchr(text, '-');
    const size_t length = dash ? (size_t)(dash - text) : strlen(text);
    if (length >= 32)
        return -1;
    memcpy(first, text, length);
    first[length] = '\0';
    *second = dash ? dash + 1 : NULL;
    return 0;
}

static int parse_range(const char *option, const char *text, mux_range *range) {
    char first[32];
    const char *second;
    range->given = 1;
    range->last = UINT32_MAX;
    int bad = split_range(text, first, &second) != 0 || nsdf_cli_parse_u32(first, 0, INT32_MAX, &range->first) != 0;
    if (!bad && !second)
        range->last = range->first;
    if (!bad && second && *second)
        bad = nsdf_cli_parse_u32(second, range->first, INT32_MAX, &range->last) != 0;
    return bad ? nsdf_cli_bad_value(option, text, "a range of numbers such as 10-20, 10- or 10") : NSDF_CLI_SUCCESS;
}

static int parse_times(const char *text, mux_options *o) {
    char first[32];
    const char *second;
    o->has_times = 1;
    o->to = HUGE_VAL;
    int bad = split_range(text, first, &second) != 0 || nsdf_cli_parse_double(first, &o->from) != 0;
    if (!bad && !second)
        o->to = o->from;
    if (!bad && second && *second)
        bad = nsdf_cli_parse_double(second, &o->to) != 0;
    return bad || o->to < o->from ? nsdf_cli_bad_value("--times", text, "a range of seconds such as 1.5-3, 1.5- or 1.5")
                                  : NSDF_CLI_SUCCESS;
}

static int add_pair(mux_options *o, const char *text, int removes) {
    const char *equals = removes ? text + strlen(text) : strchr(text, '=');
    if (!equals || equals == text)
        return nsdf_cli_bad_value(removes ? "--remove" : "--set", text, removes ? "a key" : "KEY=VALUE");
    mux_pair *grown = realloc(o->pairs, ((size_t)o->pair_count + 1) * sizeof *grown);
    if (grown)
        o->pairs = grown;
    char *key = malloc((size_t)(equals - text) + 1);
    if (!grown || !key) {
        free(key);
        nsdf_cli_error("out of memory");
        return NSDF_CLI_FAILURE;
    }
    memcpy(key, text, (size_t)(equals - text));
    key[equals - text] = '\0';
    o->pairs[o->pair_count++] = (mux_pair){key, removes ? NULL : equals + 1};
    return NSDF_CLI_SUCCESS;
}

static int set_action(mux_options *o, mux_action action) {
    if (o->action != MUX_WRITE && o->action != action)
        return nsdf_cli_usage_error("--info and --validate exclude each other");
    o->action = action;
    return NSDF_CLI_SUCCESS;
}

/* ---- Options --------------------------------------------------------------------------------------------------- */

static int set_value(int option, const char *text, mux_options *o) {
    switch (option) {
    case OPTION_FADE:
        o->has_fade = 1;
        return nsdf_cli_take_count("--fade", text, 0, INT32_MAX, &o->fade);
    case OPTION_REPLACE:
        return parse_range("--replace", text, &o->replaced);
    case OPTION_WITH:
        o->with = text;
        return NSDF_CLI_SUCCESS;
    case OPTION_FRAMES:
        return parse_range("--frames", text, &o->frames);
    case OPTION_TIMES:
        return parse_times(text, o);
    case OPTION_SEGMENTS:
        return parse_range("--segments", text, &o->segments);
    case OPTION_FPS:
        return nsdf_cli_take_rate("--fps", text, &o->rate_num, &o->rate_den);
    case OPTION_HOLD:
        return nsdf_cli_take_count("--hold", text, 1, INT32_MAX, &o->hold);
    case OPTION_SET:
        return add_pair(o, text, 0);
    case OPTION_REMOVE:
        return add_pair(o, text, 1);
    default: /* 'o' */
        o->output = text;
        return NSDF_CLI_SUCCESS;
    }
}

static int set_flag(int option, mux_options *o) {
    switch (option) {
    case OPTION_SHARED:
        o->shared = 1;
        return NSDF_CLI_SUCCESS;
    case OPTION_INFO:
        return set_action(o, MUX_INFO);
    case OPTION_VALIDATE:
        return set_action(o, MUX_VALIDATE);
    case 'q':
        nsdf_cli_set_verbosity(-1);
        return NSDF_CLI_SUCCESS;
    default: /* 'v' */
        nsdf_cli_set_verbosity(1);
        return NSDF_CLI_SUCCESS;
    }
}

static int changes_anything(const mux_options *o) {
    return o->frames.given || o->has_times || o->segments.given || o->replaced.given || o->with || o->has_fade ||
           o->shared || o->rate_num || o->hold || o->pair_count > 0;
}

static int check(const mux_options *o) {
    if (o->input_count == 0)
        return nsdf_cli_usage_error("no input file: name an .nsdf file");
    if (o->action != MUX_WRITE && (o->output || changes_anything(o)))
        return nsdf_cli_usage_error("--info and --validate take no other options than -q and -v");
    if (o->action == MUX_INFO && o->input_count > 1)
        return nsdf_cli_usage_error("--info takes one file at a time, not also '%s'", o->inputs[1]);
    if (o->action == MUX_WRITE && (!o->output || !*o->output))
        return nsdf_cli_usage_error("no output: use -o, for example -o out.nsdf");
    if (o->frames.given + o->has_times + o->segments.given > 1)
        return nsdf_cli_usage_error("--frames, --times and --segments exclude each other");
    if (o->replaced.given != (o->with != NULL))
        return nsdf_cli_usage_error("--replace and --with go together");
    if (o->input_count == 1 && (o->has_fade || o->shared))
        return nsdf_cli_usage_error("--fade and --shared are for joining several files");
    return NSDF_CLI_SUCCESS;
}

int mux_options_parse(int argc, char **argv, mux_options *options) {
    memset(options, 0, sizeof *options);
    options->action = MUX_WRITE;
    opterr = 0;
    for (int option; (option = getopt_long(argc, argv, ":o:qvh", long_options, NULL)) != -1;) {
        if (option == ':' || option == '?')
            return nsdf_cli_refuse_option(option, argc, argv, long_options);
        if (option == 'h' || option == OPTION_VERSION) {
            options->action = MUX_NOTHING;
            if (option == 'h')
                fputs(help, stdout);
            else
                printf("nsdf-mux %s\n", nsdf_version_string());
            return NSDF_CLI_SUCCESS;
        }
        const int result =
            nsdf_cli_takes_value(option, long_options) ? set_value(option, optarg, options) : set_flag(option, options);
        if (result != NSDF_CLI_SUCCESS)
            return result;
    }
    options->inputs = argv + optind;
    options->input_count = argc - optind;
    return check(options);
}

void mux_options_free(mux_options *options) {
    for (int i = 0; i < options->pair_count; i++)
        free(options->pairs[i].key);
    free(options->pairs);
    memset(options, 0, sizeof *options);
}
