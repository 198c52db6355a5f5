#include "overlay.h"

#include <stdlib.h>
#include <string.h>

#include <stb/stb_easy_font.h>

enum { QUAD_BYTES = 4 * 16, MOST_TEXT = 2000, LINE_HEIGHT = 12 };

void play_overlay_clear(play_overlay *o) {
    o->count = 0;
}

void play_overlay_free(play_overlay *o) {
    free(o->corners);
    memset(o, 0, sizeof *o);
}

static int need(play_overlay *o, size_t more) {
    if (o->count + more <= o->capacity)
        return 0;
    const size_t capacity = 2 * o->capacity + more;
    play_overlay_corner *corners = realloc(o->corners, capacity * sizeof *corners);
    if (!corners)
        return -1;
    o->corners = corners;
    o->capacity = capacity;
    return 0;
}

void play_overlay_box(play_overlay *o, float x, float y, float width, float height, play_colour colour) {
    static const unsigned char corner[6][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
    if (need(o, 6) != 0)
        return;
    for (int i = 0; i < 6; i++) {
        play_overlay_corner *c = &o->corners[o->count++];
        c->x = x + (corner[i][0] ? width : 0.0f);
        c->y = y + (corner[i][1] ? height : 0.0f);
        for (int k = 0; k < 4; k++)
            c->rgba[k] = (unsigned char)(colour >> (24 - 8 * k));
    }
}

/* The library's quads are upright rectangles: corners 0 and 2 are opposite. */
void play_overlay_text(play_overlay *o, float x, float y, float scale, play_colour colour, const char *text) {
    const size_t length = strlen(text), used = length < MOST_TEXT ? length : MOST_TEXT;
    const size_t size = (used + 1) * 300; /* the library's own estimate is 270 bytes a character */
    char copy[MOST_TEXT + 1];
    float *quads = malloc(size);
    if (!quads)
        return;
    memcpy(copy, text, used);
    copy[used] = '\0';
    const int count = stb_easy_font_print(0.0f, 0.0f, copy, NULL, quads, (int)size);
    for (int i = 0; i < count; i++) {
        const float *a = quads + (size_t)i * QUAD_BYTES / sizeof *quads, *b = a + 2 * 4;
        play_overlay_box(o, x + scale * a[0], y + scale * a[1], scale * (b[0] - a[0]), scale * (b[1] - a[1]), colour);
    }
    free(quads);
}

float play_overlay_text_width(const char *text, float scale) {
    char copy[MOST_TEXT + 1];
    const size_t length = strlen(text), used = length < MOST_TEXT ? length : MOST_TEXT;
    memcpy(copy, text, used);
    copy[used] = '\0';
    return scale * (float)stb_easy_font_width(copy);
}

float play_overlay_text_height(const char *text, float scale) {
    int lines = 1;
    for (const char *c = text; *c; c++)
        lines += *c == '\n';
    return scale * (float)(LINE_HEIGHT * lines);
}
