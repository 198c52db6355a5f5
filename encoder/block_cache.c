#include "block_cache.h"

#include "block_pose.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of a ball's radius: a wider margin is checked in vain more often, a narrower one holds fewer steps. */
static const float margin = 0.12f;
/* For the rounding of what is compared with it. */
static const float margin_kept = 0.99f;

/* Bytes of a sample: itself, and about seven candidates with their room. */
enum { SAMPLE_BYTES = 16 + 2 * 8 };

static size_t stride_of(const nsdf_block_cache *c, uint32_t frame) {
    const size_t count = c->samples[frame].count;
    return count > c->wanted ? count / c->wanted : 1;
}

static double bytes_of(const nsdf_block_cache *c, const nsdf_block_frame *frame) {
    double bytes = 0.0;
    for (uint32_t f = 0; f < c->frame_count; f++) {
        const double batches = (double)stride_of(c, f), blocks = (double)c->blocks;
        bytes += (double)SAMPLE_BYTES * (double)c->samples[f].count + blocks * (18 * sizeof(float) + sizeof(uint32_t)) +
                 batches * (2.0 * blocks + (double)nsdf_block_batch_spans(frame)) * sizeof(uint32_t);
    }
    return bytes;
}

static int create_references(nsdf_block_cache *c) {
    int ok = 1;
    c->references = calloc(c->frame_count, sizeof *c->references);
    for (uint32_t f = 0; c->references && f < c->frame_count; f++) {
        nsdf_block_reference *r = &c->references[f];
        r->map = malloc(sizeof *r->map * c->blocks);
        r->reach = malloc(sizeof *r->reach * c->blocks);
        r->stamp = calloc(c->blocks, sizeof *r->stamp);
        ok &= r->map && r->reach && r->stamp;
    }
    return c->references && ok ? 0 : -1;
}

int nsdf_block_cache_create(nsdf_block_cache *c, const nsdf_sample_set *samples, uint32_t frame_count, uint32_t wanted,
                            uint32_t blocks, const nsdf_block_frame *frame, size_t most_bytes) {
    *c = (nsdf_block_cache){samples, frame_count, blocks, wanted, NULL, NULL, NULL};
    if (bytes_of(c, frame) > (double)most_bytes)
        return 0;
    size_t count = 0;
    c->first = malloc(((size_t)frame_count + 1) * sizeof *c->first);
    for (uint32_t f = 0; c->first && f < frame_count; f++) {
        c->first[f] = (uint32_t)count;
        count += stride_of(c, f);
    }
    c->batches = calloc(count, sizeof *c->batches);
    if (c->first && c->batches && create_references(c) == 0) {
        c->first[frame_count] = (uint32_t)count;
        return 0;
    }
    nsdf_block_cache_free(c);
    return -1;
}

void nsdf_block_cache_free(nsdf_block_cache *c) {
    const uint32_t count = c->batches && c->references ? c->first[c->frame_count] : 0;
    for (uint32_t i = 0; i < count; i++)
        nsdf_block_batch_free(&c->batches[i]);
    for (uint32_t f = 0; c->references && f < c->frame_count; f++) {
        free(c->references[f].map);
        free(c->references[f].reach);
        free(c->references[f].stamp);
    }
    free(c->references);
    free(c->batches);
    free(c->first);
    memset(c, 0, sizeof *c);
}

uint32_t nsdf_block_cache_batches(const nsdf_block_cache *c, uint32_t frame) {
    return (uint32_t)stride_of(c, frame);
}

/* ---- References ------------------------------------------------------------------------------------------ */

/* Moves it to where the blocks are that have left it. */
static void renew(nsdf_block_reference *r, const nsdf_block_frame *at, const float *radii, uint32_t blocks) {
    for (uint32_t k = 0; k < blocks; k++) {
        if (!at->alive[k] ||
            (r->stamp[k] > 0 && nsdf_block_moved(r->map[k], at->pose[k], radii[k]) < margin_kept * margin))
            continue;
        memcpy(r->map[k], at->map[k], sizeof r->map[k]);
        memcpy(r->reach[k], at->reach[k], sizeof r->reach[k]);
        r->stamp[k]++;
    }
}

static int is_current(const nsdf_block_batch *b, const nsdf_block_reference *r, const nsdf_block_frame *at,
                      uint32_t blocks) {
    for (uint32_t k = 0; k < blocks; k++)
        if (at->alive[k] && b->listed[k] != r->stamp[k])
            return 0;
    return 1;
}

/* ---- Batches --------------------------------------------------------------------------------------------- */

static const nsdf_block_batch *take_kept(nsdf_block_cache *c, uint32_t frame, uint32_t number,
                                         const nsdf_block_frame *at, const float *radii,
                                         const nsdf_block_passes *passes, nsdf_block_work *work) {
    nsdf_block_batch *b = &c->batches[c->first[frame] + number];
    nsdf_block_reference *r = &c->references[frame];
    if (!b->point) {
        if (nsdf_block_batch_create(b, c->wanted, c->blocks, at) != 0)
            return NULL;
        nsdf_block_batch_fill(b, work, at, &c->samples[frame], number, stride_of(c, frame), c->wanted);
    }
    renew(r, at, radii, c->blocks);
    if (is_current(b, r, at, c->blocks))
        return b;
    if (nsdf_block_batch_list(b, work, passes, at, (const float(*)[12])r->map, (const float(*)[6])r->reach, r->stamp,
                              c->blocks, margin) != 0)
        return NULL;
    return b;
}

const nsdf_block_batch *nsdf_block_cache_take(nsdf_block_cache *c, uint32_t frame, uint32_t number, int keep,
                                              const nsdf_block_frame *at, const float *radii,
                                              const nsdf_block_passes *passes, nsdf_block_work *work,
                                              nsdf_block_batch *own) {
    if (keep && c->batches)
        return take_kept(c, frame, number, at, radii, passes, work);
    nsdf_block_batch_fill(own, work, at, &c->samples[frame], number, stride_of(c, frame), c->wanted);
    if (nsdf_block_batch_list(own, work, passes, at, (const float(*)[12])at->map, (const float(*)[6])at->reach, NULL,
                              c->blocks, 0.0f) != 0)
        return NULL;
    return own;
}
