#include "pace.h"

#include <math.h>

static const uint32_t usual[] = {16,  24,  32,  48,  64,  80,  96,  112, 128, 160,
                                 192, 224, 256, 320, 384, 448, 512, 640, 768, 1024};
enum { USUAL = sizeof usual / sizeof *usual, CALM = 25 };
/* Of the time between two frames: what decoding may take, the rest being for drawing; and what it may be expected to
 * take for a higher resolution to be tried. */
static const double most_share = 0.8, good_share = 0.55;

play_pace play_pace_make(uint32_t first, uint32_t most) {
    return (play_pace){first < most ? first : most, most, 0.0, 0};
}

uint32_t play_pace_step(uint32_t resolution, int direction, uint32_t most) {
    uint32_t found = direction > 0 ? most : usual[0];
    for (int i = 0; i < USUAL; i++) {
        if (direction > 0 && usual[i] > resolution)
            return usual[i] < most ? usual[i] : most;
        if (direction < 0 && usual[i] < resolution)
            found = usual[i];
    }
    return found < most ? found : most;
}

/* Cells near a surface grow with the square of the resolution. */
static double cost_at(const play_pace *p, uint32_t resolution) {
    const double ratio = (double)resolution / (double)p->resolution;
    return p->cost * ratio * ratio;
}

static void go_to(play_pace *p, uint32_t resolution) {
    p->cost = cost_at(p, resolution);
    p->resolution = resolution;
    p->calm = 0;
}

int play_pace_note(play_pace *p, uint32_t resolution, double seconds, double interval, int late) {
    const uint32_t before = p->resolution;
    if (resolution != before)
        return 0;
    p->cost = p->cost > 0.0 ? 0.85 * p->cost + 0.15 * seconds : seconds;
    p->calm = late ? 0 : p->calm + 1;
    if (p->cost > most_share * interval || (late && seconds > good_share * interval)) {
        uint32_t to = play_pace_step(before, -1, p->most);
        while (cost_at(p, to) > most_share * interval && to > usual[0])
            to = play_pace_step(to, -1, p->most);
        go_to(p, to);
    } else if (p->calm >= CALM && before < p->most) {
        const uint32_t to = play_pace_step(before, 1, p->most);
        if (cost_at(p, to) < good_share * interval)
            go_to(p, to);
    }
    return p->resolution != before;
}
