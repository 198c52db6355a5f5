/* One segment of time, loaded: its parts' parameters and their networks at one time. */
#ifndef NSDF_SEGMENT_H
#define NSDF_SEGMENT_H

#include "blocks.h"
#include "memory.h"
#include "network.h"
#include "network_read.h"
#include "stream.h"

/* A network, or blocks. */
typedef struct nsdf_segment_part {
    uint32_t kind; /* NSDF_PART_... */
    union {
        nsdf_network_desc network;
        nsdf_blocks_desc blocks;
    } desc;
    union {
        nsdf_network network;
        nsdf_blocks blocks;
    } at;          /* one time */
    float *values; /* dequantised parameters */
    void *storage; /* of `at` */
} nsdf_segment_part;

/* The tensors of a part. */
const nsdf_tensor_list *nsdf_segment_tensors(const nsdf_segment_part *part);

typedef struct nsdf_segment {
    uint32_t part_count;
    nsdf_segment_part *parts;
    uint64_t parameter_count;
    double composed; /* u the networks are at; negative = none yet */
} nsdf_segment;

/* Reads segment `index`, checks its CRC and the hash of its parameters.  On failure nothing is kept. */
nsdf_status nsdf_segment_load(const nsdf_stream *stream, uint32_t index, nsdf_memory *memory, nsdf_segment *segment,
                              nsdf_error *error);
void nsdf_segment_free(nsdf_memory *memory, nsdf_segment *segment);

/* Brings networks and blocks to time u in [0, 1] over the segment; `tasks` as for nsdf_blocks_compose. */
void nsdf_segment_compose(nsdf_segment *segment, double u, nsdf_tasks *tasks);
/* Floats of scratch memory that a worker needs for a tile. */
uint64_t nsdf_segment_scratch(const nsdf_segment *segment);

/* ---- The few segments that stay loaded ------------------------------------------------------------------ */

enum { NSDF_CACHE_SLOTS = 4 };

typedef struct nsdf_segment_cache {
    struct {
        nsdf_segment segment;
        uint32_t index;
        uint64_t last_use; /* 0 = the slot is empty */
    } slots[NSDF_CACHE_SLOTS];
    uint64_t clock;
} nsdf_segment_cache;

/* The loaded segment, from the cache if it is there.  Valid until the cache is cleared or NSDF_CACHE_SLOTS - 1 other
 * segments were asked for. */
nsdf_status nsdf_cache_get(nsdf_segment_cache *cache, const nsdf_stream *stream, nsdf_memory *memory, uint32_t index,
                           nsdf_segment **segment, nsdf_error *error);
/* Frees all loaded segments but those two (NULL = all). */
void nsdf_cache_clear(nsdf_segment_cache *cache, nsdf_memory *memory, const nsdf_segment *const keep[2]);

#endif
