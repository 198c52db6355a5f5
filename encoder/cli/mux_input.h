/* Files that nsdf-mux edits, whole in memory. */
#ifndef NSDF_MUX_INPUT_H
#define NSDF_MUX_INPUT_H

#include "nsdf/mux.h"

typedef struct mux_input {
    const char *name; /* borrowed */
    void *data;       /* owned */
    size_t size;
} mux_input;

/* 0, or -1 after printing why; mux_input_free in either case. */
int mux_input_read(mux_input *input, const char *name);
/* The file in parts, or NULL after printing what is wrong with it. */
nsdf_mux *mux_input_open(const mux_input *input);
void mux_input_free(mux_input *input);

/* How far the surface at the beginning of `next` is from that of `input` at the same moment, `held` frames behind its
 * last, as a fraction of the diagonal: the mean difference of distances near them.  HUGE_VAL when there is no surface,
 * or no memory. */
double mux_input_gap(const mux_input *input, uint32_t held, const mux_input *next);

#endif
