/* How punctual playback was: what --statistics prints. */
#ifndef PLAY_PUNCTUALITY_H
#define PLAY_PUNCTUALITY_H

#include <stdint.h>

#include "clock.h"

typedef struct play_punctuality {
    uint64_t shown;      /* surfaces */
    uint64_t judged;     /* of them while the clock moved, but the first after each jump */
    double worst, total; /* seconds on the wall that those were off the clock */
    double waiting;      /* since when a jump waits for its surface, on the wall; < 0 = none */
    double slowest_jump; /* seconds until its surface was shown */
    double began;        /* on the wall: when the first was shown */
    double last;
    int fresh;
} play_punctuality;

play_punctuality play_punctuality_make(void);
/* The clock jumps: whatever is shown next is what was asked for. */
void play_punctuality_jump(play_punctuality *p, double wall);
/* A new surface, of the time `time`, is on the screen at `wall`. */
void play_punctuality_shown(play_punctuality *p, const play_clock *clock, double time, double wall);
/* drawing: seconds that it takes. */
void play_punctuality_print(const play_punctuality *p, uint64_t skipped, uint32_t resolution, double drawing);

#endif
