/* Moves the vertices onto the zero set by Newton steps along the gradient, those that such steps do not bring there by
 * halving their grid edge, and makes the normals.  Each batch goes through all steps on its own; a vertex takes part in
 * an evaluation only while it needs it. */
#include "mesher_internal.h"

#include <math.h>
#include <string.h>

static const float tolerance = 2.5e-4f; /* a vertex is on the zero set when |f| / |g| is below so many cells */
static const float most_travel = 0.5f;  /* in cells; further, and triangles would fold over */
static const float stale_travel = 0.1f; /* in cells; a normal is made anew when its vertex has moved further since.
                                           Steps run along the gradient, along which a distance's own does not turn */

typedef struct batch {
    const nsdf_mesher *mesher;
    nsdf_mesher_scratch *s;
    uint32_t worker, first, count;
    const uint8_t *loose; /* [count] */
} batch;

/* ---- Evaluation of the listed vertices --------------------------------------------------------------------- */

static void evaluate(const batch *b, uint32_t count, float *const slope[3]) {
    const nsdf_field *field = &b->mesher->job->field;
    const float *const xyz[3] = {b->s->point[0], b->s->point[1], b->s->point[2]};
    b->s->evaluated += count;
    if (count > 0)
        field->evaluate(field->user, b->worker, count, xyz, b->s->value, slope);
}

/* Distance and gradient at the positions of the listed vertices. */
static void evaluate_gradients(const batch *b, uint32_t count) {
    nsdf_mesher_scratch *s = b->s;
    for (uint32_t i = 0; i < count; i++)
        for (int a = 0; a < 3; a++)
            s->point[a][i] = s->position[a][s->list[i]];
    evaluate(b, count, (float *const[3]){s->slope[0], s->slope[1], s->slope[2]});
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t v = s->list[i];
        s->distance[v] = s->value[i];
        for (int a = 0; a < 3; a++)
            s->gradient[a][v] = s->slope[a][i];
        s->travel[v] = 0;
    }
}

static float squared_gradient(const nsdf_mesher_scratch *s, uint32_t v) {
    return s->gradient[0][v] * s->gradient[0][v] + s->gradient[1][v] * s->gradient[1][v] +
           s->gradient[2][v] * s->gradient[2][v];
}

/* Neither too flat for a direction nor overflowed; false for NaN. */
static int gradient_is_usable(float squared) {
    return (squared > 1e-8f) & (squared < 1e8f);
}

/* ---- Newton steps ------------------------------------------------------------------------------------------ */

/* Lists the chosen vertices; returns how many. */
static uint32_t list_chosen(const batch *b) {
    nsdf_mesher_scratch *s = b->s;
    uint32_t n = 0;
    for (uint32_t v = 0; v < b->count; v++) {
        s->list[n] = v;
        n += (uint32_t)s->chosen[v];
    }
    return n;
}

/* Whether a vertex at this distance is off the surface; conditions without branches go into vectors. */
static inline int is_off_surface(float distance, float square, float limit) {
    const float size = fabsf(distance);
    return gradient_is_usable(square) & (size > limit * sqrtf(square)) & (size < NSDF_FIELD_LIMIT);
}

static uint32_t list_off_surface(const batch *b) {
    nsdf_mesher_scratch *s = b->s;
    const float limit = tolerance * (float)b->mesher->grid.step;
    for (uint32_t v = 0; v < b->count; v++)
        s->chosen[v] =
            (b->loose[v] != NSDF_VERTEX_ON_BORDER) & is_off_surface(s->distance[v], squared_gradient(s, v), limit);
    return list_chosen(b);
}

/* Where vertex v would go, as the i-th point: at most most_travel from where it was born, within the domain. */
static void propose(const batch *b, uint32_t i, uint32_t v) {
    nsdf_mesher_scratch *s = b->s;
    const nsdf_mesher_job *job = b->mesher->job;
    const float factor = -s->damping[v] * s->distance[v] / squared_gradient(s, v);
    float away[3], square = 0;
    for (int a = 0; a < 3; a++) {
        away[a] = s->position[a][v] + factor * s->gradient[a][v] - s->start[a][v];
        square += away[a] * away[a];
    }
    const float limit = most_travel * (float)b->mesher->grid.step;
    const float shrink = square > limit * limit ? limit / sqrtf(square) : 1;
    for (int a = 0; a < 3; a++) {
        const float x = s->start[a][v] + shrink * away[a];
        s->point[a][i] = x < job->domain_min[a] ? job->domain_min[a] : x > job->domain_max[a] ? job->domain_max[a] : x;
    }
}

