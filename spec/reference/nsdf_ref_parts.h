#ifndef NSDF_REF_PARTS_H
#define NSDF_REF_PARTS_H

/* What the files of the reference decoder share. The numbers in comments are sections of spec/nsdf-bitstream.md. */

#include "nsdf_ref.h"

#include <stdbool.h>

/* A range of bytes and a place in it. */
typedef struct ref_reader {
    struct ref_context *ctx; /* the reading of one file; a fault does not return */
    const uint8_t *data;
    uint64_t size, at;
} ref_reader;

/* Ends the reading as corrupt unless what the text demands is so. */
void ref_demand(const ref_reader *r, bool is_so, const char *message);

/* Zeroed memory that lives as long as the file. */
void *ref_allocate(struct ref_context *ctx, uint64_t count, size_t size);

/* Bits of |a| without leading zeros. */
static inline uint32_t ref_bitlength(int64_t a) {
    uint32_t length = 0;
    for (int64_t rest = a < 0 ? -a : a; rest > 0; rest >>= 1)
        length++;
    return length;
}

/* Section 10.1: whether an array has residuals in the stream. */
static inline bool ref_is_stored(const ref_array *a) {
    return a->uniform && a->bits > 0;
}

/* Section 10.5: the residuals of a part's arrays. */
void ref_decode_range(ref_reader *coded, const ref_part *part);

/* u8, u16 and u32, by their number of bytes. */
uint32_t ref_take_uint(ref_reader *r, uint32_t bytes);
float ref_take_f32(ref_reader *r);

/* Section 10.1: the next tensor, whose arrays are appended to those of the part. */
ref_tensor ref_read_tensor(ref_reader *r, ref_part *part, uint32_t rows, uint32_t cols);

/* Section 11.1: an element of a tensor at u. */
double ref_element(const ref_tensor *t, uint32_t row, uint32_t col, double u);

/* Section 10.6: the description, and what is demanded of the parameters behind it. */
void ref_read_blocks(ref_reader *r, ref_part *part);
void ref_check_blocks(const ref_reader *r, const ref_part *part);

/* Section 11.2: the value at a normalised point, u in [0, 1]. */
double ref_evaluate_blocks(const ref_part *part, const double point[3], double u);

#endif
