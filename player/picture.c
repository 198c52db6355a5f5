#include "picture.h"

#include <png.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>

/* ---- PNG ------------------------------------------------------------------------------------------------- */

typedef struct sink {
    play_write_fn write;
    void *user;
} sink;

static void write_bytes(png_structp png, png_bytep data, png_size_t size) {
    const sink *s = png_get_io_ptr(png);
    if (s->write(s->user, data, size) != 0)
        png_error(png, "cannot write");
}

static void flush_bytes(png_structp png) {
    (void)png;
}

/* Messages are the caller's: it knows what failed. */
static void quiet_error(png_structp png, png_const_charp message) {
    (void)message;
    png_longjmp(png, 1);
}

static void quiet_warning(png_structp png, png_const_charp message) {
    (void)png;
    (void)message;
}

static int write_rows(png_structp png, png_infop info, const unsigned char *rgba, int width, int height, int alpha) {
    if (setjmp(png_jmpbuf(png)) != 0)
        return -1;
    png_set_IHDR(png, info, (png_uint_32)width, (png_uint_32)height, 8,
                 alpha ? PNG_COLOR_TYPE_RGBA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_set_compression_level(png, 3); /* of pictures with smooth shades, 6 makes 4 % less in twice the time */
    png_set_filter(png, 0, PNG_FILTER_SUB);
    png_write_info(png, info);
    if (!alpha)
        png_set_filler(png, 0, PNG_FILLER_AFTER);
    for (int y = 0; y < height; y++)
        png_write_row(png, rgba + 4 * (size_t)width * (size_t)y);
    png_write_end(png, info);
    return 0;
}

int play_write_png(const unsigned char *rgba, int width, int height, int alpha, play_write_fn write, void *user) {
    sink s = {write, user};
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, quiet_error, quiet_warning);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    int result = -1;
    if (info) {
        png_set_write_fn(png, &s, write_bytes, flush_bytes);
        result = write_rows(png, info, rgba, width, height, alpha);
    }
    png_destroy_write_struct(&png, &info);
    return result;
}

/* ---- Raw frames ------------------------------------------------------------------------------------------ */

int play_write_rgba(const unsigned char *rgba, int width, int height, play_write_fn write, void *user) {
    return write(user, rgba, 4 * (size_t)width * (size_t)height) == 0 ? 0 : -1;
}

int play_write_y4m_header(int width, int height, unsigned rate_num, unsigned rate_den, play_write_fn write,
                          void *user) {
    char text[128];
    const int size =
        snprintf(text, sizeof text, "YUV4MPEG2 W%d H%d F%u:%u Ip A1:1 C444\n", width, height, rate_num, rate_den);
    return write(user, text, (size_t)size) == 0 ? 0 : -1;
}

/* ITU-R BT.601, in 1/65536. */
static void convert(const unsigned char *p, unsigned char *y, unsigned char *u, unsigned char *v) {
    const int r = p[0], g = p[1], b = p[2], half = 1 << 15;
    *y = (unsigned char)(16 + ((16829 * r + 33039 * g + 6416 * b + half) >> 16));
    *u = (unsigned char)(((128 << 16) - 9714 * r - 19071 * g + 28784 * b + half) >> 16);
    *v = (unsigned char)(((128 << 16) + 28784 * r - 24103 * g - 4681 * b + half) >> 16);
}

int play_write_y4m_frame(const unsigned char *rgba, int width, int height, play_write_fn write, void *user) {
    static const char begin[] = "FRAME\n";
    const size_t count = (size_t)width * (size_t)height;
    unsigned char *planes = malloc(3 * count);
    if (!planes)
        return -1;
    for (size_t i = 0; i < count; i++)
        convert(rgba + 4 * i, planes + i, planes + count + i, planes + 2 * count + i);
    const int failed = write(user, begin, sizeof begin - 1) != 0 || write(user, planes, 3 * count) != 0;
    free(planes);
    return failed ? -1 : 0;
}