/* A step that brings the vertex nearer is taken; after one that does not, the next is half as long. */
static void take_or_damp(const batch *b, uint32_t i, uint32_t v) {
    nsdf_mesher_scratch *s = b->s;
    if (!(fabsf(s->value[i]) < fabsf(s->distance[v]))) {
        s->damping[v] *= 0.5f;
        return;
    }
    float square = 0;
    for (int a = 0; a < 3; a++) {
        const float moved = s->point[a][i] - s->position[a][v];
        square += moved * moved;
        s->position[a][v] = s->point[a][i];
    }
    s->travel[v] += sqrtf(square);
    s->distance[v] = s->value[i];
}

static void project(const batch *b) {
    nsdf_mesher_scratch *s = b->s;
    float *const no_gradient[3] = {NULL, NULL, NULL};
    for (uint32_t step = 0; step < b->mesher->job->projection; step++) {
        uint32_t n = list_off_surface(b), moved = 0;
        if (step > 0) {
            for (uint32_t i = 0; i < n; i++)
                if (s->travel[s->list[i]] > 0)
                    s->list[moved++] = s->list[i];
            evaluate_gradients(b, moved);
            n = list_off_surface(b);
        }
        if (n == 0)
            return;
        for (uint32_t i = 0; i < n; i++)
            propose(b, i, s->list[i]);
        evaluate(b, n, no_gradient);
        for (uint32_t i = 0; i < n; i++)
            take_or_damp(b, i, s->list[i]);
    }
}

/* ---- Halving ----------------------------------------------------------------------------------------------- */

/* Newton's steps fail at creases, and where the field jumps from one side of zero to the other.  On its grid edge the
 * sign changes in any case: halving finds the place to a 2^22th of a cell, which no float tells from it. */
enum { HALVINGS = 22 };
/* In cells; nearer to a corner the vertices of its edges would fall together. */
static const float edge_margin = 1e-4f;

/* The grid edge on which vertex v was born: two of its coordinates are those of corners. */
static void find_edge(const batch *b, uint32_t v) {
    nsdf_mesher_scratch *s = b->s;
    const nsdf_grid *grid = &b->mesher->grid;
    float most = -1;
    for (int a = 0; a < 3; a++) {
        const float x = s->start[a][v], *corner = grid->corners[a];
        const double place = ((double)x - (double)corner[0]) / grid->step;
        uint32_t low = place > 0 ? (uint32_t)place : 0;
        low = low < grid->cells[a] ? low : grid->cells[a] - 1;
        low -= low > 0 && corner[low] > x;
        low += low + 1 < grid->cells[a] && corner[low + 1] <= x;
        const float off = fminf(x - corner[low], corner[low + 1] - x);
        if (off <= most)
            continue;
        most = off;
        s->axis[v] = (uint8_t)a;
        s->low[v] = corner[low] + edge_margin * (float)grid->step;
        s->high[v] = corner[low + 1] - edge_margin * (float)grid->step;
    }
}

/* Evaluates each listed vertex at a place of its edge: its low end, its high end, the middle, or the corner below. */
enum { AT_LOW, AT_HIGH, AT_MIDDLE, AT_CORNER };

static void evaluate_edges(const batch *b, const uint32_t *list, uint32_t count, int where) {
    nsdf_mesher_scratch *s = b->s;
    const float margin = edge_margin * (float)b->mesher->grid.step;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t v = list[i];
        for (int a = 0; a < 3; a++)
            s->point[a][i] = s->start[a][v];
        s->point[s->axis[v]][i] = where == AT_LOW      ? s->low[v]
                                  : where == AT_HIGH   ? s->high[v]
                                  : where == AT_CORNER ? s->low[v] - margin
                                                       : 0.5f * (s->low[v] + s->high[v]);
    }
    evaluate(b, count, (float *const[3]){NULL, NULL, NULL});
}

