/* Where to cut: as few segments as the longest allowed length gives, near to equal parts, at the best places there. */
#include "survey.h"

#include <math.h>
#include <stdlib.h>

/* How far from equal parts a cut may lie, as a part of a segment. */
static const double leeway = 0.25;
/* A change of topology is worth so many octaves of motion; the far end of the leeway costs so many. */
static const double topology_worth = 4.0, distance_cost = 1.0;
static const double most_octaves = 3.0;

/* How much the surface moves from frame i to the next, as the root of summed squares of what its moments change. */
static double motion(const nsdf_seen_frame *frames, uint32_t i) {
    double sum = 0.0;
    for (int k = 0; k < NSDF_MOMENTS; k++) {
        const double d = frames[i + 1].moments[k] - frames[i].moments[k];
        sum += d * d;
    }
    return sqrt(sum) / (frames[i + 1].number - frames[i].number);
}

/* How far one step's motion is from the mean, in octaves. */
static double octaves_off(const nsdf_seen_frame *frames, uint32_t i, double mean) {
    const double moves = motion(frames, i);
    return moves > 0.0 ? fmin(fabs(log2(moves / mean)), most_octaves) : most_octaves;
}

/* Costs of a cut at frame i: how unusual the motion of the steps about it is, less what a change of topology there is
 * worth: the model of either side then has one topology more rarely.  Two fits differ a little, which is seen where
 * nothing else moves, and they are least exact where all moves fast. */
static double cost_at(const nsdf_seen_frame *frames, uint32_t count, uint32_t i, double mean) {
    const uint32_t first = i > 2 ? i - 2 : 0, end = i + 2 < count ? i + 2 : count - 1;
    double sum = 0.0;
    for (uint32_t k = first; k < end && mean > 0.0; k++)
        sum += octaves_off(frames, k, mean);
    const int changes = frames[i - 1].euler != frames[i].euler;
    return sum / (end - first) - (changes ? topology_worth : 0.0);
}

static double mean_motion(const nsdf_seen_frame *frames, uint32_t count) {
    double sum = 0.0;
    for (uint32_t i = 0; i + 1 < count; i++)
        sum += motion(frames, i);
    return sum / (count - 1);
}

/* Meshes of a capture, remeshed each frame, change their numbers all the time: that tells nothing. */
static int topology_tells(const nsdf_seen_frame *frames, uint32_t count) {
    uint32_t changes = 0;
    for (uint32_t i = 0; i + 1 < count; i++)
        changes += frames[i].euler != frames[i + 1].euler;
    return changes <= count / 8;
}

/* The best frame near `wanted`, of those in [low, high]. */
static uint32_t best_cut(const nsdf_seen_frame *frames, uint32_t count, double wanted, uint32_t low, uint32_t high,
                         double room, double mean, int topology) {
    uint32_t best = low;
    double least = INFINITY;
    for (uint32_t i = low; i <= high; i++) {
        const double off = room > 0.0 ? (i - wanted) / room : 0.0;
        double cost = cost_at(frames, count, i, mean) + distance_cost * off * off;
        if (!topology && frames[i - 1].euler != frames[i].euler)
            cost += topology_worth;
        if (cost < least) {
            least = cost;
            best = i;
        }
    }
    return best;
}

uint32_t nsdf_plan_cuts(const nsdf_seen_frame *frames, uint32_t count, uint32_t most_frames, uint32_t **cuts) {
    const uint32_t steps = count - 1, most = most_frames - 1; /* steps between frames */
    uint32_t segments = steps > 0 ? (steps + most - 1) / most : 1;
    uint32_t *at = malloc(segments * sizeof *at);
    if (!at)
        return 0;
    const double mean = segments > 1 ? mean_motion(frames, count) : 0.0;
    const int topology = segments > 1 && topology_tells(frames, count);
    for (uint32_t k = 0; k + 1 < segments; k++) {
        /* What is left is shared out anew, so that a cut moved to one side does not make the others longer. */
        const uint32_t from = k > 0 ? at[k - 1] : 0, left = segments - k;
        const double length = (double)(steps - from) / left, wanted = from + length, room = floor(leeway * length);
        const double lowest = fmax(wanted - room, (double)steps - (double)(left - 1) * most);
        const double highest = fmin(wanted + room, (double)from + most);
        at[k] = best_cut(frames, count, wanted, (uint32_t)ceil(fmax(lowest, from + 1.0)),
                         (uint32_t)floor(fmin(highest, steps - (left - 1.0))), room, mean, topology);
    }
    at[segments - 1] = steps;
    *cuts = at;
    return segments;
}
