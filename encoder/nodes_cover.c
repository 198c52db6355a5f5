/* Which nodes have surface under them, and new nodes where surface has none. */
#include "nodes.h"

#include "nearest.h"
#include "rotation.h"
#include "surface_sample.h"
#include "triangle.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* In spacings: how far the surface may be from a node on it, and from one that has been lost outside of it; and how far
 * the next node may be from surface that is not bare. */
static const float support_reach = 1.6f, lost_reach = 6.0f, bare_reach = 1.7f;
static const double like_cosine = 0.2; /* of the normals of a node and its surface, unless they are close */
/* Looked at in every frame; less than this share is left bare. */
enum { PROBES = 1200, ROUNDS = 5, GUIDES = 16, FEWEST_GUIDES = 5 };
static const double bare_share = 0.006;

typedef struct {
    nsdf_nodes *nodes;
    const nsdf_frames *frames;
    uint32_t first; /* nodes from here on are looked at */
    uint64_t seed;
    uint32_t *bare;  /* [frame]: probes without a node */
    uint8_t *failed; /* [frame] */
} job;

/* Hidden nodes lie inside of the surface.  A node outside of it has lost it, but not by much, or a normal is off: what
 * registration leaves is no reason to give up the surface there. */
static uint8_t has_support(const nsdf_nodes *n, const nsdf_nearest_index *index, uint32_t frame, uint32_t node) {
    const float reach = support_reach * n->spacing, *normal = nsdf_node_normal(n, frame, node);
    const nsdf_nearest near = nsdf_find_nearest(index, nsdf_node_at(n, frame, node), lost_reach * n->spacing);
    const double length = nsdf_vec3_length(near.normal), distance = sqrt(near.distance2);
    if (distance <= (double)reach)
        return distance <= 0.5 * (double)reach ||
               nsdf_vec3_dot(near.normal, nsdf_vec3_load(normal)) > like_cosine * length;
    return distance < (double)(lost_reach * n->spacing) && nsdf_vec3_dot(near.offset, near.normal) > 0.0;
}

static void support_frame(void *data, uint32_t frame, uint32_t worker) {
    const job *j = data;
    nsdf_nodes *n = j->nodes;
    nsdf_nearest_index index;
    (void)worker;
    j->failed[frame] = nsdf_nearest_index_build(&index, nsdf_frame_outer(&j->frames->frames[frame]), true) != 0;
    for (uint32_t i = j->first; !j->failed[frame] && i < n->count; i++)
        n->support[(size_t)frame * n->count + i] = has_support(n, &index, frame, i);
    nsdf_nearest_index_free(&index);
}

static int any_failed(const job *j) {
    int failed = 0;
    for (uint32_t f = 0; f < j->nodes->frame_count; f++)
        failed |= j->failed[f];
    return failed;
}

static int find_support(nsdf_nodes *nodes, const nsdf_frames *frames, uint32_t first, nsdf_workers *workers) {
    job j = {nodes, frames, first, 0, NULL, calloc(frames->count, 1)};
    int failed = !j.failed;
    if (!failed) {
        nsdf_workers_run(workers, frames->count, support_frame, &j);
        failed = any_failed(&j);
    }
    free(j.failed);
    return failed ? -1 : 0;
}

int nsdf_nodes_find_support(nsdf_nodes *nodes, const nsdf_frames *frames, nsdf_workers *workers) {
    return find_support(nodes, frames, 0, workers);
}

/* ---- Bare surface ---------------------------------------------------------------------------------------- */

/* Whether no node with support is near a point of the frame's surface. */
static int is_bare(const nsdf_nodes *n, uint32_t frame, const float x[3], nsdf_vec3 normal) {
    const float limit = bare_reach * bare_reach * n->spacing * n->spacing;
    for (uint32_t i = 0; i < n->count; i++) {
        const float *p = nsdf_node_at(n, frame, i);
        const float dx = p[0] - x[0], dy = p[1] - x[1], dz = p[2] - x[2];
        if (dx * dx + dy * dy + dz * dz < limit && n->support[(size_t)frame * n->count + i] &&
            nsdf_vec3_dot(nsdf_vec3_load(nsdf_node_normal(n, frame, i)), normal) > 0.0)
            return 0;
    }
    return 1;
}

