#include "png_write.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

static void put_u32(uint8_t *out, uint32_t v) {
    for (int i = 0; i < 4; i++)
        out[i] = (uint8_t)(v >> (24 - 8 * i));
}

/* A chunk is its length, type, data, and a CRC of type and data. */
static void write_chunk(FILE *file, const char *type, const uint8_t *data, size_t size) {
    uint8_t head[8], tail[4];
    put_u32(head, (uint32_t)size);
    memcpy(head + 4, type, 4);
    uLong crc = crc32(crc32(0, NULL, 0), head + 4, 4);
    if (size)
        crc = crc32(crc, data, (uInt)size);
    put_u32(tail, (uint32_t)crc);
    fwrite(head, 1, sizeof head, file);
    fwrite(data, 1, size, file);
    fwrite(tail, 1, sizeof tail, file);
}

/* Every row behind a filter byte: 1, differences to the pixel on the left. */
static uint8_t *filter_rows(const uint8_t *rgb, uint32_t width, uint32_t height) {
    size_t row = (size_t)width * 3;
    uint8_t *out = malloc((row + 1) * height);
    for (uint32_t y = 0; out && y < height; y++) {
        const uint8_t *from = rgb + y * row;
        uint8_t *to = out + y * (row + 1);
        *to++ = 1;
        for (size_t x = 0; x < row; x++)
            to[x] = (uint8_t)(from[x] - (x < 3 ? 0 : from[x - 3]));
    }
    return out;
}

static int write_png(FILE *file, const uint8_t *rgb, uint32_t width, uint32_t height) {
    static const uint8_t signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    size_t raw_size = ((size_t)width * 3 + 1) * height;
    uLongf size = compressBound((uLong)raw_size);
    uint8_t *raw = filter_rows(rgb, width, height), *packed = malloc(size);
    int status = -1;
    errno = ENOMEM;
    if (raw && packed && compress2(packed, &size, raw, (uLong)raw_size, 9) == Z_OK) {
        uint8_t header[13] = {[8] = 8, [9] = 2}; /* eight bits a channel, RGB */
        put_u32(header, width);
        put_u32(header + 4, height);
        fwrite(signature, 1, sizeof signature, file);
        write_chunk(file, "IHDR", header, sizeof header);
        write_chunk(file, "IDAT", packed, size);
        write_chunk(file, "IEND", header, 0);
        status = ferror(file) ? -1 : 0;
    }
    free(raw);
    free(packed);
    return status;
}

int nsdf_png_write(const char *path, const uint8_t *rgb, uint32_t width, uint32_t height) {
    char *temporary = malloc(strlen(path) + 5);
    if (!temporary)
        return -1;
    strcpy(temporary, path);
    strcat(temporary, ".tmp");
    int status = -1;
    FILE *file = fopen(temporary, "wb");
    if (file) {
        status = write_png(file, rgb, width, height);
        if (fclose(file))
            status = -1;
        if (status == 0)
            status = rename(temporary, path);
        if (status) {
            int reason = errno;
            remove(temporary);
            errno = reason;
        }
    }
    free(temporary);
    return status;
}
