/* Automatic resolution: the highest at which frames are ready in time.  A controller without clock or threads. */
#ifndef PLAY_PACE_H
#define PLAY_PACE_H

#include <stdint.h>

typedef struct play_pace {
    uint32_t resolution; /* to decode at */
    uint32_t most;       /* never above this */
    double cost;         /* of a frame at it, seconds: running mean; 0 = not known */
    uint32_t calm;       /* frames since something was late */
} play_pace;

play_pace play_pace_make(uint32_t first, uint32_t most);

/* A frame took `seconds` at `resolution`, was ready in time or `late`, and there is one every `interval` seconds.
 * Returns whether the resolution is another now. */
int play_pace_note(play_pace *pace, uint32_t resolution, double seconds, double interval, int late);

/* The next of the usual resolutions above (1) or below (-1), from 16 to `most`. */
uint32_t play_pace_step(uint32_t resolution, int direction, uint32_t most);

#endif
