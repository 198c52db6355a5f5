/* Writing 8-bit RGB pictures as PNG (ISO/IEC 15948). */
#ifndef NSDF_PNG_WRITE_H
#define NSDF_PNG_WRITE_H

#include <stddef.h>
#include <stdint.h>

/* rgb: [height][width][3].  Writes under a temporary name, then renames.  Returns 0, or -1 with errno set. */
int nsdf_png_write(const char *path, const uint8_t *rgb, uint32_t width, uint32_t height);

#endif