/* The vertices that Newton's steps have left off the surface; those without a usable gradient are.  Where the field is
 * steep its gradient turns fast, and what is known of it, from before the last step, is worth less. */
static uint32_t list_left(const batch *b) {
    nsdf_mesher_scratch *s = b->s;
    const float limit = tolerance * (float)b->mesher->grid.step;
    for (uint32_t v = 0; v < b->count; v++) {
        const float square = squared_gradient(s, v), distance = s->distance[v];
        const int far =
            is_off_surface(distance, square, limit) | ((square > 4) & (fabsf(distance) > 0.5f * limit * sqrtf(square)));
        const int usable = gradient_is_usable(square);
        s->chosen[v] = (b->loose[v] != NSDF_VERTEX_ON_BORDER) & ((usable & far) | (!usable & (distance != 0)));
    }
    return list_chosen(b);
}

/* Brings the vertices whose edge has ends of both signs to the front of the list; returns how many.  Of the others the
 * sign changes between an end and the corner behind it: they get that end. */
static uint32_t sort_out(const batch *b, uint32_t count) {
    nsdf_mesher_scratch *s = b->s;
    uint32_t front = 0;
    evaluate_edges(b, s->list, count, AT_LOW);
    for (uint32_t i = 0; i < count; i++)
        s->inside[s->list[i]] = s->value[i] < 0;
    evaluate_edges(b, s->list, count, AT_HIGH);
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t v = s->list[i];
        if ((s->value[i] < 0) == s->inside[v])
            continue;
        s->list[i] = s->list[front];
        s->list[front++] = v;
    }
    evaluate_edges(b, s->list + front, count - front, AT_CORNER);
    for (uint32_t i = front; i < count; i++) {
        const uint32_t v = s->list[i];
        if ((s->value[i - front] < 0) != s->inside[v])
            s->high[v] = s->low[v];
        else
            s->low[v] = s->high[v];
    }
    return front;
}

static void halve(const batch *b) {
    nsdf_mesher_scratch *s = b->s;
    const uint32_t n = list_left(b);
    for (uint32_t i = 0; i < n; i++)
        find_edge(b, s->list[i]);
    const uint32_t changing = n > 0 ? sort_out(b, n) : 0;
    for (int k = 0; changing > 0 && k < HALVINGS; k++) {
        evaluate_edges(b, s->list, changing, AT_MIDDLE);
        for (uint32_t i = 0; i < changing; i++) {
            const uint32_t v = s->list[i];
            *((s->value[i] < 0) == s->inside[v] ? &s->low[v] : &s->high[v]) = s->point[s->axis[v]][i];
        }
    }
    for (uint32_t i = 0; i < n; i++) {
        const uint32_t v = s->list[i];
        for (int a = 0; a < 3; a++)
            s->position[a][v] = s->start[a][v];
        s->position[s->axis[v]][v] = 0.5f * (s->low[v] + s->high[v]);
        s->travel[v] = INFINITY; /* its normal is made anew */
    }
}

/* ---- Batches ----------------------------------------------------------------------------------------------- */

static void load(const batch *b) {
    nsdf_mesher_scratch *s = b->s;
    const float *position = b->mesher->storage->positions + 3 * (size_t)b->first;
    for (uint32_t v = 0; v < b->count; v++) {
        for (int a = 0; a < 3; a++)
            s->position[a][v] = s->start[a][v] = position[3 * v + (uint32_t)a];
        s->damping[v] = 1;
        s->travel[v] = s->distance[v] = 0;
    }
}

static uint32_t list_free(const batch *b, float least_travel) {
    uint32_t n = 0;
    for (uint32_t v = 0; v < b->count; v++)
        if (b->loose[v] != NSDF_VERTEX_ON_BORDER && b->s->travel[v] >= least_travel)
            b->s->list[n++] = v;
    return n;
}

static void store_normals(const batch *b, uint8_t *loose) {
    const nsdf_mesher_scratch *s = b->s;
    float *normal = b->mesher->storage->normals + 3 * (size_t)b->first;
    for (uint32_t v = 0; v < b->count; v++, normal += 3) {
        const float square = loose[v] == NSDF_VERTEX_ON_BORDER ? 0 : squared_gradient(s, v);
        const int usable = gradient_is_usable(square);
        if (!usable && loose[v] == 0)
            loose[v] = NSDF_VERTEX_NO_GRADIENT;
        const float factor = usable ? 1 / sqrtf(square) : 0;
        for (int a = 0; a < 3; a++)
            normal[a] = usable ? factor * s->gradient[a][v] : 0;
    }
}

