#include "register_nodes.h"

#include "nearest.h"
#include "rotation.h"
#include "surface_sample.h"
#include "triangle.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ROUNDS = 9, SOLVER_STEPS = 16, TARGETS = 1500, TARGET_ROUNDS = 3 };
/* Weight of the rigidity of neighbours, from the first round to the last. */
static const double stiff = 4.0, soft = 0.15;
/* Of a match: across the surface 1, along it so much; for the frame's own points. */
static const double along = 0.02, target_across = 1.0, target_along = 0.05;
/* Normals of matches are not further than 60 degrees apart, and points not further than this part of the diagonal. */
static const double match_cosine = 0.5, match_reach = 0.08;
static const double momentum = 0.9;
/* Edges that are off by so many spacings hold a quarter. */
static const double tear = 2.5;

/* What one direction in time works with. */
typedef struct {
    nsdf_nodes *nodes;
    const nsdf_frames *frames;
    uint64_t seed;
    int step; /* +1 or -1 frames */
    double (*rotation)[9];
    double (*at)[3], (*before)[3];    /* positions now, and at the frame before */
    double (*matrix)[6], (*right)[3]; /* matches: quadratic form xx, xy, xz, yy, yz, zz, and linear term */
    double (*residual)[3], (*search)[3], (*image)[3]; /* of the solver */
    double *edge;                                     /* [directed edge]: how far it still holds */
    double rigidity;
    int failed;
} walk;

static void free_walk(walk *w) {
    void *arrays[] = {w->rotation, w->at, w->before, w->matrix, w->right, w->residual, w->search, w->image, w->edge};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        free(arrays[i]);
}

static int create_walk(walk *w) {
    const size_t n = w->nodes->count;
    w->rotation = malloc(n * sizeof *w->rotation);
    w->at = malloc(n * sizeof *w->at);
    w->before = malloc(n * sizeof *w->before);
    w->matrix = malloc(n * sizeof *w->matrix);
    w->right = malloc(n * sizeof *w->right);
    w->residual = malloc(n * sizeof *w->residual);
    w->search = malloc(n * sizeof *w->search);
    w->image = malloc(n * sizeof *w->image);
    w->edge = malloc(((size_t)w->nodes->start[n] + 1) * sizeof *w->edge);
    if (!w->edge || !w->rotation || !w->at || !w->before || !w->matrix || !w->right || !w->residual || !w->search ||
        !w->image)
        return -1;
    for (uint32_t e = 0; e < w->nodes->start[n]; e++)
        w->edge[e] = 1.0;
    for (uint32_t i = 0; i < n; i++) {
        static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
        memcpy(w->rotation[i], identity, sizeof identity);
        for (int k = 0; k < 3; k++)
            w->at[i][k] = w->before[i][k] = (double)nsdf_node_at(w->nodes, w->nodes->rest, i)[k];
    }
    return 0;
}

/* ---- Matches --------------------------------------------------------------------------------------------- */

/* The node's normal at rest, turned. */
static nsdf_vec3 normal_of(const walk *w, uint32_t i) {
    const float *n = nsdf_node_normal(w->nodes, w->nodes->rest, i);
    const double *r = w->rotation[i], x = (double)n[0], y = (double)n[1], z = (double)n[2];
    return (nsdf_vec3){r[0] * x + r[1] * y + r[2] * z, r[3] * x + r[4] * y + r[5] * z, r[6] * x + r[7] * y + r[8] * z};
}

static void add_match(walk *w, uint32_t i, nsdf_vec3 n, nsdf_vec3 q, double across, double tangential) {
    const double a = across - tangential, plane = a * nsdf_vec3_dot(n, q);
    double *m = w->matrix[i];
    m[0] += a * n.x * n.x + tangential;
    m[1] += a * n.x * n.y;
    m[2] += a * n.x * n.z;
    m[3] += a * n.y * n.y + tangential;
    m[4] += a * n.y * n.z;
    m[5] += a * n.z * n.z + tangential;
    w->right[i][0] += plane * n.x + tangential * q.x;
    w->right[i][1] += plane * n.y + tangential * q.y;
    w->right[i][2] += plane * n.z + tangential * q.z;
}

