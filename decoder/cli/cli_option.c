#include "cli_option.h"

#include "cli_util.h"

/* getopt_long leaves in optopt: 0 for an unknown long option, the value of a known one that was given a value it does
 * not take, or the letter of an unknown short one. */
int nsdf_cli_refuse_option(int answer, int argc, char **argv, const struct option *options) {
    const char *word = argv[optind - 1 < argc ? optind - 1 : argc - 1];
    if (answer == ':')
        return nsdf_cli_usage_error("option '%s' needs a value", word);
    if (optopt == 0)
        return nsdf_cli_usage_error("unknown option '%s'", word);
    for (const struct option *o = options; o->name; o++)
        if (o->val == optopt)
            return nsdf_cli_usage_error("option '--%s' takes no value", o->name);
    return nsdf_cli_usage_error("unknown option '-%c'", optopt);
}
