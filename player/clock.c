#include "clock.h"

#include <math.h>

play_clock play_clock_make(double duration, double hold) {
    return (play_clock){.duration = duration, .hold = hold, .speed = 1.0, .loop = 1};
}

static double clamp(double x, double low, double high) {
    return x < low ? low : x > high ? high : x;
}

/* With the hold: in [0, duration + hold] where it loops. */
static double position(const play_clock *c, double wall) {
    const double period = c->duration + c->hold;
    double at = c->at;
    if (c->playing)
        at += (wall - c->since) * c->speed;
    if (!c->loop || !(period > 0.0))
        return clamp(at, 0.0, c->duration);
    at = fmod(at, period);
    return at < 0.0 ? at + period : at;
}

double play_clock_time(const play_clock *c, double wall) {
    return fmin(position(c, wall), c->duration);
}

int play_clock_moves(const play_clock *c, double wall) {
    if (!c->playing || !(c->duration > 0.0))
        return 0;
    const double at = position(c, wall);
    return c->loop || (c->speed > 0.0 ? at < c->duration : at > 0.0);
}

static void rebase(play_clock *c, double wall) {
    c->at = position(c, wall);
    c->since = wall;
}

void play_clock_play(play_clock *c, double wall) {
    rebase(c, wall);
    c->playing = 1;
    if (!play_clock_moves(c, wall))
        c->at = c->speed > 0.0 ? 0.0 : c->duration;
}

void play_clock_pause(play_clock *c, double wall) {
    rebase(c, wall);
    c->at = fmin(c->at, c->duration);
    c->playing = 0;
}

void play_clock_seek(play_clock *c, double wall, double time) {
    c->at = clamp(time, 0.0, c->duration);
    c->since = wall;
}

void play_clock_set_speed(play_clock *c, double wall, double speed) {
    const double size = clamp(fabs(speed), PLAY_SLOWEST, PLAY_FASTEST);
    rebase(c, wall);
    c->speed = speed < 0.0 ? -size : size;
}

void play_clock_set_loop(play_clock *c, double wall, int loop) {
    rebase(c, wall);
    c->at = fmin(c->at, c->duration);
    c->loop = loop;
}
