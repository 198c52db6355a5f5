#include "rate_fit.h"

#include <math.h>
#include <stdio.h>

/* Of an interval between frames. */
static const double most_beside = 0.1, closely = 0.02;

static bool is_within(double seconds, uint32_t rate_num, uint32_t rate_den, double tolerance) {
    const double frames = seconds * rate_num / rate_den;
    return fabs(frames - round(frames)) <= tolerance + 1e-9;
}

bool nsdf_is_frame_time(double seconds, uint32_t rate_num, uint32_t rate_den) {
    return is_within(seconds, rate_num, rate_den, most_beside);
}

static bool fits(const double *seconds, size_t count, const uint32_t rate[2], double tolerance) {
    double before = -1.0;
    for (size_t i = 0; i < count; i++) {
        const double frame = round(seconds[i] * rate[0] / rate[1]);
        if (!is_within(seconds[i], rate[0], rate[1], tolerance) || !(frame > before)) {
            return false;
        }
        before = frame;
    }
    return true;
}

bool nsdf_fits_closely(const double *seconds, size_t count, uint32_t rate_num, uint32_t rate_den) {
    const uint32_t rate[2] = {rate_num, rate_den};
    return fits(seconds, count, rate, closely);
}

bool nsdf_fit_rate(const double *seconds, size_t count, uint32_t least, uint32_t rate[2]) {
    static const uint32_t usual[][2] = {{1, 1},   {2, 1},   {5, 1},   {6, 1},        {8, 1},   {10, 1},  {12, 1},
                                        {15, 1},  {20, 1},  {24, 1},  {24000, 1001}, {25, 1},  {30, 1},  {30000, 1001},
                                        {48, 1},  {50, 1},  {60, 1},  {60000, 1001}, {72, 1},  {75, 1},  {90, 1},
                                        {96, 1},  {100, 1}, {120, 1}, {144, 1},      {150, 1}, {200, 1}, {240, 1},
                                        {250, 1}, {300, 1}, {480, 1}, {500, 1},      {600, 1}, {1000, 1}};
    const size_t rates = sizeof usual / sizeof usual[0];
    for (size_t i = 0; i < 2 * rates; i++) {
        const uint32_t *tried = usual[i % rates];
        if (tried[0] >= (uint64_t)least * tried[1] && fits(seconds, count, tried, i < rates ? closely : most_beside)) {
            rate[0] = tried[0];
            rate[1] = tried[1];
            return true;
        }
    }
    return false;
}

nsdf_rate_text nsdf_show_rate(uint32_t rate_num, uint32_t rate_den) {
    nsdf_rate_text shown;
    if (rate_den == 1) {
        snprintf(shown.text, sizeof shown.text, "%u", rate_num);
    } else {
        snprintf(shown.text, sizeof shown.text, "%u/%u", rate_num, rate_den);
    }
    return shown;
}
