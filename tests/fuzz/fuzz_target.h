/* What the fuzz targets share.  Each of them is a program of its own: with libFuzzer, or with fuzz_replay.c, which
 * feeds it files.  They are linked with zero_checksum.c, so that what is behind checksums and hashes is reached too. */
#ifndef NSDF_FUZZ_TARGET_H
#define NSDF_FUZZ_TARGET_H

#include <stddef.h>
#include <stdint.h>

#include "nsdf/decoder.h"

/* libFuzzer's entry: returns 0; what is wrong aborts. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Limits that keep one input within some 100 ms: a few bytes can describe a large network. */
static inline void fuzz_options_init(nsdf_decoder_options *options) {
    nsdf_decoder_options_init(options);
    options->threads = 1;
    options->max_memory = (uint64_t)4 << 20;
    options->max_resolution = 32;
}

/* The last bytes of an input choose options; what is before them is the file. */
enum { FUZZ_CHOICES = 2 };

/* Takes them off; 0 when there are none. */
static inline void fuzz_choices(const uint8_t *data, size_t *size, uint8_t choice[FUZZ_CHOICES]) {
    for (int i = 0; i < FUZZ_CHOICES; i++)
        choice[i] = *size > 0 ? data[--*size] : 0;
}

/* For calls that may end in any way, as long as they end. */
static inline void fuzz_any(nsdf_status status) {
    (void)status;
}

#endif
