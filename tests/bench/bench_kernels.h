/* Kernels beside what one core can do at most: a list of cases, each with what bounds it. */
#ifndef BENCH_KERNELS_H
#define BENCH_KERNELS_H

#include "bench_fma.h"
#include "bench_util.h"

enum { KERNELS_MOST_CASES = 128 };

/* What a case's work is measured in, and what of it the machine does a second at most. */
typedef enum kernels_bound {
    KERNELS_FLOP, /* operations of the register loop of the same instruction set */
    KERNELS_BYTES /* a peak itself: bytes read */
} kernels_bound;

typedef struct kernels_entry {
    const char *section;
    bench_isa isa;
    kernels_bound bound;
    double work;  /* operations or bytes of a call */
    double items; /* samples, points or hits of a call; 0 where they say nothing */
    const char *item;
    int compared; /* other case whose seconds a call this one's are divided by; -1 = none */
} kernels_entry;

typedef struct kernels_list {
    bench_case cases[KERNELS_MOST_CASES];
    kernels_entry entries[KERNELS_MOST_CASES];
    size_t count;
    int quick; /* fewer widths */
} kernels_list;

/* Adds a case of one thread and returns its number. */
int kernels_add(kernels_list *list, const kernels_entry *entry, const char *name, void (*run)(void *data), void *data);

/* Each adds its cases; what they work on stays until the program ends. */
void kernels_add_memory(kernels_list *list); /* reading from each level of memory */
void kernels_add_fit(kernels_list *list);    /* the encoder's networks */
void kernels_add_blocks(kernels_list *list); /* the encoder's blocks */
void kernels_add_decode(kernels_list *list); /* the decoder's networks and blocks */

#endif
