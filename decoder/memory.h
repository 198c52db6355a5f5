/* All of the decoder's memory comes through here: the caller's hook, and an account that holds the limit. */
#ifndef NSDF_MEMORY_H
#define NSDF_MEMORY_H

#include "nsdf/decoder.h"

typedef struct nsdf_memory {
    nsdf_allocator hook;
    uint64_t used, peak, limit; /* bytes */
    struct nsdf_memory *beside; /* NULL, or an account whose bytes count towards this one's limit and peak too */
} nsdf_memory;

/* hook NULL or with NULL functions = malloc and free. */
void nsdf_memory_init(nsdf_memory *memory, const nsdf_allocator *hook, uint64_t limit);
/* *out gets `size` bytes, aligned to 64, not cleared; size 0 gives NULL and NSDF_OK.  NSDF_LIMIT above the limit. */
nsdf_status nsdf_memory_take(nsdf_memory *memory, uint64_t size, void **out);
/* Frees what nsdf_memory_take gave; NULL is ignored. */
void nsdf_memory_give(nsdf_memory *memory, void *pointer);
/* Makes *array hold at least `count` elements; grows by half as much again, keeps the first `used` elements. */
nsdf_status nsdf_memory_grow(nsdf_memory *memory, void **array, uint64_t *capacity, uint64_t count, uint64_t used,
                             size_t element_size);

#endif
