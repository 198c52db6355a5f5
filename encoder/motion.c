#include "motion.h"

#include "dense_solve.h"
#include "rotation.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Nodes within this many radii of a centre, along the surface, move its block. */
static const double neighbourhood = 1.1;
/* How strongly the affine map is drawn to the rigid one, as a share of the neighbourhood's variance. */
static const double rigidity = 0.05;
/* A block lives where some of its nodes have support.  Where not nearly all have, part of its surface is hidden, as
 * where two parts touch: its polynomial is another one there, and so it is another block. */
static const double some_share = 0.3, nearly_all = 0.7;
enum { ABSENT = 0, PARTLY = 1, WHOLE = 2 };
/* A life that could go on as another is at least this long: frames, and share of all. */
enum { SHORTEST = 4, SHORTEST_SHARE = 16 };
static const double longest_axis = 2.5, least_volume = 0.1;

double nsdf_block_radius(const nsdf_encoder_options *o, double area) {
    return o->block_radius > 0.0 ? o->block_radius : sqrt(o->block_overlap * area / (3.141592653589793 * o->blocks));
}

void nsdf_motion_free(nsdf_motion *motion) {
    free(motion->centres);
    free(motion->normals);
    free(motion->lives);
    free(motion->poses);
    memset(motion, 0, sizeof *motion);
}

/* ---- Neighbourhoods -------------------------------------------------------------------------------------- */

static double distance_between(const nsdf_nodes *n, uint32_t a, uint32_t b) {
    const float *p = nsdf_node_at(n, n->rest, a), *q = nsdf_node_at(n, n->rest, b);
    const double x = (double)(p[0] - q[0]), y = (double)(p[1] - q[1]), z = (double)(p[2] - q[2]);
    return sqrt(x * x + y * y + z * z);
}

/* A worker's search along the surface. */
typedef struct {
    float *distance; /* [node]: infinite but for the list's */
    uint32_t *list;  /* nodes that were reached */
    uint32_t count;
} search;

/* Nodes within `limit` of `source` along edges: paths are corrected until none gets shorter. */
static void walk(const nsdf_nodes *g, uint32_t source, double limit, search *w) {
    for (uint32_t i = 0; i < w->count; i++)
        w->distance[w->list[i]] = INFINITY;
    w->count = 1;
    w->list[0] = source;
    w->distance[source] = 0.0f;
    for (int changed = 1; changed;) {
        changed = 0;
        for (uint32_t i = 0; i < w->count; i++) {
            uint32_t a = w->list[i];
            for (uint32_t e = g->start[a]; e < g->start[a + 1]; e++) {
                uint32_t b = g->next[e];
                float d = w->distance[a] + (float)distance_between(g, a, b);
                if (!(d < (float)limit && d < w->distance[b]))
                    continue;
                if (isinf(w->distance[b]))
                    w->list[w->count++] = b;
                else
                    changed = 1;
                w->distance[b] = d;
            }
        }
    }
}

/* ---- Following ------------------------------------------------------------------------------------------- */

typedef struct {
    nsdf_motion *motion;
    const nsdf_nodes *nodes;
    search *searches; /* [worker] */
    uint32_t *chosen; /* [candidate]: nodes that blocks are placed on */
    uint32_t candidates;
    uint8_t *state; /* [candidate][frame] */
} job;

/* The nodes around a block's centre, weighed by their distance. */
typedef struct {
    const search *around;
    double reach, total;
    double middle[3]; /* at rest */
    double spread[9]; /* at rest: sum w (X - middle)(X - middle)^T */
} patch;

static double node_weight(const patch *p, uint32_t i) {
    double q = (double)p->around->distance[p->around->list[i]] / p->reach;
    return 1.0 - q * q;
}

static void weighted_middle(const patch *p, const nsdf_nodes *n, uint32_t frame, double middle[3]) {
    middle[0] = middle[1] = middle[2] = 0.0;
    for (uint32_t i = 0; i < p->around->count; i++)
        for (size_t k = 0; k < 3; k++)
            middle[k] += node_weight(p, i) / p->total * (double)nsdf_node_at(n, frame, p->around->list[i])[k];
}

/* sum w (x - m)(X - M)^T between a frame and that at rest. */
static void covariance(const patch *p, const nsdf_nodes *n, uint32_t frame, const double m[3], double sum[9]) {
    memset(sum, 0, 9 * sizeof *sum);
    for (uint32_t i = 0; i < p->around->count; i++) {
        const float *x = nsdf_node_at(n, frame, p->around->list[i]);
        const float *y = nsdf_node_at(n, n->rest, p->around->list[i]);
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++)
                sum[3 * a + b] += node_weight(p, i) * ((double)x[a] - m[a]) * ((double)y[b] - p->middle[b]);
    }
}

