/* Inner parts of the mesh writers: bytes are collected in a block and handed on when it is full. */
#ifndef NSDF_MESH_OUTPUT_H
#define NSDF_MESH_OUTPUT_H

#include <string.h>

#include "nsdf/export.h"

enum {
    NSDF_OUTPUT_BLOCK = 1 << 15,
    NSDF_OUTPUT_LONGEST = 256 /* bytes that one item may add between two calls of nsdf_output_room */
};

typedef struct nsdf_output {
    nsdf_write_fn write;
    void *user;
    nsdf_status status; /* NSDF_IO after a write failed; from then on nothing is written */
    size_t used;
    unsigned char block[NSDF_OUTPUT_BLOCK];
} nsdf_output;

static inline void nsdf_output_flush(nsdf_output *out) {
    if (out->used > 0 && out->status == NSDF_OK && out->write(out->user, out->block, out->used) != 0)
        out->status = NSDF_IO;
    out->used = 0;
}

/* Where the next item goes, with room for NSDF_OUTPUT_LONGEST bytes; `used` then grows by what was put there. */
static inline unsigned char *nsdf_output_room(nsdf_output *out) {
    if (out->used > NSDF_OUTPUT_BLOCK - NSDF_OUTPUT_LONGEST)
        nsdf_output_flush(out);
    return out->block + out->used;
}

static inline unsigned char *nsdf_put_u32(unsigned char *at, uint32_t value) {
    at[0] = (unsigned char)value;
    at[1] = (unsigned char)(value >> 8);
    at[2] = (unsigned char)(value >> 16);
    at[3] = (unsigned char)(value >> 24);
    return at + 4;
}

static inline uint32_t nsdf_float_bits(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static inline unsigned char *nsdf_put_float(unsigned char *at, float value) {
    return nsdf_put_u32(at, nsdf_float_bits(value));
}

/* write_obj.c, write_ply.c, write_stl.c */
void nsdf_write_obj(const nsdf_mesh_view *view, nsdf_output *out);
void nsdf_write_ply(const nsdf_mesh_view *view, nsdf_output *out);
void nsdf_write_stl(const nsdf_mesh_view *view, nsdf_output *out);

/* decimal.c: these return the end of the text, at most 16 bytes for a float and 10 for an integer; up to
 * NSDF_DECIMAL_ROOM bytes may be overwritten. */
enum { NSDF_DECIMAL_ROOM = 24 };
unsigned char *nsdf_put_decimal(unsigned char *at, float value);
unsigned char *nsdf_put_integer(unsigned char *at, uint32_t value);

#endif
