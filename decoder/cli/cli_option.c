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

int nsdf_cli_bad_value(const char *option, const char *text, const char *expected) {
    return nsdf_cli_usage_error("%s: '%s' is not %s", option, text, expected);
}

int nsdf_cli_take_count(const char *option, const char *text, uint32_t min, uint32_t max, uint32_t *out) {
    if (nsdf_cli_parse_u32(text, min, max, out) == 0)
        return NSDF_CLI_SUCCESS;
    return nsdf_cli_usage_error("%s: '%s' is not a whole number from %lu to %lu", option, text, (unsigned long)min,
                                (unsigned long)max);
}

int nsdf_cli_take_rate(const char *option, const char *text, uint32_t *num, uint32_t *den) {
    if (nsdf_cli_parse_rational(text, num, den) == 0)
        return NSDF_CLI_SUCCESS;
    return nsdf_cli_bad_value(option, text, "a rate such as 50, 29.97 or 60000/1001");
}

int nsdf_cli_takes_value(int option, const struct option *options) {
    for (const struct option *o = options; o->name; o++)
        if (o->val == option)
            return o->has_arg == required_argument;
    return 0;
}