static void match_nodes(walk *w, const nsdf_nearest_index *index) {
    for (uint32_t i = 0; i < w->nodes->count; i++) {
        const float x[3] = {(float)w->at[i][0], (float)w->at[i][1], (float)w->at[i][2]};
        const nsdf_nearest near = nsdf_find_nearest(index, x, (float)match_reach);
        const double length = nsdf_vec3_length(near.normal);
        memset(w->matrix[i], 0, sizeof w->matrix[i]);
        memset(w->right[i], 0, sizeof w->right[i]);
        if (!(near.distance2 < match_reach * match_reach) || !(length > 0.0))
            continue;
        const nsdf_vec3 n = nsdf_vec3_scale(1.0 / length, near.normal);
        if (nsdf_vec3_dot(n, normal_of(w, i)) > match_cosine)
            add_match(w, i, n, near.point, 1.0, along);
    }
}

/* Points of the frame, with normals. */
typedef struct {
    float at[TARGETS][3];
    nsdf_vec3 normal[TARGETS];
} targets;

static int draw_targets(const nsdf_surface *s, uint64_t seed, uint32_t frame, targets *t) {
    nsdf_random random = nsdf_random_start(seed, 0x200000000u + frame);
    nsdf_area_table table;
    if (nsdf_area_table_create(&table, s) != 0)
        return -1;
    for (int i = 0; i < TARGETS; i++) {
        const nsdf_triangle triangle = nsdf_triangle_load(s, nsdf_area_table_draw(&table, &random, t->at[i]));
        t->normal[i] = nsdf_triangle_normal(&triangle);
    }
    nsdf_area_table_free(&table);
    return 0;
}

static void match_targets(walk *w, const targets *t, float (*positions)[3], nsdf_vec3 *normals) {
    const uint32_t count = w->nodes->count;
    for (uint32_t i = 0; i < count; i++) {
        normals[i] = normal_of(w, i);
        for (int k = 0; k < 3; k++)
            positions[i][k] = (float)w->at[i][k];
    }
    for (int s = 0; s < TARGETS; s++) {
        float least = (float)(match_reach * match_reach);
        uint32_t best = count;
        for (uint32_t i = 0; i < count; i++) {
            const float dx = positions[i][0] - t->at[s][0], dy = positions[i][1] - t->at[s][1];
            const float dz = positions[i][2] - t->at[s][2], square = dx * dx + dy * dy + dz * dz;
            if (square < least && nsdf_vec3_dot(normals[i], t->normal[s]) > match_cosine) {
                least = square;
                best = i;
            }
        }
        if (best < count)
            add_match(w, best, t->normal[s], nsdf_vec3_load(t->at[s]), target_across, target_along);
    }
}

/* ---- As rigid as possible -------------------------------------------------------------------------------- */

static void rest_edge(const nsdf_nodes *n, uint32_t i, uint32_t j, double e[3]) {
    const float *a = nsdf_node_at(n, n->rest, i), *b = nsdf_node_at(n, n->rest, j);
    for (int k = 0; k < 3; k++)
        e[k] = (double)a[k] - (double)b[k];
}

static void turn_nodes(walk *w) {
    const nsdf_nodes *n = w->nodes;
    for (uint32_t i = 0; i < n->count; i++) {
        double mixed[9] = {0.0};
        for (uint32_t e = n->start[i]; e < n->start[i + 1]; e++) {
            double rest[3];
            rest_edge(n, i, n->next[e], rest);
            for (int a = 0; a < 3; a++)
                for (int b = 0; b < 3; b++)
                    mixed[3 * a + b] += w->edge[e] * (w->at[i][a] - w->at[n->next[e]][a]) * rest[b];
        }
        nsdf_extract_rotation(mixed, w->rotation[i]);
    }
}

