#include "dec_times.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli_util.h"

enum { MOST_FRAMES = 10000000 };

/* Times at the end of the sequence are often rounded; so much beyond it still counts as the end. */
static const double end_tolerance = 1e-9;

/* The frames that --frames counts: the nominal ones, or those of --fps. */
typedef struct sequence {
    const nsdf_decoder *decoder;
    uint32_t rate_num, rate_den; /* rate_num 0 = nominal */
    double duration;
    uint32_t count;
} sequence;

static int sequence_start(const dec_options *options, const nsdf_decoder *decoder, sequence *s) {
    nsdf_info info;
    if (nsdf_get_info(decoder, &info) != NSDF_OK)
        return NSDF_CLI_FAILURE;
    *s = (sequence){decoder, options->rate_num, options->rate_den, info.duration, info.frame_count};
    if (s->rate_num) {
        const double last = info.duration * s->rate_num / s->rate_den * (1 + end_tolerance);
        if (!(last < MOST_FRAMES)) {
            nsdf_cli_error("--fps gives more than %d frames", MOST_FRAMES);
            return NSDF_CLI_FAILURE;
        }
        s->count = (uint32_t)floor(last) + 1;
    }
    return NSDF_CLI_SUCCESS;
}

static double sequence_time(const sequence *s, uint32_t index) {
    double seconds = 0;
    if (s->rate_num)
        seconds = (double)index * s->rate_den / s->rate_num;
    else if (nsdf_frame_time(s->decoder, index, &seconds) != NSDF_OK)
        seconds = s->duration; /* cannot happen: index < count */
    return fmin(seconds, s->duration);
}

static int add_time(dec_times *times, uint32_t *capacity, double seconds) {
    if (times->count == *capacity) {
        if (*capacity >= MOST_FRAMES) {
            nsdf_cli_error("more than %d frames", MOST_FRAMES);
            return NSDF_CLI_FAILURE;
        }
        *capacity = 2 * *capacity + 64;
        double *grown = realloc(times->seconds, *capacity * sizeof *grown);
        if (!grown) {
            nsdf_cli_error("out of memory");
            return NSDF_CLI_FAILURE;
        }
        times->seconds = grown;
    }
    times->seconds[times->count++] = seconds;
    return NSDF_CLI_SUCCESS;
}

static int add_frames(const sequence *s, dec_times *times, uint32_t *capacity, uint32_t first, uint32_t last) {
    int result = NSDF_CLI_SUCCESS;
    for (uint32_t i = first; i <= last && result == NSDF_CLI_SUCCESS; i++)
        result = add_time(times, capacity, sequence_time(s, i));
    return result;
}

/* "7" or "0-9". */
static int add_range(const sequence *s, char *text, dec_times *times, uint32_t *capacity) {
    uint32_t first, last;
    char *dash = strchr(text, '-');
    if (dash)
        *dash = 0;
    const int good = nsdf_cli_parse_u32(text, 0, UINT32_MAX, &first) == 0 &&
                     nsdf_cli_parse_u32(dash ? dash + 1 : text, 0, UINT32_MAX, &last) == 0;
    if (dash)
        *dash = '-';
    if (!good)
        return nsdf_cli_usage_error("--frames: '%s' is not a number or a range such as 0-9", text);
    if (first > last)
        return nsdf_cli_usage_error("--frames: '%s' runs backwards", text);
    if (last >= s->count)
        return nsdf_cli_usage_error("--frames: there is no frame %lu, they go from 0 to %lu", (unsigned long)last,
                                    (unsigned long)s->count - 1);
    return add_frames(s, times, capacity, first, last);
}

static int add_second(const sequence *s, char *text, dec_times *times, uint32_t *capacity) {
    double seconds;
    if (nsdf_cli_parse_double(text, &seconds) != 0)
        return nsdf_cli_usage_error("--times: '%s' is not a number of seconds", text);
    if (seconds < 0 || seconds > s->duration * (1 + end_tolerance))
        return nsdf_cli_usage_error("--times: %s s is out of range, the file goes from 0 to %.9g s", text, s->duration);
    return add_time(times, capacity, fmin(seconds, s->duration));
}

typedef int (*item_fn)(const sequence *s, char *text, dec_times *times, uint32_t *capacity);

static int add_list(const sequence *s, const char *list, item_fn add, dec_times *times, uint32_t *capacity) {
    char *const copy = malloc(strlen(list) + 1);
    if (!copy) {
        nsdf_cli_error("out of memory");
        return NSDF_CLI_FAILURE;
    }
    strcpy(copy, list);
    int result = NSDF_CLI_SUCCESS;
    for (char *item = copy; item && result == NSDF_CLI_SUCCESS;) {
        char *comma = strchr(item, ',');
        if (comma)
            *comma = 0;
        result = add(s, item, times, capacity);
        item = comma ? comma + 1 : NULL;
    }
    free(copy);
    return result;
}

int dec_times_choose(const dec_options *options, const nsdf_decoder *decoder, dec_times *times) {
    sequence s;
    uint32_t capacity = 0;
    memset(times, 0, sizeof *times);
    const int result = sequence_start(options, decoder, &s);
    if (result != NSDF_CLI_SUCCESS)
        return result;
    if (options->times)
        return add_list(&s, options->times, add_second, times, &capacity);
    if (options->frames)
        return add_list(&s, options->frames, add_range, times, &capacity);
    return add_frames(&s, times, &capacity, 0, s.count - 1);
}

void dec_times_free(dec_times *times) {
    free(times->seconds);
    memset(times, 0, sizeof *times);
}