static void fit_pose(const job *j, const patch *p, uint32_t frame, const float centre[3], double rotation[9],
                     nsdf_pose *pose) {
    double middle[3], mixed[9], normal[9], transposed[9];
    weighted_middle(p, j->nodes, frame, middle);
    covariance(p, j->nodes, frame, middle, mixed);
    nsdf_extract_rotation(mixed, rotation);
    double pull = rigidity * (p->spread[0] + p->spread[4] + p->spread[8]) / 3.0 + 1e-12;
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
            normal[3 * a + b] = p->spread[3 * a + b] + (a == b ? pull : 0.0);
            transposed[3 * b + a] = mixed[3 * a + b] + pull * rotation[3 * a + b];
        }
    nsdf_solve_positive(normal, 3, transposed, 3);
    for (int a = 0; a < 3; a++) {
        pose->position[a] = middle[a];
        for (int b = 0; b < 3; b++) {
            pose->linear[3 * a + b] = transposed[3 * b + a];
            pose->position[a] += transposed[3 * b + a] * ((double)centre[b] - p->middle[b]);
        }
    }
}

int nsdf_pose_keeps_ball(const nsdf_pose *pose) {
    const double *m = pose->linear;
    double longest = 0.0;
    for (int k = 0; k < 3; k++)
        longest = fmax(longest, m[k] * m[k] + m[3 + k] * m[3 + k] + m[6 + k] * m[6 + k]);
    const double volume =
        m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) + m[2] * (m[3] * m[7] - m[4] * m[6]);
    return longest < longest_axis * longest_axis && volume > least_volume;
}

/* Runs of frames that are too short become what was before them, or after. */
static void merge_short_runs(uint8_t *state, uint32_t frames) {
    const uint32_t shortest = frames / SHORTEST_SHARE > SHORTEST ? frames / SHORTEST_SHARE : SHORTEST;
    for (uint32_t first = 0, last; first < frames; first = last + 1) {
        for (last = first; last + 1 < frames && state[last + 1] == state[first];)
            last++;
        if (last - first + 1 >= shortest)
            continue;
        const uint8_t before = first > 0 ? state[first - 1] : ABSENT,
                      after = last + 1 < frames ? state[last + 1] : ABSENT;
        if (before != ABSENT || after != ABSENT)
            memset(state + first, before != ABSENT ? before : after, last - first + 1);
    }
}

/* How much of a block there is on each frame. */
static void find_states(const job *j, const patch *p, uint32_t index) {
    const nsdf_nodes *n = j->nodes;
    uint8_t *state = j->state + (size_t)index * n->frame_count;
    for (uint32_t f = 0; f < n->frame_count; f++) {
        double sum = 0.0;
        for (uint32_t i = 0; i < p->around->count; i++)
            sum += node_weight(p, i) * n->support[(size_t)f * n->count + p->around->list[i]];
        state[f] = sum > nearly_all * p->total ? WHOLE : sum > some_share * p->total ? PARTLY : ABSENT;
        if (!nsdf_pose_keeps_ball(&j->motion->poses[(size_t)index * n->frame_count + f]))
            state[f] = ABSENT;
    }
    merge_short_runs(state, n->frame_count);
}