/* The edge at rest, turned by the mean of both ends' rotations. */
static void turned_edge(const walk *w, uint32_t i, uint32_t j, double out[3]) {
    const double *r = w->rotation[i], *q = w->rotation[j];
    double rest[3];
    rest_edge(w->nodes, i, j, rest);
    for (int a = 0; a < 3; a++)
        out[a] = 0.5 * ((r[3 * a] + q[3 * a]) * rest[0] + (r[3 * a + 1] + q[3 * a + 1]) * rest[1] +
                        (r[3 * a + 2] + q[3 * a + 2]) * rest[2]);
}

/* Edges that are torn hold less (Geman & McClure's weight): parts that touched at rest come apart. */
static void weigh_edges(walk *w) {
    const nsdf_nodes *n = w->nodes;
    const double scale = 1.0 / (tear * tear * (double)n->spacing * (double)n->spacing);
    for (uint32_t i = 0; i < n->count; i++)
        for (uint32_t e = n->start[i]; e < n->start[i + 1]; e++) {
            double turned[3], square = 0.0;
            turned_edge(w, i, n->next[e], turned);
            for (int a = 0; a < 3; a++) {
                const double miss = w->at[i][a] - w->at[n->next[e]][a] - turned[a];
                square += miss * miss;
            }
            const double root = 1.0 / (1.0 + scale * square);
            w->edge[e] = root * root;
        }
}

/* What rigidity adds to the right side. */
static void add_rigid_edges(walk *w) {
    const nsdf_nodes *n = w->nodes;
    for (uint32_t i = 0; i < n->count; i++)
        for (uint32_t e = n->start[i]; e < n->start[i + 1]; e++) {
            double turned[3];
            turned_edge(w, i, n->next[e], turned);
            for (int a = 0; a < 3; a++)
                w->right[i][a] += w->rigidity * w->edge[e] * turned[a];
        }
}

/* out = A x for the matches' quadratic forms and the graph's Laplacian. */
static void apply(const walk *w, double (*x)[3], double (*out)[3]) {
    const nsdf_nodes *n = w->nodes;
    for (uint32_t i = 0; i < n->count; i++) {
        const double *m = w->matrix[i];
        double sum[3] = {0.0, 0.0, 0.0}, degree = 1e-6;
        for (uint32_t e = n->start[i]; e < n->start[i + 1]; e++) {
            degree += w->rigidity * w->edge[e];
            for (int k = 0; k < 3; k++)
                sum[k] += w->edge[e] * x[n->next[e]][k];
        }
        out[i][0] = m[0] * x[i][0] + m[1] * x[i][1] + m[2] * x[i][2] + degree * x[i][0] - w->rigidity * sum[0];
        out[i][1] = m[1] * x[i][0] + m[3] * x[i][1] + m[4] * x[i][2] + degree * x[i][1] - w->rigidity * sum[1];
        out[i][2] = m[2] * x[i][0] + m[4] * x[i][1] + m[5] * x[i][2] + degree * x[i][2] - w->rigidity * sum[2];
    }
}

static double dot(double (*a)[3], double (*b)[3], size_t count) {
    double sum = 0.0;
    for (size_t i = 0; i < count; i++)
        sum += a[i][0] * b[i][0] + a[i][1] * b[i][1] + a[i][2] * b[i][2];
    return sum;
}

