#include "nodes.h"

#include "surface_sample.h"
#include "triangle.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Candidates for each node, and the neighbours that it may have. */
enum { CANDIDATES = 4, MOST_NEIGHBOURS = 12 };
/* Neighbours are at most this many spacings apart, and their normals not as far apart as those of the two
 * sides of something thin. */
static const float neighbour_reach = 2.1f, neighbour_cosine = -0.2f;
/* Neighbours whose distance grows by this factor somewhere belong to parts that only touch at rest. */
static const float apart = 3.0f;

void nsdf_nodes_free(nsdf_nodes *n) {
    free(n->positions);
    free(n->normals);
    free(n->support);
    free(n->triangle);
    free(n->barycentric);
    free(n->start);
    free(n->next);
    memset(n, 0, sizeof *n);
}

int nsdf_frames_connected(const nsdf_frames *frames) {
    const nsdf_surface *first = &frames->frames[0].surface;
    const uint32_t count = first->triangle_count - frames->frames[0].filled;
    for (uint32_t f = 1; f < frames->count; f++) {
        const nsdf_surface *s = &frames->frames[f].surface;
        if (s->vertex_count != first->vertex_count || s->triangle_count - frames->frames[f].filled != count ||
            memcmp(s->indices, first->indices, 3 * sizeof(uint32_t) * count) != 0)
            return 0;
    }
    return 1;
}

uint32_t nsdf_rest_frame(const nsdf_frames *frames, int connected) {
    const double middle = 0.5 * (frames->count - 1);
    uint32_t best = frames->count / 2;
    double most = 0.0, score = -INFINITY;
    for (uint32_t f = 0; !connected && f < frames->count; f++)
        most = fmax(most, nsdf_surface_area(nsdf_frame_outer(&frames->frames[f])));
    for (uint32_t f = 0; !connected && f < frames->count; f++) {
        const double area = nsdf_surface_area(nsdf_frame_outer(&frames->frames[f])) / most;
        const double s = area - 0.01 * fabs(f - middle) / (middle + 1.0);
        if (s > score) {
            score = s;
            best = f;
        }
    }
    return best;
}

/* ---- Placing --------------------------------------------------------------------------------------------- */

static float square_between(const float a[3], const float b[3]) {
    const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return x * x + y * y + z * z;
}

uint32_t nsdf_nodes_choose_farthest(float (*candidates)[3], uint32_t count, uint32_t most, float least, float *nearest,
                                    uint32_t *chosen, float *last) {
    uint32_t next = 0, n = 0;
    *last = 0.0f;
    for (uint32_t i = 0; i < count; i++)
        nearest[i] = INFINITY;
    while (n < most) {
        const float *c = candidates[next];
        float farthest = -1.0f;
        chosen[n++] = next;
        *last = nearest[next];
        if (*last < least)
            break;
        for (uint32_t i = 0; i < count; i++) {
            const float d = square_between(candidates[i], c);
            nearest[i] = d < nearest[i] ? d : nearest[i];
        }
        for (uint32_t i = 0; i < count; i++)
            if (nearest[i] > farthest) {
                farthest = nearest[i];
                next = i;
            }
    }
    return n;
}

/* Weights of the second and third corner that give the point. */
static void find_barycentric(const nsdf_triangle *t, const float point[3], float out[2]) {
    const nsdf_vec3 p = nsdf_vec3_load(point), a = t->corner[0];
    const nsdf_vec3 ab = nsdf_vec3_sub(t->corner[1], a), ac = nsdf_vec3_sub(t->corner[2], a);
    const nsdf_vec3 ap = nsdf_vec3_sub(p, a);
    const double bb = nsdf_vec3_dot(ab, ab), bc = nsdf_vec3_dot(ab, ac), cc = nsdf_vec3_dot(ac, ac);
    const double pb = nsdf_vec3_dot(ap, ab), pc = nsdf_vec3_dot(ap, ac), det = bb * cc - bc * bc;
    out[0] = det > 0.0 ? (float)((cc * pb - bc * pc) / det) : 0.0f;
    out[1] = det > 0.0 ? (float)((bb * pc - bc * pb) / det) : 0.0f;
}

