/* Frame rates that go with times. */
#ifndef NSDF_RATE_FIT_H
#define NSDF_RATE_FIT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Whether a time, seconds from that of frame 0, is that of a frame: at most a tenth of an interval beside it. */
bool nsdf_is_frame_time(double seconds, uint32_t rate_num, uint32_t rate_den);

/* Whether all times are those of frames, each of another one, and closely so: within a fiftieth of an interval.
 * `seconds` ascend, and the first is 0. */
bool nsdf_fits_closely(const double *seconds, size_t count, uint32_t rate_num, uint32_t rate_den);

/* The lowest of the usual rates, from `least` frames a second on, at which all times are those of frames, each of
 * another one, and closely so if there is such a rate; false when there is none.  `seconds` ascend, and the first is 0.
 */
bool nsdf_fit_rate(const double *seconds, size_t count, uint32_t least, uint32_t rate[2]);

typedef struct nsdf_rate_text {
    char text[24];
} nsdf_rate_text;

/* As it is written on the command line: 25 or 30000/1001. */
nsdf_rate_text nsdf_show_rate(uint32_t rate_num, uint32_t rate_den);

#endif