/* From the frame at rest forwards and backwards, each rotation from the one before. */
static void follow(void *data, uint32_t index, uint32_t worker) {
    const job *j = data;
    const uint32_t node = j->chosen[index], block = index;
    nsdf_motion *m = j->motion;
    search *around = &j->searches[worker];
    patch p = {.around = around};
    p.reach = neighbourhood * 1.05 * (double)m->radius;
    walk(j->nodes, node, neighbourhood * (double)m->radius, around);
    for (uint32_t i = 0; i < around->count; i++)
        p.total += node_weight(&p, i);
    weighted_middle(&p, j->nodes, j->nodes->rest, p.middle);
    covariance(&p, j->nodes, j->nodes->rest, p.middle, p.spread);
    for (int direction = 1; direction >= -1; direction -= 2) {
        double rotation[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
        for (int64_t f = j->nodes->rest; f >= 0 && f < m->frame_count; f += direction)
            fit_pose(j, &p, (uint32_t)f, nsdf_node_at(j->nodes, j->nodes->rest, node), rotation,
                     &m->poses[(size_t)block * m->frame_count + (size_t)f]);
        find_states(j, &p, index);
    }
}

static void free_searches(search *s, uint32_t count) {
    for (uint32_t i = 0; s && i < count; i++) {
        free(s[i].distance);
        free(s[i].list);
    }
    free(s);
}

static search *create_searches(uint32_t count, uint32_t nodes) {
    search *s = calloc(count, sizeof *s);
    for (uint32_t i = 0; s && i < count; i++) {
        s[i].distance = malloc(sizeof(float) * ((size_t)nodes + 1));
        s[i].list = malloc(sizeof(uint32_t) * ((size_t)nodes + 1));
        if (!s[i].distance || !s[i].list) {
            free_searches(s, count);
            return NULL;
        }
        for (uint32_t v = 0; v < nodes; v++)
            s[i].distance[v] = INFINITY;
    }
    return s;
}

/* The first nodes in the order of farthest points, and those that were added for bare surface as far as they are no
 * closer to others than these are among themselves. */
static int choose_nodes(job *j, uint32_t blocks, double area) {
    const nsdf_nodes *n = j->nodes;
    const double apart = 0.8 * sqrt(area / blocks);
    j->chosen = malloc(n->count * sizeof *j->chosen);
    if (!j->chosen)
        return -1;
    for (uint32_t i = 0; i < n->count; i++) {
        int take = i < blocks;
        if (i >= n->placed) {
            take = 1;
            for (uint32_t k = 0; take && k < j->candidates; k++)
                take = distance_between(n, i, j->chosen[k]) > apart || j->chosen[k] < n->placed;
        }
        if (take)
            j->chosen[j->candidates++] = i;
    }
    return 0;
}

/* The next stretch of frames of one state from *first on; returns whether there is one. */
static int next_life(const uint8_t *state, uint32_t frames, uint32_t *first, uint32_t *last) {
    while (*first < frames && state[*first] == ABSENT)
        ++*first;
    for (*last = *first; *last + 1 < frames && state[*last + 1] == state[*first];)
        ++*last;
    return *first < frames;
}

static uint32_t count_lives(const job *j) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < j->candidates; i++) {
        uint32_t last;
        for (uint32_t first = 0;
             next_life(j->state + (size_t)i * j->nodes->frame_count, j->nodes->frame_count, &first, &last);
             first = last + 1)
            count++;
    }
    return count;
}

static void fill_block(const job *j, const nsdf_pose *poses, uint32_t candidate, uint32_t block) {
    nsdf_motion *m = j->motion;
    memcpy(m->centres[block], nsdf_node_at(j->nodes, j->nodes->rest, j->chosen[candidate]), sizeof *m->centres);
    memcpy(m->normals[block], nsdf_node_normal(j->nodes, j->nodes->rest, j->chosen[candidate]), sizeof *m->normals);
    for (uint32_t f = 0; f < m->frame_count; f++)
        m->poses[(size_t)f * m->block_count + block] = poses[(size_t)candidate * m->frame_count + f];
}

/* Blocks from candidates and their lives. */
static int make_blocks(job *j) {
    nsdf_motion *m = j->motion;
    const size_t count = m->block_count = count_lives(j);
    uint32_t block = 0;
    nsdf_pose *poses = m->poses;
    m->poses = malloc(sizeof *m->poses * count * m->frame_count);
    m->centres = malloc(sizeof *m->centres * count);
    m->normals = malloc(sizeof *m->normals * count);
    m->lives = malloc(sizeof *m->lives * count);
    const int ok = count > 0 && m->poses && m->centres && m->normals && m->lives;
    for (uint32_t i = 0; ok && i < j->candidates; i++) {
        uint32_t last;
        for (uint32_t first = 0; next_life(j->state + (size_t)i * m->frame_count, m->frame_count, &first, &last);
             first = last + 1) {
            m->lives[block][0] = first;
            m->lives[block][1] = last;
            fill_block(j, poses, i, block++);
        }
    }
    free(poses);
    return ok ? 0 : -1;
}

int nsdf_motion_find(nsdf_motion *motion, const nsdf_nodes *nodes, uint32_t blocks, double area, float radius,
                     nsdf_workers *workers) {
    memset(motion, 0, sizeof *motion);
    job j = {.motion = motion, .nodes = nodes};
    motion->frame_count = nodes->frame_count;
    motion->radius = radius;
    int failed = choose_nodes(&j, blocks, area);
    j.searches = create_searches(nsdf_workers_count(workers), nodes->count);
    j.state = malloc((size_t)j.candidates * nodes->frame_count + 1);
    motion->poses = malloc(sizeof *motion->poses * ((size_t)j.candidates * nodes->frame_count + 1));
    failed |= !j.searches || !j.state || !motion->poses;
    if (!failed) {
        nsdf_workers_run(workers, j.candidates, follow, &j);
        failed = make_blocks(&j);
    }
    free_searches(j.searches, nsdf_workers_count(workers));
    free(j.state);
    free(j.chosen);
    if (failed)
        nsdf_motion_free(motion);
    return failed ? -1 : 0;
}
