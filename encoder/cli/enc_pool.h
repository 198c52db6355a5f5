/* Segments fitted by processes of their own: their memory goes with them, and one that dies loses its segment only. */
#ifndef NSDF_ENC_POOL_H
#define NSDF_ENC_POOL_H

#include "enc_part.h"

/* Fits all segments that have no file yet, up to `jobs` at once.  0 when all have one; -1 after printing why not. */
int enc_pool_run(const enc_parts *parts, uint32_t jobs);

#endif
