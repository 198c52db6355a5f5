#include "hud.h"

#include <stdio.h>
#include <string.h>

static const play_colour ink = 0x20242cff, pale = 0x20242c90, bar = 0x20242c40, done = 0x2f6fd0ff, paper = 0xffffffd8,
                         red = 0xb02018ff;

static const char keys[] = "space          play, pause\n"
                           "left, right    one encoded frame back, on\n"
                           "up, down       a second on, back\n"
                           "home, end      first, last frame\n"
                           "0 ... 9        tenths of the duration\n"
                           "[ and ]        half, twice the speed;  backspace  1\n"
                           "r              backwards\n"
                           "l              begins again at the end, or not\n"
                           "m              shaded, flat, wire, normals\n"
                           "g              ghost: the encoded frame before\n"
                           "b              ground\n"
                           "t              turntable\n"
                           "f              fits the view\n"
                           "- and +        resolution down, up;  a  automatic\n"
                           "s              saves a picture\n"
                           "o              text on, off\n"
                           "h              this help;  q, esc  quit\n"
                           "mouse          left turns, right moves, wheel zooms";

static float scale_for(int height) {
    return height >= 1400 ? 3.0f : height >= 480 ? 2.0f : 1.0f;
}

/* Left, upper and right end, and height of the time bar. */
static void bar_place(int width, int height, float *left, float *top, float *right, float *thick) {
    const float s = scale_for(height);
    *left = 12.0f * s;
    *right = (float)width - 12.0f * s;
    *thick = 4.0f * s;
    *top = (float)height - 12.0f * s;
}

double play_hud_time_at(int width, int height, double x, double y) {
    float left, top, right, thick;
    bar_place(width, height, &left, &top, &right, &thick);
    if (y < (double)(top - 2.0f * thick) || right <= left)
        return -1.0;
    const double part = (x - (double)left) / (double)(right - left);
    return part < 0.0 ? 0.0 : part > 1.0 ? 1.0 : part;
}

static void draw_bar(play_overlay *o, const play_hud *h, int width, int height) {
    float left, top, right, thick;
    bar_place(width, height, &left, &top, &right, &thick);
    const float part = h->duration > 0.0 ? (float)(h->time / h->duration) : 0.0f, span = right - left;
    play_overlay_box(o, left, top, span, thick, bar);
    play_overlay_box(o, left, top, span * part, thick, done);
    play_overlay_box(o, left + span * part - 0.5f * thick, top - 0.5f * thick, thick, 2.0f * thick, done);
    if (span > 4.0f * (float)h->frame_count) /* a mark for each encoded frame */
        for (uint32_t i = 0; i < h->frame_count; i++)
            play_overlay_box(o, left + span * (float)i / (float)(h->frame_count - 1), top + thick, 1.0f, 0.75f * thick,
                             pale);
}

static void print_speed(char *text, size_t size, double speed) {
    const double magnitude = speed < 0.0 ? -speed : speed;
    const char *sign = speed < 0.0 ? "-" : "";
    if (magnitude < 1.0)
        snprintf(text, size, "%s1/%.3g", sign, 1.0 / magnitude);
    else
        snprintf(text, size, "%s%.3g", sign, magnitude);
}

static void draw_state(play_overlay *o, const play_hud *h, int height) {
    char text[512], speed[32], rate[32] = "", decoding[32] = "";
    print_speed(speed, sizeof speed, h->speed);
    if (h->shown_rate > 0.0)
        snprintf(rate, sizeof rate, ", %.1f a second", h->shown_rate);
    if (h->decode_seconds > 0.0)
        snprintf(decoding, sizeof decoding, ", %.1f ms", 1e3 * h->decode_seconds);
    const double kbits = h->duration > 0.0 ? 8e-3 * (double)h->file_size / h->duration : 0.0;
    snprintf(text, sizeof text,
             "%.120s\n%.3f of %.3f s, frame %.2f of %u%s%s\nresolution %u, %u vertices%s%s\n%.1f KB, %.1f kbit/s",
             h->file, h->time, h->duration, h->time * h->frame_rate, (unsigned)h->frame_count - 1,
             h->playing ? ", speed " : ", paused, speed ", speed, (unsigned)h->resolution, (unsigned)h->vertices,
             decoding, rate, 1e-3 * (double)h->file_size, kbits);
    play_hud_caption(o, text, height);
}

static void draw_panel(play_overlay *o, const char *text, float scale, play_colour colour, int width, int height) {
    const float w = play_overlay_text_width(text, scale), h = play_overlay_text_height(text, scale);
    const float x = 0.5f * ((float)width - w), y = 0.5f * ((float)height - h), edge = 12.0f * scale;
    play_overlay_box(o, x - edge, y - edge, w + 2.0f * edge, h + 1.5f * edge, paper);
    play_overlay_text(o, x, y, scale, colour, text);
}

void play_hud_caption(play_overlay *o, const char *text, int height) {
    const float scale = scale_for(height);
    play_overlay_text(o, 12.0f * scale, 10.0f * scale, scale, ink, text);
}

void play_hud_draw(play_overlay *o, const play_hud *h, int width, int height) {
    const float scale = scale_for(height);
    if (h->file)
        draw_state(o, h, height);
    if (h->file && h->frame_count > 1)
        draw_bar(o, h, width, height);
    if (h->message)
        draw_panel(o, h->message, scale, red, width, height);
    else if (h->help)
        draw_panel(o, keys, scale, ink, width, height);
}
