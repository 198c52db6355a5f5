/* Four single-precision numbers at once: rows and columns of affine maps (GCC and Clang vector extension; two or four
 * of them are what every processor has).  Nothing is contracted, so that results do not depend on the processor. */
#ifndef NSDF_ROW4_H
#define NSDF_ROW4_H

#include <string.h>

typedef float nsdf_row4 __attribute__((vector_size(16)));

static inline nsdf_row4 nsdf_row4_load(const float p[4]) {
    nsdf_row4 v;
    memcpy(&v, p, sizeof v);
    return v;
}

static inline void nsdf_row4_store(float p[4], nsdf_row4 v) {
    memcpy(p, &v, sizeof v);
}

#if defined(__clang__)
#define NSDF_ROW4_SHUFFLE(a, b, i, j, k, l) __builtin_shufflevector(a, b, i, j, k, l)
#else
#define NSDF_ROW4_SHUFFLE(a, b, i, j, k, l) __builtin_shuffle(a, b, (int __attribute__((vector_size(16)))){i, j, k, l})
#endif

/* Rows to columns, and back. */
static inline void nsdf_row4_transpose(nsdf_row4 m[4]) {
    const nsdf_row4 a = NSDF_ROW4_SHUFFLE(m[0], m[1], 0, 4, 1, 5), b = NSDF_ROW4_SHUFFLE(m[0], m[1], 2, 6, 3, 7);
    const nsdf_row4 c = NSDF_ROW4_SHUFFLE(m[2], m[3], 0, 4, 1, 5), d = NSDF_ROW4_SHUFFLE(m[2], m[3], 2, 6, 3, 7);
    m[0] = NSDF_ROW4_SHUFFLE(a, c, 0, 1, 4, 5);
    m[1] = NSDF_ROW4_SHUFFLE(a, c, 2, 3, 6, 7);
    m[2] = NSDF_ROW4_SHUFFLE(b, d, 0, 1, 4, 5);
    m[3] = NSDF_ROW4_SHUFFLE(b, d, 2, 3, 6, 7);
}

/* The sum of each row. */
static inline nsdf_row4 nsdf_row4_sums(nsdf_row4 a, nsdf_row4 b, nsdf_row4 c, nsdf_row4 d) {
    nsdf_row4 m[4] = {a, b, c, d};
    nsdf_row4_transpose(m);
    return m[0] + m[1] + m[2] + m[3];
}

/* Of the first three numbers; the fourth is 0 if it is in both. */
static inline nsdf_row4 nsdf_row4_cross(nsdf_row4 a, nsdf_row4 b) {
    const nsdf_row4 c = a * NSDF_ROW4_SHUFFLE(b, b, 1, 2, 0, 3) - NSDF_ROW4_SHUFFLE(a, a, 1, 2, 0, 3) * b;
    return NSDF_ROW4_SHUFFLE(c, c, 1, 2, 0, 3);
}

#endif
