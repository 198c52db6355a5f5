#include "cli_times.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli_list.h"
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

typedef struct builder {
    sequence sequence;
    nsdf_cli_times *times;
    uint32_t capacity;
} builder;

static int sequence_start(const nsdf_cli_choice *choice, const nsdf_decoder *decoder, sequence *s) {
    nsdf_info info;
    if (nsdf_get_info(decoder, &info) != NSDF_OK)
        return NSDF_CLI_FAILURE;
    *s = (sequence){decoder, choice->rate_num, choice->rate_den, info.duration, info.frame_count};
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

static int add_time(builder *b, double seconds) {
    nsdf_cli_times *times = b->times;
    if (times->count == b->capacity) {
        if (b->capacity >= MOST_FRAMES) {
            nsdf_cli_error("more than %d frames", MOST_FRAMES);
            return NSDF_CLI_FAILURE;
        }
        b->capacity = 2 * b->capacity + 64;
        double *grown = realloc(times->seconds, b->capacity * sizeof *grown);
        if (!grown) {
            nsdf_cli_error("out of memory");
            return NSDF_CLI_FAILURE;
        }
        times->seconds = grown;
    }
    times->seconds[times->count++] = seconds;
    return NSDF_CLI_SUCCESS;
}

static int add_second(void *user, const char *text) {
    builder *b = user;
    const double duration = b->sequence.duration;
    double seconds;
    if (nsdf_cli_parse_double(text, &seconds) != 0)
        return nsdf_cli_usage_error("--times: '%s' is not a number of seconds", text);
    if (seconds < 0 || seconds > duration * (1 + end_tolerance))
        return nsdf_cli_usage_error("--times: %s s is out of range, the file goes from 0 to %.9g s", text, duration);
    return add_time(b, fmin(seconds, duration));
}

static int add_frames(builder *b, const char *frames) {
    nsdf_cli_list list;
    int result = frames ? nsdf_cli_list_parse(&list, "--frames", frames, b->sequence.count)
                        : nsdf_cli_list_all(&list, b->sequence.count);
    for (uint32_t i = 0; i < list.count && result == NSDF_CLI_SUCCESS; i++)
        result = add_time(b, sequence_time(&b->sequence, list.numbers[i]));
    nsdf_cli_list_free(&list);
    return result;
}

int nsdf_cli_times_choose(const nsdf_cli_choice *choice, const nsdf_decoder *decoder, nsdf_cli_times *times) {
    builder b = {.times = times};
    memset(times, 0, sizeof *times);
    const int result = sequence_start(choice, decoder, &b.sequence);
    if (result != NSDF_CLI_SUCCESS)
        return result;
    return choice->times ? nsdf_cli_each_item(choice->times, add_second, &b) : add_frames(&b, choice->frames);
}

void nsdf_cli_times_free(nsdf_cli_times *times) {
    free(times->seconds);
    memset(times, 0, sizeof *times);
}