/* Up to `wanted` bare points among `probes` of a frame; returns how many were found. */
static uint32_t find_bare(const nsdf_nodes *n, const nsdf_frames *frames, uint32_t frame, uint64_t seed,
                          uint32_t probes, uint32_t wanted, float (*points)[3], float (*normals)[3]) {
    const nsdf_surface *s = nsdf_frame_outer(&frames->frames[frame]);
    nsdf_random random = nsdf_random_start(seed, 0x300000000u + frame);
    nsdf_area_table table;
    uint32_t found = 0;
    if (nsdf_area_table_create(&table, s) != 0)
        return 0;
    for (uint32_t i = 0; i < probes && found < wanted; i++) {
        float x[3];
        const nsdf_triangle t = nsdf_triangle_load(s, nsdf_area_table_draw(&table, &random, x));
        const nsdf_vec3 normal = nsdf_triangle_normal(&t);
        if (!is_bare(n, frame, x, normal))
            continue;
        if (points) {
            memcpy(points[found], x, sizeof x);
            normals[found][0] = (float)normal.x;
            normals[found][1] = (float)normal.y;
            normals[found][2] = (float)normal.z;
        }
        found++;
    }
    nsdf_area_table_free(&table);
    return found;
}

static void probe_frame(void *data, uint32_t frame, uint32_t worker) {
    const job *j = data;
    (void)worker;
    j->bare[frame] = find_bare(j->nodes, j->frames, frame, j->seed, PROBES, PROBES, NULL, NULL);
}

/* ---- New nodes ------------------------------------------------------------------------------------------- */

static int grow_rows(void **data, uint32_t frames, size_t old, size_t new, size_t size) {
    char *rows = malloc(frames * new *size);
    if (!rows)
        return -1;
    for (size_t f = 0; f < frames; f++) {
        memcpy(rows + f * new *size, (char *)*data + f * old * size, old * size);
        memset(rows + (f * new + old) * size, 0, (new - old) * size);
    }
    free(*data);
    *data = rows;
    return 0;
}

static int add_room(nsdf_nodes *n, uint32_t more) {
    const size_t old = n->count, new = old + more;
    void *positions = n->positions, *normals = n->normals, *support = n->support;
    void *triangle = n->triangle, *barycentric = n->barycentric;
    int failed = grow_rows(&positions, n->frame_count, old, new, sizeof *n->positions) != 0;
    n->positions = positions;
    failed |= grow_rows(&normals, n->frame_count, old, new, sizeof *n->normals) != 0;
    n->normals = normals;
    failed |= grow_rows(&support, n->frame_count, old, new, 1) != 0;
    n->support = support;
    failed |= grow_rows(&triangle, 1, old, new, sizeof *n->triangle) != 0;
    n->triangle = triangle;
    failed |= grow_rows(&barycentric, 1, old, new, sizeof *n->barycentric) != 0;
    n->barycentric = barycentric;
    n->count = failed ? n->count : (uint32_t) new;
    return failed ? -1 : 0;
}

/* The nodes with support and like normal nearest to a point of a frame; fewer where there are fewer. */
static uint32_t find_guides(const nsdf_nodes *n, uint32_t count, uint32_t frame, const float x[3],
                            const float normal[3], uint32_t guides[GUIDES]) {
    float squares[GUIDES];
    uint32_t found = 0;
    for (uint32_t i = 0; i < count; i++) {
        const float *p = nsdf_node_at(n, frame, i), *q = nsdf_node_normal(n, frame, i);
        const float dx = p[0] - x[0], dy = p[1] - x[1], dz = p[2] - x[2], square = dx * dx + dy * dy + dz * dz;
        if (!n->support[(size_t)frame * n->count + i] || q[0] * normal[0] + q[1] * normal[1] + q[2] * normal[2] < -0.5f)
            continue;
        uint32_t at = found < GUIDES ? found++ : GUIDES;
        for (; at > 0 && squares[at - 1] > square; at--)
            if (at < GUIDES) {
                squares[at] = squares[at - 1];
                guides[at] = guides[at - 1];
            }
        if (at < GUIDES) {
            squares[at] = square;
            guides[at] = i;
        }
    }
    return found;
}

static void middle_of(const nsdf_nodes *n, uint32_t frame, const uint32_t *guides, uint32_t count, double middle[3]) {
    for (int k = 0; k < 3; k++) {
        middle[k] = 0.0;
        for (uint32_t i = 0; i < count; i++)
            middle[k] += (double)nsdf_node_at(n, frame, guides[i])[k] / count;
    }
}

/* Those of the guides that have support on a frame, or all if they are too few. */
static uint32_t choose_guides(const nsdf_nodes *n, uint32_t frame, const uint32_t *guides, uint32_t count,
                              uint32_t chosen[GUIDES]) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < count; i++)
        if (n->support[(size_t)frame * n->count + guides[i]])
            chosen[kept++] = guides[i];
    if (kept >= FEWEST_GUIDES || kept == count)
        return kept;
    memcpy(chosen, guides, count * sizeof *chosen);
    return count;
}

