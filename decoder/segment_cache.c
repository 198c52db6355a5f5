/* The few segments that stay loaded: those used last. */
#include "segment.h"

static void free_slot(nsdf_segment_cache *cache, nsdf_memory *memory, uint32_t slot) {
    if (cache->slots[slot].last_use != 0)
        nsdf_segment_free(memory, &cache->slots[slot].segment);
    cache->slots[slot].last_use = 0;
}

static uint32_t oldest_slot(const nsdf_segment_cache *cache) {
    uint32_t oldest = 0;
    for (uint32_t i = 1; i < NSDF_CACHE_SLOTS; i++)
        if (cache->slots[i].last_use < cache->slots[oldest].last_use)
            oldest = i;
    return oldest;
}

static int find_slot(const nsdf_segment_cache *cache, uint32_t index, uint32_t *slot) {
    for (*slot = 0; *slot < NSDF_CACHE_SLOTS; ++*slot)
        if (cache->slots[*slot].last_use != 0 && cache->slots[*slot].index == index)
            return 1;
    return 0;
}

nsdf_status nsdf_cache_get(nsdf_segment_cache *cache, const nsdf_stream *stream, nsdf_memory *memory, uint32_t index,
                           nsdf_segment **segment, nsdf_error *error) {
    uint32_t slot;
    if (!find_slot(cache, index, &slot)) {
        slot = oldest_slot(cache);
        free_slot(cache, memory, slot);
        nsdf_status status = nsdf_segment_load(stream, index, memory, &cache->slots[slot].segment, error);
        if (status != NSDF_OK)
            return status;
        cache->slots[slot].index = index;
    }
    cache->slots[slot].last_use = ++cache->clock;
    *segment = &cache->slots[slot].segment;
    return NSDF_OK;
}

void nsdf_cache_clear(nsdf_segment_cache *cache, nsdf_memory *memory, const nsdf_segment *const keep[2]) {
    for (uint32_t i = 0; i < NSDF_CACHE_SLOTS; i++)
        if (!keep || (&cache->slots[i].segment != keep[0] && &cache->slots[i].segment != keep[1]))
            free_slot(cache, memory, i);
}
