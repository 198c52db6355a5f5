/* What is written over the picture: state of playback, time bar, help, messages. */
#ifndef PLAY_HUD_H
#define PLAY_HUD_H

#include <stdint.h>

#include "overlay.h"

typedef struct play_hud {
    const char *file;      /* name without folders */
    double time, duration; /* seconds */
    uint32_t frame_count;  /* encoded; 1 = no time bar */
    double frame_rate;     /* of the file */
    double speed;
    int playing, help;
    uint32_t resolution, vertices;
    double decode_seconds; /* of the frame; 0 = not known */
    double shown_rate;     /* surfaces a second; 0 = not known */
    uint64_t file_size;    /* bytes */
    const char *message;   /* or NULL */
} play_hud;

void play_hud_draw(play_overlay *overlay, const play_hud *hud, int width, int height);

/* A line of text in the upper left corner. */
void play_hud_caption(play_overlay *overlay, const char *text, int height);

/* The part of the time, 0 to 1, that a place in the picture stands for, or -1 outside of the time bar. */
double play_hud_time_at(int width, int height, double x, double y);

#endif
