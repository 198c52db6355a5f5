/* The clock of playback: which time of the file belongs to which time on the wall.  Knows nothing of threads, of
 * windows, or of how late it is: the caller says. */
#ifndef PLAY_CLOCK_H
#define PLAY_CLOCK_H

typedef struct play_clock {
    double duration; /* of the file, seconds */
    double hold;     /* how long the last frame stays before a loop begins anew, seconds of the file */
    double speed;    /* seconds of the file for one on the wall; negative = backwards, never 0 */
    int playing, loop;
    double at, since; /* time of the file at a time on the wall */
} play_clock;

#define PLAY_SLOWEST (1.0 / 64)
#define PLAY_FASTEST 8.0

/* At the start, paused, looping. */
play_clock play_clock_make(double duration, double hold);

/* Time of the file at `wall`, in [0, duration].  Where it does not loop, it stays at the end. */
double play_clock_time(const play_clock *clock, double wall);
/* Whether it moves at `wall`: playing, and not at its end. */
int play_clock_moves(const play_clock *clock, double wall);

/* All of these go on from where the clock is at `wall`. */
void play_clock_play(play_clock *clock, double wall); /* from the other end, if it is at its end */
void play_clock_pause(play_clock *clock, double wall);
void play_clock_seek(play_clock *clock, double wall, double time); /* clamped to [0, duration] */
/* |speed| is clamped to PLAY_SLOWEST .. PLAY_FASTEST. */
void play_clock_set_speed(play_clock *clock, double wall, double speed);
void play_clock_set_loop(play_clock *clock, double wall, int loop);

#endif