static void set_normal(float normal[3], const nsdf_triangle *t) {
    const nsdf_vec3 n = nsdf_triangle_normal(t);
    normal[0] = (float)n.x;
    normal[1] = (float)n.y;
    normal[2] = (float)n.z;
}

static void store_node(nsdf_nodes *n, uint32_t i, const nsdf_surface *s, uint32_t triangle, const float point[3]) {
    const nsdf_triangle t = nsdf_triangle_load(s, triangle);
    n->triangle[i] = triangle;
    find_barycentric(&t, point, n->barycentric[i]);
    memcpy(nsdf_node_at(n, n->rest, i), point, sizeof(float[3]));
    set_normal(nsdf_node_normal(n, n->rest, i), &t);
}

static int draw_nodes(nsdf_nodes *n, const nsdf_surface *s, uint64_t seed) {
    const uint32_t count = CANDIDATES * n->count;
    nsdf_random random = nsdf_random_start(seed, 7);
    nsdf_area_table table;
    float(*candidates)[3] = malloc(count * sizeof *candidates), *nearest = malloc(count * sizeof *nearest);
    uint32_t *triangle = malloc(count * sizeof *triangle), *chosen = malloc(n->count * sizeof *chosen);
    int failed = !candidates || !nearest || !triangle || !chosen || nsdf_area_table_create(&table, s) != 0;
    if (!failed) {
        for (uint32_t i = 0; i < count; i++)
            triangle[i] = nsdf_area_table_draw(&table, &random, candidates[i]);
        float last;
        (void)nsdf_nodes_choose_farthest(candidates, count, n->count, 0.0f, nearest, chosen, &last);
        n->spacing = sqrtf(last);
        for (uint32_t i = 0; i < n->count; i++)
            store_node(n, i, s, triangle[chosen[i]], candidates[chosen[i]]);
        nsdf_area_table_free(&table);
    }
    free(candidates);
    free(nearest);
    free(triangle);
    free(chosen);
    return failed ? -1 : 0;
}

/* ---- The graph ------------------------------------------------------------------------------------------- */

/* The nearest nodes of like normal, nearest first; returns how many. */
static uint32_t find_neighbours(const nsdf_nodes *n, uint32_t i, uint32_t found[MOST_NEIGHBOURS]) {
    const float *a = nsdf_node_at(n, n->rest, i), *an = nsdf_node_normal(n, n->rest, i);
    const float limit = neighbour_reach * neighbour_reach * n->spacing * n->spacing;
    float squares[MOST_NEIGHBOURS];
    uint32_t count = 0;
    for (uint32_t j = 0; j < n->count; j++) {
        const float *bn = nsdf_node_normal(n, n->rest, j), square = square_between(a, nsdf_node_at(n, n->rest, j));
        if (square > limit || j == i || an[0] * bn[0] + an[1] * bn[1] + an[2] * bn[2] < neighbour_cosine)
            continue;
        uint32_t at = count < MOST_NEIGHBOURS ? count++ : MOST_NEIGHBOURS;
        for (; at > 0 && squares[at - 1] > square; at--)
            if (at < MOST_NEIGHBOURS) {
                squares[at] = squares[at - 1];
                found[at] = found[at - 1];
            }
        if (at < MOST_NEIGHBOURS) {
            squares[at] = square;
            found[at] = j;
        }
    }
    return count;
}

static int has(const uint32_t *list, uint32_t count, uint32_t j) {
    for (uint32_t i = 0; i < count; i++)
        if (list[i] == j)
            return 1;
    return 0;
}

/* Neighbours are mutual: j of i where one of them found the other.  Counts two places ahead and sums one place ahead:
 * storing then moves every start to where it belongs. */
int nsdf_nodes_build_graph(nsdf_nodes *n) {
    free(n->start);
    free(n->next);
    uint32_t(*found)[MOST_NEIGHBOURS] = malloc(n->count * sizeof *found), *count = malloc(n->count * sizeof *count);
    n->start = calloc((size_t)n->count + 3, sizeof *n->start);
    n->next = malloc(sizeof *n->next * 2 * MOST_NEIGHBOURS * n->count);
    int failed = !found || !count || !n->start || !n->next;
    for (uint32_t i = 0; !failed && i < n->count; i++)
        count[i] = find_neighbours(n, i, found[i]);
    for (int store = 0; !failed && store < 2; store++) {
        for (uint32_t i = 0; i < n->count; i++)
            for (uint32_t e = 0; e < count[i]; e++) {
                const uint32_t j = found[i][e];
                const int both = has(found[j], count[j], i);
                if (both && j < i)
                    continue;
                if (store) {
                    n->next[n->start[i + 1]++] = j;
                    n->next[n->start[j + 1]++] = i;
                } else {
                    n->start[i + 2]++;
                    n->start[j + 2]++;
                }
            }
        for (uint32_t i = 0; !store && i < n->count; i++)
            n->start[i + 2] += n->start[i + 1];
    }
    free(found);
    free(count);
    return failed ? -1 : 0;
}

