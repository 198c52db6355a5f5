/* One segment of time, loaded: its parts' parameters and their networks at one time. */
#ifndef NSDF_SEGMENT_H
#define NSDF_SEGMENT_H

#include "memory.h"
#include "network.h"
#include "network_read.h"
#include "stream.h"

typedef struct nsdf_segment_part {
    nsdf_network_desc desc;
    nsdf_network network;
    float *values;  /* dequantised parameters */
    float *storage; /* the network's */
} nsdf_segment_part;

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

/* Brings the networks to time u in [0, 1] over the segment. */
void nsdf_segment_compose(nsdf_segment *segment, double u);
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

/* The loaded segment, from the cache if it is there.  Valid until the next call that changes the cache. */
nsdf_status nsdf_cache_get(nsdf_segment_cache *cache, const nsdf_stream *stream, nsdf_memory *memory, uint32_t index,
                           nsdf_segment **segment, nsdf_error *error);
/* Frees all loaded segments but `keep` (NULL = all). */
void nsdf_cache_clear(nsdf_segment_cache *cache, nsdf_memory *memory, const nsdf_segment *keep);

#endif
