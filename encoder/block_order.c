#include "block_order.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Quadratic work is kept within bounds: so many of the blocks that are left are looked at. */
enum { MOST_LOOKED_AT = 8192 };

static const float bone_bits = 6.0f;                              /* a bone that the block before has not */
static const float centre_steps = 1024.0f, normal_steps = 100.0f; /* per unit, about as they are coded */

/* The four influences in places: bone[i] of weight[i]. */
typedef struct {
    uint32_t bone[NSDF_BONE_INFLUENCES];
    double weight[NSDF_BONE_INFLUENCES];
} influences;

static int place_of(const influences *in, uint32_t bone) {
    for (int i = 0; i < NSDF_BONE_INFLUENCES; i++)
        if (in->bone[i] == bone)
            return i;
    return -1;
}

/* About the bits that block k takes after block `before` with these places. */
static float cost(const nsdf_motion *motion, const nsdf_bones *bones, const influences *places, uint32_t before,
                  uint32_t k) {
    float bits = 0.0f;
    for (int i = 0; i < NSDF_BONE_INFLUENCES; i++)
        if (bones->weight[k][i] > 0.0 && place_of(places, bones->bone[k][i]) < 0)
            bits += bone_bits;
    for (int a = 0; a < 3; a++) {
        bits += log2f(1.0f + centre_steps * fabsf(motion->centres[k][a] - motion->centres[before][a]));
        bits += log2f(1.0f + normal_steps * motion->radius * fabsf(motion->normals[k][a] - motion->normals[before][a]));
    }
    return bits;
}

/* The influences of block k in the places of the block before, as far as it has the same bones. */
static void take_places(const nsdf_bones *bones, uint32_t k, influences *places) {
    influences next = *places;
    int taken[NSDF_BONE_INFLUENCES] = {0};
    memset(next.weight, 0, sizeof next.weight);
    for (int i = 0; i < NSDF_BONE_INFLUENCES; i++) {
        const int at = bones->weight[k][i] > 0.0 ? place_of(places, bones->bone[k][i]) : -1;
        if (at >= 0) {
            next.weight[at] = bones->weight[k][i];
            taken[at] = 1;
        }
    }
    for (int i = 0; i < NSDF_BONE_INFLUENCES; i++) {
        if (!(bones->weight[k][i] > 0.0) || place_of(places, bones->bone[k][i]) >= 0)
            continue;
        int at = 0;
        while (taken[at])
            at++;
        next.bone[at] = bones->bone[k][i];
        next.weight[at] = bones->weight[k][i];
        taken[at] = 1;
    }
    *places = next;
}

/* order[i] = the block that comes i-th; places[i] = its influences.  `left` is scratch. */
static void make_chain(const nsdf_motion *motion, const nsdf_bones *bones, uint32_t *left, uint32_t *order,
                       influences *places) {
    const uint32_t count = motion->block_count;
    influences now;
    memset(&now, 0, sizeof now);
    for (uint32_t k = 0; k < count; k++)
        left[k] = k;
    for (uint32_t n = 0, best = 0; n < count; n++) {
        float least = INFINITY;
        const uint32_t remaining = count - n, looked = remaining < MOST_LOOKED_AT ? remaining : MOST_LOOKED_AT;
        for (uint32_t i = 0; n > 0 && i < looked; i++) {
            const float bits = cost(motion, bones, &now, order[n - 1], left[i]);
            if (bits < least) {
                least = bits;
                best = i;
            }
        }
        order[n] = left[best];
        take_places(bones, order[n], &now);
        places[n] = now;
        left[best] = left[remaining - 1];
    }
}

/* rows[i] = rows[order[i]]; `scratch` has room for all. */
static void permute(void *rows, size_t size, const uint32_t *order, uint32_t count, void *scratch) {
    for (uint32_t i = 0; i < count; i++)
        memcpy((char *)scratch + i * size, (const char *)rows + order[i] * size, size);
    memcpy(rows, scratch, count * size);
}

static void apply(nsdf_motion *motion, nsdf_bones *bones, const uint32_t *order, const influences *places,
                  void *scratch) {
    const uint32_t count = motion->block_count;
    permute(motion->centres, sizeof *motion->centres, order, count, scratch);
    permute(motion->normals, sizeof *motion->normals, order, count, scratch);
    permute(motion->lives, sizeof *motion->lives, order, count, scratch);
    for (uint32_t f = 0; f < motion->frame_count; f++)
        permute(motion->poses + (size_t)f * count, sizeof *motion->poses, order, count, scratch);
    for (uint32_t i = 0; i < count; i++) {
        memcpy(bones->bone[i], places[i].bone, sizeof places[i].bone);
        memcpy(bones->weight[i], places[i].weight, sizeof places[i].weight);
    }
}

int nsdf_order_blocks(nsdf_motion *motion, nsdf_bones *bones) {
    const size_t count = motion->block_count;
    uint32_t *left = malloc(count * sizeof *left), *order = malloc(count * sizeof *order);
    influences *places = malloc(count * sizeof *places);
    nsdf_pose *scratch = malloc(count * sizeof *scratch); /* the largest row */
    const int failed = !left || !order || !places || !scratch;
    if (!failed) {
        make_chain(motion, bones, left, order, places);
        apply(motion, bones, order, places, scratch);
    }
    free(left);
    free(order);
    free(places);
    free(scratch);
    return failed ? -1 : 0;
}