/* Conjugate gradients from where the nodes are; the 1e-6 that keeps loose nodes in place is on both sides. */
static void solve(walk *w) {
    const size_t n = w->nodes->count;
    apply(w, w->at, w->image);
    for (size_t i = 0; i < n; i++)
        for (int k = 0; k < 3; k++)
            w->residual[i][k] = w->search[i][k] = w->right[i][k] + 1e-6 * w->at[i][k] - w->image[i][k];
    double square = dot(w->residual, w->residual, n);
    for (int step = 0; step < SOLVER_STEPS && square > 1e-16; step++) {
        apply(w, w->search, w->image);
        const double length = square / dot(w->search, w->image, n);
        for (size_t i = 0; i < n; i++)
            for (int k = 0; k < 3; k++) {
                w->at[i][k] += length * w->search[i][k];
                w->residual[i][k] -= length * w->image[i][k];
            }
        const double next = dot(w->residual, w->residual, n), turn = next / square;
        for (size_t i = 0; i < n; i++)
            for (int k = 0; k < 3; k++)
                w->search[i][k] = w->residual[i][k] + turn * w->search[i][k];
        square = next;
    }
}

/* ---- From frame to frame --------------------------------------------------------------------------------- */

/* Goes on as between the last two frames. */
static void predict(walk *w) {
    for (uint32_t i = 0; i < w->nodes->count; i++)
        for (int k = 0; k < 3; k++) {
            const double now = w->at[i][k];
            w->at[i][k] += momentum * (now - w->before[i][k]);
            w->before[i][k] = now;
        }
}

typedef struct {
    targets targets;
    float (*positions)[3];
    nsdf_vec3 *normals;
} scratch;

static int register_frame(walk *w, uint32_t frame, scratch *s) {
    const nsdf_surface *surface = nsdf_frame_outer(&w->frames->frames[frame]);
    nsdf_nearest_index index;
    int failed =
        nsdf_nearest_index_build(&index, surface, true) != 0 || draw_targets(surface, w->seed, frame, &s->targets) != 0;
    if (!failed) {
        predict(w);
        for (int round = 0; round < ROUNDS; round++) {
            w->rigidity = stiff * pow(soft / stiff, (double)round / (ROUNDS - 1));
            turn_nodes(w);
            if (round >= ROUNDS / 2) /* before that, what is off may be on its way */
                weigh_edges(w);
            match_nodes(w, &index);
            if (round % TARGET_ROUNDS == TARGET_ROUNDS - 1)
                match_targets(w, &s->targets, s->positions, s->normals);
            add_rigid_edges(w);
            solve(w);
        }
        for (uint32_t i = 0; i < w->nodes->count; i++) {
            const nsdf_vec3 normal = normal_of(w, i);
            const double turned[3] = {normal.x, normal.y, normal.z};
            for (int k = 0; k < 3; k++) {
                nsdf_node_at(w->nodes, frame, i)[k] = (float)w->at[i][k];
                nsdf_node_normal(w->nodes, frame, i)[k] = (float)turned[k];
            }
        }
    }
    nsdf_nearest_index_free(&index);
    return failed ? -1 : 0;
}

static void walk_frames(void *data, uint32_t index, uint32_t worker) {
    walk *w = (walk *)data + index;
    scratch *s = malloc(sizeof *s);
    (void)worker;
    if (s) {
        s->positions = malloc(w->nodes->count * sizeof *s->positions);
        s->normals = malloc(w->nodes->count * sizeof *s->normals);
    }
    w->failed = !s || !s->positions || !s->normals || create_walk(w) != 0;
    for (int64_t f = (int64_t)w->nodes->rest + w->step; !w->failed && f >= 0 && f < w->frames->count; f += w->step)
        w->failed = register_frame(w, (uint32_t)f, s);
    if (s) {
        free(s->positions);
        free(s->normals);
    }
    free(s);
    free_walk(w);
}

int nsdf_nodes_register(nsdf_nodes *nodes, const nsdf_frames *frames, uint64_t seed, nsdf_workers *workers) {
    walk walks[2] = {{.nodes = nodes, .frames = frames, .seed = seed, .step = 1},
                     {.nodes = nodes, .frames = frames, .seed = seed, .step = -1}};
    nsdf_workers_run(workers, 2, walk_frames, walks);
    if (walks[0].failed || walks[1].failed)
        return -1;
    nsdf_nodes_cut_graph(nodes);
    return 0;
}
