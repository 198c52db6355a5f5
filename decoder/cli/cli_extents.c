#include "cli_extents.h"

#include <stdlib.h>
#include <string.h>

static uint64_t end_of(const nsdf_cli_extent *extent) {
    return extent->offset + extent->size;
}

/* The first extent that ends behind `offset`, or the count. */
static size_t find(const nsdf_cli_extents *extents, uint64_t offset) {
    size_t low = 0, high = extents->count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (end_of(&extents->items[middle]) <= offset)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

int nsdf_cli_extents_gap(const nsdf_cli_extents *extents, uint64_t offset, uint64_t size, uint64_t *from, uint64_t *to,
                         uint64_t *room) {
    const uint64_t end = offset + size;
    size_t i = find(extents, offset);
    uint64_t at = offset;
    while (at < end && i < extents->count && extents->items[i].offset <= at)
        at = end_of(&extents->items[i++]);
    if (at >= end)
        return 0;
    *from = at;
    *room = i < extents->count ? extents->items[i].offset : UINT64_MAX;
    *to = end < *room ? end : *room;
    return 1;
}

static int make_room(nsdf_cli_extents *extents) {
    if (extents->count < extents->capacity)
        return 0;
    const size_t capacity = 2 * extents->capacity + 16;
    nsdf_cli_extent *grown = realloc(extents->items, capacity * sizeof *grown);
    if (!grown)
        return -1;
    extents->items = grown;
    extents->capacity = capacity;
    return 0;
}

int nsdf_cli_extents_add(nsdf_cli_extents *extents, uint64_t offset, uint8_t *data, size_t size) {
    if (make_room(extents) != 0)
        return -1;
    const size_t at = find(extents, offset);
    memmove(extents->items + at + 1, extents->items + at, (extents->count - at) * sizeof *extents->items);
    extents->items[at] = (nsdf_cli_extent){offset, size, data, ++extents->clock};
    extents->count++;
    extents->bytes += size;
    return 0;
}

void nsdf_cli_extents_copy(nsdf_cli_extents *extents, uint64_t offset, void *dst, size_t size) {
    uint8_t *out = dst;
    for (size_t i = find(extents, offset); size > 0; i++) {
        nsdf_cli_extent *extent = &extents->items[i];
        const size_t skipped = (size_t)(offset - extent->offset), left = extent->size - skipped;
        const size_t part = size < left ? size : left;
        memcpy(out, extent->data + skipped, part);
        extent->last_use = ++extents->clock;
        out += part;
        offset += part;
        size -= part;
    }
}

static size_t oldest(const nsdf_cli_extents *extents) {
    size_t found = 0;
    for (size_t i = 1; i < extents->count; i++)
        if (extents->items[i].last_use < extents->items[found].last_use)
            found = i;
    return found;
}

void nsdf_cli_extents_trim(nsdf_cli_extents *extents, uint64_t most) {
    while (extents->bytes > most && extents->count > 1) {
        const size_t at = oldest(extents);
        extents->bytes -= extents->items[at].size;
        free(extents->items[at].data);
        extents->count--;
        memmove(extents->items + at, extents->items + at + 1, (extents->count - at) * sizeof *extents->items);
    }
}

void nsdf_cli_extents_free(nsdf_cli_extents *extents) {
    for (size_t i = 0; i < extents->count; i++)
        free(extents->items[i].data);
    free(extents->items);
    memset(extents, 0, sizeof *extents);
}
