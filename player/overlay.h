/* Flat things over a picture: rectangles and text, in pixels from the upper left corner. */
#ifndef PLAY_OVERLAY_H
#define PLAY_OVERLAY_H

#include <stddef.h>

typedef struct play_overlay_corner {
    float x, y;
    unsigned char rgba[4];
} play_overlay_corner;

typedef struct play_overlay {
    play_overlay_corner *corners; /* three for each triangle; owned */
    size_t count, capacity;
} play_overlay;

void play_overlay_clear(play_overlay *overlay);
void play_overlay_free(play_overlay *overlay);

/* 0xrrggbbaa */
typedef unsigned int play_colour;

/* What there is no memory for is left out. */
void play_overlay_box(play_overlay *overlay, float x, float y, float width, float height, play_colour colour);
/* ASCII; lines end with \n.  At `scale` a line is 12 * scale pixels high. */
void play_overlay_text(play_overlay *overlay, float x, float y, float scale, play_colour colour, const char *text);
float play_overlay_text_width(const char *text, float scale);
float play_overlay_text_height(const char *text, float scale);

#endif
