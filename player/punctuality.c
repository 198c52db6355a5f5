#include "punctuality.h"

#include <math.h>
#include <stdio.h>

play_punctuality play_punctuality_make(void) {
    return (play_punctuality){.waiting = -1.0, .fresh = 1};
}

void play_punctuality_jump(play_punctuality *p, double wall) {
    if (p->waiting < 0.0)
        p->waiting = wall;
    p->fresh = 1;
}

void play_punctuality_shown(play_punctuality *p, const play_clock *clock, double time, double wall) {
    const double period = clock->duration + clock->hold;
    if (p->shown++ == 0)
        p->began = wall;
    p->last = wall;
    if (p->waiting >= 0.0) {
        p->slowest_jump = fmax(p->slowest_jump, wall - p->waiting);
        p->waiting = -1.0;
    }
    if (!p->fresh && play_clock_moves(clock, wall)) {
        double off = fabs(play_clock_time(clock, wall) - time);
        if (clock->loop) /* the loop may have closed in between */
            off = fmin(off, fabs(period - off));
        off /= fabs(clock->speed);
        p->worst = fmax(p->worst, off);
        p->total += off;
        p->judged++;
    }
    p->fresh = 0;
}

void play_punctuality_print(const play_punctuality *p, uint64_t skipped, uint32_t resolution, double drawing) {
    const double span = p->last - p->began;
    printf("surfaces shown %llu, %.2f a second; skipped %llu; resolution %u; drawing %.1f ms\n",
           (unsigned long long)p->shown, span > 0.0 ? ((double)p->shown - 1.0) / span : 0.0,
           (unsigned long long)skipped, (unsigned)resolution, 1e3 * drawing);
    printf("off the clock: %.1f ms at most, %.1f ms on average\n", 1e3 * p->worst,
           p->judged ? 1e3 * p->total / (double)p->judged : 0.0);
    printf("slowest jump: %.1f ms\n", 1e3 * p->slowest_jump);
}
