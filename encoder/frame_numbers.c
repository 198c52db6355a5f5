#include "frame_numbers.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "input_error.h"
#include "rate_fit.h"

#define MAX_DIGITS 18

static bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

/* ---- Numbers in names ---- */

/* Reads the digits at *at and moves behind them; false when there are none, or too many. */
static bool take_digits(const char **at, uint64_t *number) {
    size_t count = 0;
    for (*number = 0; is_digit((*at)[count]) && count <= MAX_DIGITS; count++) {
        *number = 10 * *number + (uint64_t)((*at)[count] - '0');
    }
    *at += count;
    return count > 0 && count <= MAX_DIGITS;
}

bool nsdf_number_pair(const char *a, const char *b, uint64_t numbers[2]) {
    size_t same = 0;
    while (a[same] != '\0' && a[same] == b[same]) {
        same++;
    }
    while (same > 0 && is_digit(a[same - 1])) {
        same--;
    }
    a += same;
    b += same;
    return take_digits(&a, &numbers[0]) && take_digits(&b, &numbers[1]) && strcasecmp(a, b) == 0;
}

static uint64_t greatest_common_divisor(uint64_t a, uint64_t b) {
    while (b != 0) {
        const uint64_t rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

/* By how much the number grows from file i - 1 to file i; 0 when their names are not alike, and UINT64_MAX when it does
 * not grow. */
static uint64_t growth(const nsdf_path_list *files, size_t i) {
    uint64_t n[2];
    const char *before = files->items[i - 1].path, *now = files->items[i].path;
    if (strcmp(before, now) == 0) {
        return UINT64_MAX;
    }
    if (!nsdf_number_pair(before, now, n)) {
        return 0;
    }
    return n[1] > n[0] ? n[1] - n[0] : UINT64_MAX;
}

/* The step of the numbers that is one frame; 0 when numbers do not tell the order of the files. */
static uint64_t find_step(const nsdf_path_list *files) {
    uint64_t step = 0;
    for (size_t i = 1; i < files->count; i++) {
        const uint64_t grown = growth(files, i);
        if (grown == UINT64_MAX) {
            return 0;
        }
        step = greatest_common_divisor(grown, step);
    }
    return step;
}

static nsdf_status number_by_names(const nsdf_path_list *files, uint64_t step, uint32_t *numbers,
                                   nsdf_encoder_error *error) {
    uint64_t number = 0;
    for (size_t i = 0; i < files->count; i++) {
        const uint64_t grown = i > 0 && step > 0 ? growth(files, i) / step : 0;
        number += i > 0 ? (grown > 0 ? grown : 1) : 0;
        if (number >= UINT32_MAX) {
            return nsdf_input_fail(error, NSDF_LIMIT,
                                   "%s: its number is too far from that of the first file to count frames; "
                                   "--numbers ignore takes files one after the other",
                                   nsdf_show_path(files->items[i].path).text);
        }
        numbers[i] = (uint32_t)number;
    }
    return NSDF_OK;
}

/* ---- Times in a list file ---- */

static nsdf_status refuse_time(const nsdf_path_list *files, size_t i, const nsdf_sequence_options *o,
                               nsdf_encoder_error *error) {
    char advice[64] = "";
    double *times = malloc(files->count * sizeof *times);
    for (size_t k = 0; times != NULL && k < files->count; k++) {
        times[k] = files->items[k].seconds - files->items[0].seconds;
    }
    uint32_t rate[2];
    if (times != NULL && nsdf_fit_rate(times, files->count, 1, rate)) {
        nsdf_rate_text text = nsdf_show_rate(rate[0], rate[1]);
        snprintf(advice, sizeof advice, "; all times fit --fps %s", text.text);
    }
    free(times);
    return nsdf_input_fail(error, NSDF_CORRUPT, "%s:%u: %.9g s is not the time of a frame at %s frames a second%s",
                           nsdf_show_path(files->timed_list).text, files->items[i].line, files->items[i].seconds,
                           nsdf_show_rate(o->rate_num, o->rate_den).text, advice);
}

static nsdf_status number_by_times(const nsdf_path_list *files, const nsdf_sequence_options *o, uint32_t *numbers,
                                   nsdf_encoder_error *error) {
    for (size_t i = 0; i < files->count; i++) {
        const double since = files->items[i].seconds - files->items[0].seconds;
        const double frames = since * o->rate_num / o->rate_den;
        if (frames >= UINT32_MAX) {
            return nsdf_input_fail(error, NSDF_LIMIT, "%s:%u: %.9g s is too late to count frames",
                                   nsdf_show_path(files->timed_list).text, files->items[i].line,
                                   files->items[i].seconds);
        }
        if (!nsdf_is_frame_time(since, o->rate_num, o->rate_den)) {
            return refuse_time(files, i, o, error);
        }
        numbers[i] = (uint32_t)llround(frames);
        if (i > 0 && numbers[i] == numbers[i - 1]) {
            return refuse_time(files, i, o, error);
        }
    }
    return NSDF_OK;
}

nsdf_status nsdf_number_frames(const nsdf_path_list *files, const nsdf_sequence_options *options, uint32_t *numbers,
                               nsdf_encoder_error *error) {
    if (files->timed_list != NULL && !options->ignore_numbers) {
        return number_by_times(files, options, numbers, error);
    }
    return number_by_names(files, options->ignore_numbers ? 0 : find_step(files), numbers, error);
}
