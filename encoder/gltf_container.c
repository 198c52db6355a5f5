#include "gltf_container.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "bytes.h"
#include "input_error.h"

enum { HEADER = 12, CHUNK_HEADER = 8, JSON_START = HEADER + CHUNK_HEADER };

typedef struct file {
    const char *name;
    const uint8_t *bytes;
    size_t size;
    nsdf_encoder_error *error;
} file;

static nsdf_status fail_number(const file *f, unsigned long byte, const char *what, unsigned long found,
                               const char *expected, unsigned long number) {
    return nsdf_input_fail(f->error, NSDF_CORRUPT, "%s: byte %lu: the %s is %lu, expected %s%lu",
                           nsdf_show_path(f->name).text, byte, what, found, expected, number);
}

static nsdf_status fail_end(const file *f, const char *expected) {
    return nsdf_input_fail(f->error, NSDF_CORRUPT, "%s: byte %lu: the file ends, expected %s",
                           nsdf_show_path(f->name).text, (unsigned long)f->size, expected);
}

/* ---- The binary form ------------------------------------------------------------------------------------ */

static nsdf_status check_header(const file *f) {
    if (f->size < 4 || memcmp(f->bytes, "glTF", 4) != 0)
        return nsdf_input_fail(f->error, NSDF_CORRUPT, "%s: byte 0: expected 'glTF' at the beginning of a .glb file",
                               nsdf_show_path(f->name).text);
    if (f->size < HEADER)
        return fail_end(f, "a header of 12 bytes");
    if (nsdf_load_u32(f->bytes + 4) != 2)
        return fail_number(f, 4, "version", nsdf_load_u32(f->bytes + 4), "", 2);
    const uint32_t length = nsdf_load_u32(f->bytes + 8);
    if (length > f->size)
        return fail_number(f, 8, "length", length, "no more than the file has, ", (unsigned long)f->size);
    return length < HEADER ? fail_number(f, 8, "length", length, "at least ", HEADER) : NSDF_OK;
}

/* The chunk at `at`, of a file of `length` bytes; *size gets that of its contents. */
static nsdf_status check_chunk(const file *f, size_t at, size_t length, uint32_t *size) {
    const file cut = {f->name, f->bytes, length, f->error};
    if (length - at < CHUNK_HEADER)
        return fail_end(&cut, at == HEADER ? "a chunk 'JSON'" : "8 bytes of a chunk's length and type");
    *size = nsdf_load_u32(f->bytes + at);
    if (*size > length - at - CHUNK_HEADER)
        return fail_number(f, (unsigned long)at, "length of a chunk", *size, "no more than is left, ",
                           (unsigned long)(length - at - CHUNK_HEADER));
    return NSDF_OK;
}

static nsdf_status check_binary(const file *f) {
    nsdf_status status = check_header(f);
    if (status != NSDF_OK)
        return status;
    const size_t length = nsdf_load_u32(f->bytes + 8);
    size_t at = HEADER;
    do {
        uint32_t size = 0;
        status = check_chunk(f, at, length, &size);
        if (status == NSDF_OK && at == HEADER && memcmp(f->bytes + at + 4, "JSON", 4) != 0)
            return nsdf_input_fail(f->error, NSDF_CORRUPT, "%s: byte %lu: expected 'JSON', the type of the first chunk",
                                   nsdf_show_path(f->name).text, (unsigned long)at + 4);
        at += CHUNK_HEADER + (size_t)size;
    } while (status == NSDF_OK && at < length);
    return status;
}

/* ---- Text ----------------------------------------------------------------------------------------------- */

static nsdf_status check_text(const file *f) {
    size_t at = f->size >= 3 && memcmp(f->bytes, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
    while (at < f->size && f->bytes[at] != '\0' && strchr(" \t\r\n", f->bytes[at]))
        at++;
    if (at < f->size && f->bytes[at] == '{')
        return NSDF_OK;
    return nsdf_input_fail(f->error, NSDF_CORRUPT, "%s: byte %lu: expected '{', as glTF is JSON",
                           nsdf_show_path(f->name).text, (unsigned long)at);
}

static bool is_called_glb(const char *name) {
    const size_t length = strlen(name);
    return length >= 4 && strcasecmp(name + length - 4, ".glb") == 0;
}

nsdf_status nsdf_gltf_check_container(const char *name, const char *text, size_t size, bool *binary,
                                      nsdf_encoder_error *error) {
    const file f = {name, (const uint8_t *)text, size, error};
    *binary = is_called_glb(name) || (size >= 4 && memcmp(text, "glTF", 4) == 0);
    return *binary ? check_binary(&f) : check_text(&f);
}

/* ---- What a parser says --------------------------------------------------------------------------------- */

/* Where a line and a column, both from 1, are in a text. */
static size_t place_of(const char *text, size_t size, unsigned long line, unsigned long column) {
    size_t at = 0;
    for (unsigned long l = 1; l < line && at < size; at++)
        l += text[at] == '\n';
    const size_t offset = column > 0 ? (size_t)column - 1 : 0;
    return offset < size - at ? at + offset : size;
}

nsdf_status nsdf_gltf_refuse(const char *name, const char *text, size_t size, bool binary, const char *why,
                             nsdf_encoder_error *error) {
    static const char place[] = "parse error at line ";
    const nsdf_shown_path shown = nsdf_show_path(name);
    const size_t length = strcspn(why, "\r\n"), start = binary ? JSON_START : 0;
    const char *at = strstr(why, place), *colon = at ? strstr(at, ": ") : NULL;
    unsigned long line, column;
    if (!colon || sscanf(at + sizeof place - 1, "%lu, column %lu", &line, &column) != 2)
        return nsdf_input_fail(error, NSDF_CORRUPT, "%s: %.*s", shown.text, length < 100 ? (int)length : 100, why);
    const size_t byte = start + place_of(text + start, size - start, line, column);
    return nsdf_input_fail(error, NSDF_CORRUPT, "%s: byte %lu: JSON %.110s", shown.text, (unsigned long)byte,
                           colon + 2);
}
