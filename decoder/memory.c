/* The account of all memory.  Each block has a header in front of its aligned start that remembers what the hook
 * gave. */
#include "memory.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

enum { ALIGNMENT = 64 };

typedef struct block_header {
    void *base;
    uint64_t total;
} block_header;

static void *default_allocate(void *user, size_t size) {
    (void)user;
    return malloc(size);
}

static void default_release(void *user, void *pointer) {
    (void)user;
    free(pointer);
}

void nsdf_memory_init(nsdf_memory *memory, const nsdf_allocator *hook, uint64_t limit) {
    memset(memory, 0, sizeof *memory);
    memory->limit = limit;
    if (hook && hook->allocate && hook->release) {
        memory->hook = *hook;
    } else {
        memory->hook.allocate = default_allocate;
        memory->hook.release = default_release;
    }
}

nsdf_status nsdf_memory_take(nsdf_memory *memory, uint64_t size, void **out) {
    if (size == 0) {
        *out = NULL;
        return NSDF_OK;
    }
    const uint64_t overhead = sizeof(block_header) + ALIGNMENT - 1;
    uint64_t held = memory->used + (memory->beside ? memory->beside->used : 0);
    uint64_t room = memory->limit > held ? memory->limit - held : 0;
    if (room < overhead || size > room - overhead || size > SIZE_MAX - overhead)
        return NSDF_LIMIT;
    uint64_t total = size + overhead;
    char *base = memory->hook.allocate(memory->hook.user, (size_t)total);
    if (!base)
        return NSDF_NO_MEMORY;
    uintptr_t aligned = ((uintptr_t)base + sizeof(block_header) + ALIGNMENT - 1) & ~(uintptr_t)(ALIGNMENT - 1);
    char *start = base + (aligned - (uintptr_t)base);
    const block_header header = {base, total};
    memcpy(start - sizeof header, &header, sizeof header);
    memory->used += total;
    held += total;
    memory->peak = held > memory->peak ? held : memory->peak;
    if (memory->beside)
        memory->beside->peak = held > memory->beside->peak ? held : memory->beside->peak;
    *out = start;
    return NSDF_OK;
}

void nsdf_memory_give(nsdf_memory *memory, void *pointer) {
    if (!pointer)
        return;
    block_header header;
    memcpy(&header, (char *)pointer - sizeof header, sizeof header);
    assert(memory->used >= header.total);
    memory->used -= header.total;
    memory->hook.release(memory->hook.user, header.base);
}

nsdf_status nsdf_memory_grow(nsdf_memory *memory, void **array, uint64_t *capacity, uint64_t count, uint64_t used,
                             size_t element_size) {
    if (count <= *capacity)
        return NSDF_OK;
    if (count > UINT64_MAX / 2 / element_size)
        return NSDF_LIMIT;
    uint64_t wanted = *capacity + *capacity / 2;
    if (wanted < count)
        wanted = count;
    void *larger;
    nsdf_status status = nsdf_memory_take(memory, wanted * element_size, &larger);
    if (status == NSDF_LIMIT && wanted > count) { /* the spare room is a wish only */
        wanted = count;
        status = nsdf_memory_take(memory, wanted * element_size, &larger);
    }
    if (status != NSDF_OK)
        return status;
    if (used > 0)
        memcpy(larger, *array, (size_t)(used * element_size));
    nsdf_memory_give(memory, *array);
    *array = larger;
    *capacity = wanted;
    return NSDF_OK;
}
