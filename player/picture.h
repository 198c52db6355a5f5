/* Pictures as bytes: PNG, and raw frames of a film. */
#ifndef PLAY_PICTURE_H
#define PLAY_PICTURE_H

#include <stddef.h>

/* Takes `size` bytes; returns 0, or nonzero to stop. */
typedef int (*play_write_fn)(void *user, const void *data, size_t size);

/* rgba[4 * width * height], rows from the top; without alpha, pixels are taken as opaque.  All return 0, or -1 when
 * writing failed or memory ran out. */
int play_write_png(const unsigned char *rgba, int width, int height, int alpha, play_write_fn write, void *user);
int play_write_rgba(const unsigned char *rgba, int width, int height, play_write_fn write, void *user);

/* A film as YUV4MPEG2, 4:4:4, with the colours of BT.601 in limited range, as players take it without being told
 * otherwise: first a header, then every frame. */
int play_write_y4m_header(int width, int height, unsigned rate_num, unsigned rate_den, play_write_fn write, void *user);
int play_write_y4m_frame(const unsigned char *rgba, int width, int height, play_write_fn write, void *user);

#endif