static int come_apart(const nsdf_nodes *n, uint32_t i, uint32_t j) {
    const float rest = square_between(nsdf_node_at(n, n->rest, i), nsdf_node_at(n, n->rest, j));
    const float limit = apart * apart * fmaxf(rest, 0.25f * n->spacing * n->spacing);
    for (uint32_t f = 0; f < n->frame_count; f++)
        if (square_between(nsdf_node_at(n, f, i), nsdf_node_at(n, f, j)) > limit)
            return 1;
    return 0;
}

/* Takes pairs out of the graph, which stay out on both sides. */
void nsdf_nodes_cut_graph(nsdf_nodes *n) {
    uint32_t kept = 0, from = 0;
    for (uint32_t i = 0; i < n->count; i++) {
        const uint32_t to = n->start[i + 1];
        for (uint32_t e = from; e < to; e++)
            if (!come_apart(n, i, n->next[e]))
                n->next[kept++] = n->next[e];
        from = to;
        n->start[i + 1] = kept;
    }
}

int nsdf_nodes_place(nsdf_nodes *nodes, const nsdf_frames *frames, uint32_t rest, uint32_t count, uint64_t seed) {
    memset(nodes, 0, sizeof *nodes);
    nodes->count = nodes->placed = count;
    nodes->frame_count = frames->count;
    nodes->rest = rest;
    nodes->positions = calloc((size_t)frames->count * count, sizeof *nodes->positions);
    nodes->normals = calloc((size_t)frames->count * count, sizeof *nodes->normals);
    nodes->support = malloc((size_t)frames->count * count);
    nodes->triangle = malloc(count * sizeof *nodes->triangle);
    nodes->barycentric = malloc(count * sizeof *nodes->barycentric);
    if (nodes->positions && nodes->normals && nodes->support && nodes->triangle && nodes->barycentric &&
        draw_nodes(nodes, nsdf_frame_outer(&frames->frames[rest]), seed) == 0 && nsdf_nodes_build_graph(nodes) == 0) {
        memset(nodes->support, 1, (size_t)frames->count * count);
        return 0;
    }
    nsdf_nodes_free(nodes);
    return -1;
}

/* ---- Carried by their triangles -------------------------------------------------------------------------- */

static void carry(nsdf_nodes *n, const nsdf_frames *frames, uint32_t f) {
    const nsdf_surface *rest = nsdf_frame_outer(&frames->frames[n->rest]);
    nsdf_surface moved = *rest; /* the triangles at rest on this frame's vertices */
    moved.positions = frames->frames[f].surface.positions;
    for (uint32_t i = 0; i < n->count; i++) {
        const nsdf_triangle t = nsdf_triangle_load(&moved, n->triangle[i]);
        const double v = (double)n->barycentric[i][0], w = (double)n->barycentric[i][1];
        nsdf_vec3 x = nsdf_vec3_scale(1.0 - v - w, t.corner[0]);
        x = nsdf_vec3_mad(nsdf_vec3_mad(x, v, t.corner[1]), w, t.corner[2]);
        nsdf_node_at(n, f, i)[0] = (float)x.x;
        nsdf_node_at(n, f, i)[1] = (float)x.y;
        nsdf_node_at(n, f, i)[2] = (float)x.z;
        set_normal(nsdf_node_normal(n, f, i), &t);
    }
}

void nsdf_nodes_carry(nsdf_nodes *nodes, const nsdf_frames *frames) {
    for (uint32_t f = 0; f < nodes->frame_count; f++)
        carry(nodes, frames, f);
    nsdf_nodes_cut_graph(nodes);
}
