/* Messages and numbers of the command-line programs. */
#include "cli_util.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* A program has one name, one stderr and one verbosity; passing them through every call would say no more. */
static const char *program_name = "nsdf";
static int verbosity;
static size_t progress_length; /* characters of the progress line on the screen */

double nsdf_cli_clock(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void nsdf_cli_get_error(const nsdf_decoder *decoder, nsdf_status status, nsdf_error *error) {
    if (nsdf_get_error(decoder, error) != NSDF_OK || error->status != status)
        *error = (nsdf_error){.status = status};
}

/* ---- Messages ---------------------------------------------------------------------------------------------- */

void nsdf_cli_begin(const char *program) {
    program_name = program;
}

void nsdf_cli_set_verbosity(int level) {
    verbosity = level;
}

int nsdf_cli_verbosity(void) {
    return verbosity;
}

static void clear_progress(void) {
    if (progress_length > 0)
        fprintf(stderr, "\r%*s\r", (int)progress_length, "");
    progress_length = 0;
}

static void print_line(const char *kind, const char *format, va_list arguments, const char *end) {
    clear_progress();
    fprintf(stderr, "%s: %s", program_name, kind);
    vfprintf(stderr, format, arguments);
    fprintf(stderr, "%s\n", end);
}

void nsdf_cli_error(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    print_line("", format, arguments, "");
    va_end(arguments);
}

void nsdf_cli_warn(const char *format, ...) {
    va_list arguments;
    if (verbosity < 0)
        return;
    va_start(arguments, format);
    print_line("warning: ", format, arguments, "");
    va_end(arguments);
}

void nsdf_cli_say(const char *format, ...) {
    va_list arguments;
    if (verbosity < 0)
        return;
    va_start(arguments, format);
    print_line("", format, arguments, "");
    va_end(arguments);
}

void nsdf_cli_verbose(const char *format, ...) {
    va_list arguments;
    if (verbosity < 1)
        return;
    va_start(arguments, format);
    print_line("", format, arguments, "");
    va_end(arguments);
}

int nsdf_cli_usage_error(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    print_line("", format, arguments, " (try --help)");
    va_end(arguments);
    return NSDF_CLI_USAGE;
}

/* Statuses whose messages leave nothing to add. */
static int is_told_by_message(nsdf_status status) {
    return status == NSDF_IO || status == NSDF_NOT_NSDF || status == NSDF_LIMIT || status == NSDF_UNSUPPORTED_VERSION;
}

void nsdf_cli_nsdf_error(const char *file, const nsdf_error *error) {
    const char *what = error->message[0] ? error->message : nsdf_status_string(error->status);
    if (error->chunk[0] && !is_told_by_message(error->status))
        nsdf_cli_error("%s: %s in chunk %s at byte %llu (%s)", file, what, error->chunk,
                       (unsigned long long)error->offset, nsdf_status_string(error->status));
    else if (what == error->message && !is_told_by_message(error->status) &&
             strcmp(what, nsdf_status_string(error->status)) != 0)
        nsdf_cli_error("%s: %s (%s)", file, what, nsdf_status_string(error->status));
    else
        nsdf_cli_error("%s: %s", file, what);
}

void nsdf_cli_progress(const char *format, ...) {
    char text[200];
    va_list arguments;
    if (verbosity < 0 || !isatty(STDERR_FILENO))
        return;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    const size_t length = strlen(text);
    const int blanks = progress_length > length ? (int)(progress_length - length) : 0;
    fprintf(stderr, "\r%s%*s", text, blanks, "");
    fflush(stderr);
    progress_length = length;
}

/* ---- Numbers ----------------------------------------------------------------------------------------------- */

int nsdf_cli_parse_u64(const char *text, uint64_t *out) {
    if (!isdigit((unsigned char)text[0]))
        return -1; /* strtoull takes signs and blanks */
    char *end;
    errno = 0;
    const unsigned long long value = strtoull(text, &end, 10);
    if (*end || errno || value > UINT64_MAX)
        return -1;
    *out = value;
    return 0;
}

int nsdf_cli_parse_u32(const char *text, uint32_t min, uint32_t max, uint32_t *out) {
    uint64_t value;
    if (nsdf_cli_parse_u64(text, &value) != 0 || value < min || value > max)
        return -1;
    *out = (uint32_t)value;
    return 0;
}

/* The programs never call setlocale, so the point is '.'. */
int nsdf_cli_parse_double(const char *text, double *out) {
    char *end;
    if (!*text || isspace((unsigned char)text[0]))
        return -1;
    const double value = strtod(text, &end);
    if (*end || end == text || !isfinite(value))
        return -1;
    *out = value;
    return 0;
}

int nsdf_cli_parse_bytes(const char *text, uint64_t *out) {
    char digits[24];
    const size_t length = strspn(text, "0123456789");
    int shift = 0;
    if (length == 0 || length >= sizeof digits)
        return -1;
    memcpy(digits, text, length);
    digits[length] = 0;
    if (text[length]) {
        static const char suffixes[] = "kKmMgG";
        const char *suffix = strchr(suffixes, text[length]);
        if (!suffix || text[length + 1])
            return -1;
        shift = 10 * (int)((suffix - suffixes) / 2 + 1);
    }
    uint64_t value;
    if (nsdf_cli_parse_u64(digits, &value) != 0 || value > UINT64_MAX >> shift)
        return -1;
    *out = value << shift;
    return 0;
}

static uint64_t greatest_common_divisor(uint64_t a, uint64_t b) {
    while (b) {
        const uint64_t rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

/* "29.97" as 2997 / 100. */
static int parse_decimal(const char *text, uint64_t *num, uint64_t *den) {
    uint64_t n = 0, d = 1;
    int digits = 0, after_point = 0;
    for (; *text; text++) {
        if (*text == '.' && !after_point) {
            after_point = 1;
            continue;
        }
        if (!isdigit((unsigned char)*text) || ++digits > 18)
            return -1;
        n = 10 * n + (uint64_t)(*text - '0');
        if (after_point)
            d *= 10;
    }
    *num = n;
    *den = d;
    return digits > 0 ? 0 : -1;
}

int nsdf_cli_parse_rational(const char *text, uint32_t *num, uint32_t *den) {
    char upper[24];
    uint64_t n, d;
    const char *slash = strchr(text, '/');
    if (slash) {
        const size_t length = (size_t)(slash - text);
        if (length >= sizeof upper)
            return -1;
        memcpy(upper, text, length);
        upper[length] = 0;
        if (nsdf_cli_parse_u64(upper, &n) != 0 || nsdf_cli_parse_u64(slash + 1, &d) != 0)
            return -1;
    } else if (parse_decimal(text, &n, &d) != 0) {
        return -1;
    }
    if (n == 0 || d == 0)
        return -1;
    const uint64_t divisor = greatest_common_divisor(n, d);
    if (n / divisor > UINT32_MAX || d / divisor > UINT32_MAX)
        return -1;
    *num = (uint32_t)(n / divisor);
    *den = (uint32_t)(d / divisor);
    return 0;
}
