/* Cursor over little-endian bytes for the readers: every take is checked against the end, the first failure sticks,
 * and later takes give 0, so that a run of fields needs one check at its end.  Does not depend on the endianness of
 * the machine. */
#ifndef NSDF_BYTES_H
#define NSDF_BYTES_H

#include <string.h>

#include "container_read.h"

typedef struct nsdf_cursor {
    const uint8_t *data;
    size_t size, at;
    nsdf_parse status;
    nsdf_fault fault;
} nsdf_cursor;

static inline nsdf_cursor nsdf_cursor_start(const uint8_t *data, size_t size, size_t at) {
    nsdf_cursor c = {data, size, at, NSDF_PARSE_OK, {0, ""}};
    return c;
}

/* Records a failure unless there was one before. */
static inline void nsdf_cursor_fail(nsdf_cursor *c, nsdf_parse status, uint64_t offset, const char *what) {
    if (c->status != NSDF_PARSE_OK)
        return;
    c->status = status;
    c->fault.offset = offset;
    c->fault.what = what;
}

/* The field at `offset` is corrupt unless `valid`. */
static inline void nsdf_cursor_expect(nsdf_cursor *c, int valid, uint64_t offset, const char *what) {
    if (!valid)
        nsdf_cursor_fail(c, NSDF_PARSE_CORRUPT, offset, what);
}

/* Steps over `size` bytes and returns where they are, or NULL. */
static inline const uint8_t *nsdf_take(nsdf_cursor *c, size_t size) {
    if (c->status == NSDF_PARSE_OK && size > c->size - c->at)
        nsdf_cursor_fail(c, NSDF_PARSE_TRUNCATED, c->at, "the data end inside a field");
    if (c->status != NSDF_PARSE_OK)
        return NULL;
    const uint8_t *p = c->data + c->at;
    c->at += size;
    return p;
}

static inline uint16_t nsdf_load_u16(const uint8_t *p) {
    return (uint16_t)((uint32_t)p[0] | (uint32_t)p[1] << 8);
}

static inline uint32_t nsdf_load_u32(const uint8_t *p) {
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static inline float nsdf_load_f32(const uint8_t *p) {
    uint32_t bits = nsdf_load_u32(p);
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static inline uint8_t nsdf_take_u8(nsdf_cursor *c) {
    const uint8_t *p = nsdf_take(c, 1);
    return p ? p[0] : 0;
}

static inline uint16_t nsdf_take_u16(nsdf_cursor *c) {
    const uint8_t *p = nsdf_take(c, 2);
    return p ? nsdf_load_u16(p) : 0;
}

static inline uint32_t nsdf_take_u32(nsdf_cursor *c) {
    const uint8_t *p = nsdf_take(c, 4);
    return p ? nsdf_load_u32(p) : 0;
}

static inline uint64_t nsdf_take_u64(nsdf_cursor *c) {
    const uint8_t *p = nsdf_take(c, 8);
    return p ? (uint64_t)nsdf_load_u32(p) | (uint64_t)nsdf_load_u32(p + 4) << 32 : 0;
}

static inline int32_t nsdf_take_i32(nsdf_cursor *c) {
    uint32_t bits = nsdf_take_u32(c);
    int32_t v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static inline float nsdf_take_f32(nsdf_cursor *c) {
    const uint8_t *p = nsdf_take(c, 4);
    return p ? nsdf_load_f32(p) : 0.0f;
}

static inline double nsdf_take_f64(nsdf_cursor *c) {
    uint64_t bits = nsdf_take_u64(c);
    double v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

/* Hands the outcome to the caller; `fault` may be NULL. */
static inline nsdf_parse nsdf_cursor_finish(const nsdf_cursor *c, nsdf_fault *fault) {
    if (c->status != NSDF_PARSE_OK && fault)
        *fault = c->fault;
    return c->status;
}

#endif
