/* Bytes of a file that are known already: disjoint stretches in memory, in order of their offsets. */
#ifndef NSDF_CLI_EXTENTS_H
#define NSDF_CLI_EXTENTS_H

#include <stddef.h>
#include <stdint.h>

typedef struct nsdf_cli_extent {
    uint64_t offset;
    size_t size; /* at least 1 */
    uint8_t *data;
    uint64_t last_use;
} nsdf_cli_extent;

/* All zero to begin with. */
typedef struct nsdf_cli_extents {
    nsdf_cli_extent *items; /* ascending, disjoint */
    size_t count, capacity;
    uint64_t bytes, clock;
} nsdf_cli_extents;

/* The first stretch of [offset, offset + size) that is not there: 1 with its ends in *from and *to, or 0 when all is
 * there.  *room becomes how far a stretch from *from could reach without meeting one that is there. */
int nsdf_cli_extents_gap(const nsdf_cli_extents *extents, uint64_t offset, uint64_t size, uint64_t *from, uint64_t *to,
                         uint64_t *room);

/* Adds a stretch that meets none of the others; takes over `data` (from malloc).  0, or -1 without memory and `data`
 * still the caller's. */
int nsdf_cli_extents_add(nsdf_cli_extents *extents, uint64_t offset, uint8_t *data, size_t size);

/* Copies bytes that are all there. */
void nsdf_cli_extents_copy(nsdf_cli_extents *extents, uint64_t offset, void *dst, size_t size);

/* Drops the stretches that were used longest ago until at most `most` bytes or a single stretch are left. */
void nsdf_cli_extents_trim(nsdf_cli_extents *extents, uint64_t most);

void nsdf_cli_extents_free(nsdf_cli_extents *extents);

#endif