static void store_positions(const batch *b) {
    const nsdf_mesher_job *job = b->mesher->job;
    float *position = b->mesher->storage->positions + 3 * (size_t)b->first;
    for (uint32_t v = 0; v < b->count; v++)
        for (uint32_t a = 0; a < 3; a++)
            position[3 * v + a] = (float)((double)b->s->position[a][v] * job->scale + job->centre[a]);
}

static void finish_batch(void *data, uint32_t index, uint32_t worker) {
    nsdf_mesher *mesher = data;
    const nsdf_mesher_job *job = mesher->job;
    const uint32_t first = index * NSDF_MESHER_BATCH;
    uint8_t *loose = (uint8_t *)mesher->loose.data + first;
    const batch b = {mesher,
                     (nsdf_mesher_scratch *)mesher->scratch.data + worker,
                     worker,
                     first,
                     nsdf_min_u32(mesher->storage->vertex_count - first, NSDF_MESHER_BATCH),
                     loose};
    load(&b);
    if (job->projection > 0 || job->normals)
        evaluate_gradients(&b, list_free(&b, 0));
    project(&b);
    if (job->projection > 0)
        halve(&b);
    if (job->normals) {
        evaluate_gradients(&b, list_free(&b, stale_travel * (float)mesher->grid.step));
        store_normals(&b, loose);
    }
    store_positions(&b);
}

/* ---- Normals from the faces -------------------------------------------------------------------------------- */

/* Adds a triangle's normal, as long as twice its area, to those of its vertices that have none from the field. */
static void add_face_normal(nsdf_mesh_storage *storage, const uint8_t *loose, const uint32_t triangle[3]) {
    const float *p = storage->positions + 3 * (size_t)triangle[0];
    const float *q = storage->positions + 3 * (size_t)triangle[1];
    const float *r = storage->positions + 3 * (size_t)triangle[2];
    float u[3], w[3];
    for (int a = 0; a < 3; a++) {
        u[a] = q[a] - p[a];
        w[a] = r[a] - p[a];
    }
    const float n[3] = {u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]};
    for (int k = 0; k < 3; k++)
        for (int a = 0; a < 3 && loose[triangle[k]]; a++)
            storage->normals[3 * (size_t)triangle[k] + (size_t)a] += n[a];
}

static void make_face_normals(nsdf_mesh_storage *storage, const uint8_t *loose) {
    if (!storage->vertex_count || !memchr(loose, NSDF_VERTEX_ON_BORDER, storage->vertex_count)) {
        if (!storage->vertex_count || !memchr(loose, NSDF_VERTEX_NO_GRADIENT, storage->vertex_count))
            return;
    }
    for (uint32_t i = 0; i < storage->triangle_count; i++)
        add_face_normal(storage, loose, storage->indices + 3 * (size_t)i);
    for (uint32_t v = 0; v < storage->vertex_count; v++) {
        if (!loose[v])
            continue;
        float *n = storage->normals + 3 * (size_t)v;
        const float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        const int usable = length > 0 && length < INFINITY;
        for (int a = 0; a < 3; a++)
            n[a] = usable ? n[a] / length : (float)(a == 2);
    }
}

nsdf_status nsdf_mesher_finish_vertices(nsdf_mesher *mesher) {
    nsdf_mesh_storage *storage = mesher->storage;
    const uint64_t batches = ((uint64_t)storage->vertex_count + NSDF_MESHER_BATCH - 1) / NSDF_MESHER_BATCH;
    mesher->slice = 1 + mesher->slice / 8; /* a batch is evaluated several times here, with gradients */
    const nsdf_status status = nsdf_mesher_parallel(mesher, batches, finish_batch);
    if (status != NSDF_OK)
        return status;
    if (mesher->job->normals)
        make_face_normals(storage, mesher->loose.data);
    storage->has_normals = mesher->job->normals != 0;
    return NSDF_OK;
}