/* Moves node `i`, which is at its place in frame `from`, to frame `to` as its guides move. */
static void guide(nsdf_nodes *n, uint32_t i, const uint32_t *all, uint32_t all_count, uint32_t from, uint32_t to,
                  double rotation[9]) {
    double a[3], b[3], mixed[9] = {0.0};
    uint32_t guides[GUIDES];
    const uint32_t count = choose_guides(n, to, all, all_count, guides);
    middle_of(n, from, guides, count, a);
    middle_of(n, to, guides, count, b);
    for (uint32_t g = 0; g < count; g++)
        for (int row = 0; row < 3; row++)
            for (int k = 0; k < 3; k++)
                mixed[3 * row + k] += ((double)nsdf_node_at(n, to, guides[g])[row] - b[row]) *
                                      ((double)nsdf_node_at(n, from, guides[g])[k] - a[k]);
    nsdf_extract_rotation(mixed, rotation);
    const float *x = nsdf_node_at(n, from, i), *normal = nsdf_node_normal(n, from, i);
    for (int row = 0; row < 3; row++) {
        double moved = b[row], turned = 0.0;
        for (int k = 0; k < 3; k++) {
            moved += rotation[3 * row + k] * ((double)x[k] - a[k]);
            turned += rotation[3 * row + k] * (double)normal[k];
        }
        nsdf_node_at(n, to, i)[row] = (float)moved;
        nsdf_node_normal(n, to, i)[row] = (float)turned;
    }
}

/* Nodes for the bare points of a frame; returns how many, or -1 when memory ran out. */
static int add_nodes(nsdf_nodes *n, const job *j, uint32_t frame) {
    enum { MOST = 4096 };
    const uint32_t old = n->count;
    float(*points)[3] = malloc(MOST * sizeof *points), (*normals)[3] = malloc(MOST * sizeof *normals);
    float *nearest = malloc(MOST * sizeof *nearest);
    uint32_t *chosen = malloc(MOST * sizeof *chosen), wanted = 0;
    int failed = !points || !normals || !nearest || !chosen;
    if (!failed) {
        const uint32_t count = find_bare(n, j->frames, frame, j->seed + 1, 6 * n->count, MOST, points, normals);
        const uint32_t most = count < old / 2 ? count : old / 2;
        float last; /* new nodes are as close as the others */
        wanted = nsdf_nodes_choose_farthest(points, count, most, n->spacing * n->spacing, nearest, chosen, &last);
        failed = wanted > 0 && add_room(n, wanted) != 0;
    }
    for (uint32_t i = 0; !failed && i < wanted; i++) {
        uint32_t guides[GUIDES];
        memcpy(nsdf_node_at(n, frame, old + i), points[chosen[i]], sizeof *points);
        memcpy(nsdf_node_normal(n, frame, old + i), normals[chosen[i]], sizeof *normals);
        const uint32_t count = find_guides(n, old, frame, points[chosen[i]], normals[chosen[i]], guides);
        for (int step = -1; step <= 1; step += 2) {
            double rotation[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
            for (int64_t f = (int64_t)frame + step; f >= 0 && f < n->frame_count; f += step)
                guide(n, old + i, guides, count, frame, (uint32_t)f, rotation);
        }
    }
    free(points);
    free(normals);
    free(nearest);
    free(chosen);
    return failed ? -1 : (int)wanted;
}

int nsdf_nodes_cover(nsdf_nodes *nodes, const nsdf_frames *frames, uint64_t seed, nsdf_workers *workers) {
    job j = {nodes, frames, 0, seed, calloc(frames->count, sizeof(uint32_t)), NULL};
    const uint32_t first = nodes->count;
    int failed = !j.bare;
    for (int round = 0; !failed && round < ROUNDS; round++) {
        uint32_t worst = 0;
        nsdf_workers_run(workers, frames->count, probe_frame, &j);
        for (uint32_t f = 1; f < frames->count; f++)
            worst = j.bare[f] > j.bare[worst] ? f : worst;
        if (j.bare[worst] < bare_share * PROBES)
            break;
        const uint32_t old = nodes->count;
        const int added = add_nodes(nodes, &j, worst);
        failed = added < 0 || find_support(nodes, frames, old, workers) != 0;
        if (added <= 0)
            break;
    }
    free(j.bare);
    if (!failed && nodes->count > first) {
        failed = nsdf_nodes_build_graph(nodes) != 0;
        if (!failed)
            nsdf_nodes_cut_graph(nodes);
    }
    return failed ? -1 : 0;
}
