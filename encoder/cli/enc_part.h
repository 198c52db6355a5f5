/* One segment of a long sequence: fitted, and kept as a file until all are there. */
#ifndef NSDF_ENC_PART_H
#define NSDF_ENC_PART_H

#include "enc_plan.h"

#include <stdio.h>

/* Where the files of segments are: beside the output in "NAME.segments", or one at a time in a file without a name. */
typedef struct enc_parts {
    const enc_plan *plan;
    char *folder; /* owned, or NULL and then: */
    FILE *store;
} enc_parts;

/* Whether enc_parts_open can make its folder, as far as that can be told.  0, or -1 after printing why not. */
int enc_parts_check(const char *output);

/* Makes the folder if it is not there.  0, or -1 after printing why; enc_parts_free in either case. */
int enc_parts_open(enc_parts *parts, const enc_plan *plan, const char *output);
/* The same for one segment at a time, that of the last enc_part_write, also of another process; whatever becomes of
 * this one, nothing is left behind. */
int enc_parts_open_temporary(enc_parts *parts, const enc_plan *plan);
void enc_parts_free(enc_parts *parts);

/* What a segment gave. */
typedef struct enc_part {
    unsigned char *file; /* owned, with malloc */
    size_t size;
    nsdf_encoder_stats stats;
} enc_part;

void enc_part_free(enc_part *part);

/* Called while a segment is fitted with what is done of it, 0 to 1; answers nonzero to stop. */
typedef int (*enc_part_progress)(void *user, double done);

/* Fits a segment.  0, or -1 after printing why, or silently when progress stopped it. */
int enc_part_fit(const enc_plan *plan, uint32_t segment, enc_part_progress progress, void *user, enc_part *part);

/* Reads the file of a segment that an earlier run or another process left, whole and of the same input and options.
 * 0, or -1 when there is none. */
int enc_part_read(const enc_parts *parts, uint32_t segment, enc_part *part);

/* Writes it; it has its name when it is whole.  0, or -1 after printing why. */
int enc_part_write(const enc_parts *parts, uint32_t segment, const enc_part *part);

/* Removes the files of all segments, and the folder if nothing else is in it; not for temporary ones. */
void enc_parts_remove(const enc_parts *parts);

#endif
