#include "block_batch.h"

#include <stdlib.h>
#include <string.h>

/* Cells along x of which batches know together where their points begin: a ball reaches into one or two such spans, and
 * what it finds in them beside its own points is a vector or two. */
enum { SPAN = 32 };

static size_t rows_of(const nsdf_block_frame *f) {
    return (size_t)f->cells[1] * f->cells[2];
}

static size_t cells_of(const nsdf_block_frame *f) {
    return (size_t)f->cells[0] * rows_of(f);
}

static uint32_t spans_in_row(const nsdf_block_frame *f) {
    return (f->cells[0] + SPAN - 1) / SPAN;
}

size_t nsdf_block_batch_spans(const nsdf_block_frame *frame) {
    return rows_of(frame) * spans_in_row(frame) + 1;
}

/* ---- Memory ---------------------------------------------------------------------------------------------- */

int nsdf_block_work_create(nsdf_block_work *w, uint32_t points, uint32_t blocks, const nsdf_block_frame *frame) {
    const size_t n = (size_t)points + NSDF_HIT_LANES;
    memset(w, 0, sizeof *w);
    w->cell = malloc(n * sizeof *w->cell);
    w->start = malloc((cells_of(frame) + 2) * sizeof *w->start);
    w->sum = malloc(n * sizeof *w->sum);
    w->first = calloc((size_t)blocks + 1, sizeof *w->first);
    w->kept_first = calloc((size_t)blocks + 1, sizeof *w->kept_first);
    if (w->cell && w->start && w->sum && w->first && w->kept_first)
        return 0;
    nsdf_block_work_free(w);
    return -1;
}

void nsdf_block_work_free(nsdf_block_work *w) {
    free(w->cell);
    free(w->start);
    free(w->sum);
    free(w->first);
    free(w->kept);
    free(w->kept_first);
    free(w->point);
    for (int i = 0; i < NSDF_HIT_ARRAYS; i++)
        free(w->hit[i]);
    memset(w, 0, sizeof *w);
}

int nsdf_block_batch_create(nsdf_block_batch *b, uint32_t points, uint32_t blocks, const nsdf_block_frame *frame) {
    memset(b, 0, sizeof *b);
    b->point = calloc((size_t)points + NSDF_HIT_LANES, sizeof *b->point);
    b->span = calloc(nsdf_block_batch_spans(frame), sizeof *b->span);
    b->first = calloc((size_t)blocks + 1, sizeof *b->first);
    b->listed = calloc(blocks, sizeof *b->listed);
    if (b->point && b->span && b->first && b->listed)
        return 0;
    nsdf_block_batch_free(b);
    return -1;
}

void nsdf_block_batch_free(nsdf_block_batch *b) {
    free(b->point);
    free(b->span);
    free(b->first);
    free(b->near);
    free(b->listed);
    memset(b, 0, sizeof *b);
}

static int need_candidates(nsdf_block_batch *b, size_t count) {
    if (count <= b->near_capacity)
        return 0;
    const size_t capacity = count + count / 8;
    uint16_t *near = realloc(b->near, capacity * sizeof *near);
    if (!near)
        return -1;
    b->near = near;
    b->near_capacity = capacity;
    return 0;
}

static int need_hits(nsdf_block_work *w, size_t count) {
    int ok = 1;
    if (count <= w->hit_capacity)
        return 0;
    const size_t capacity = count + count / 2;
    uint32_t *point = realloc(w->point, capacity * sizeof *point);
    ok &= point != NULL;
    w->point = point ? point : w->point;
    for (int i = 0; i < NSDF_HIT_ARRAYS; i++) {
        float *hit = realloc(w->hit[i], capacity * sizeof *hit);
        ok &= hit != NULL;
        w->hit[i] = hit ? hit : w->hit[i];
    }
    w->hit_capacity = ok ? capacity : w->hit_capacity;
    return ok ? 0 : -1;
}

/* ---- Points in the order of cells ------------------------------------------------------------------------ */

static uint32_t cell_along(const nsdf_block_frame *f, float x, int axis) {
    const float at = (x - f->low[axis]) * f->inverse_cell;
    return !(at > 0.0f) ? 0 : at >= (float)f->cells[axis] ? f->cells[axis] - 1 : (uint32_t)at;
}

static uint32_t cell_at(const nsdf_block_frame *f, float x, float y, float z) {
    return (cell_along(f, z, 2) * f->cells[1] + cell_along(f, y, 1)) * f->cells[0] + cell_along(f, x, 0);
}

/* Counting sort; cells are counted two places ahead and summed one place ahead, so that storing moves every start to
 * where it belongs. */
void nsdf_block_batch_fill(nsdf_block_batch *b, nsdf_block_work *w, const nsdf_block_frame *f,
                           const nsdf_sample_set *samples, size_t from, size_t stride, uint32_t wanted) {
    const size_t cells = cells_of(f);
    memset(w->start, 0, (cells + 2) * sizeof *w->start);
    b->count = 0;
    for (size_t i = from; i < samples->count && b->count < wanted; i += stride) {
        const uint32_t cell = cell_at(f, samples->x[i], samples->y[i], samples->z[i]);
        w->cell[b->count++] = cell;
        w->start[cell + 2]++;
    }
    for (size_t c = 0; c < cells; c++)
        w->start[c + 2] += w->start[c + 1];
    for (size_t row = 0, at = 0; row < rows_of(f); row++)
        for (uint32_t x = 0; x < f->cells[0]; x += SPAN)
            b->span[at++] = w->start[row * f->cells[0] + x + 1];
    b->span[nsdf_block_batch_spans(f) - 1] = b->count;
    for (uint32_t n = 0; n < b->count; n++) {
        const size_t i = from + n * stride;
        float *to = b->point[w->start[w->cell[n] + 1]++];
        to[0] = samples->x[i];
        to[1] = samples->y[i];
        to[2] = samples->z[i];
        to[3] = samples->d[i];
    }
}

/* ---- Candidates ------------------------------------------------------------------------------------------ */

/* Spans of a row hold their points side by side. */
static int list_block(nsdf_block_batch *b, const nsdf_block_passes *passes, const nsdf_block_frame *f,
                      const float map[12], const float reach[6], float margin, size_t *at) {
    const float least = 1.0f - (1.0f + margin) * (1.0f + margin);
    uint32_t first[3], last[3];
    for (int axis = 0; axis < 3; axis++) {
        const float more = 0.5f * margin * (reach[3 + axis] - reach[axis]);
        first[axis] = cell_along(f, reach[axis] - more, axis);
        last[axis] = cell_along(f, reach[3 + axis] + more, axis);
    }
    for (uint32_t z = first[2]; z <= last[2]; z++)
        for (uint32_t y = first[1]; y <= last[1]; y++) {
            const uint32_t *span = b->span + (z * f->cells[1] + y) * spans_in_row(f);
            const uint32_t from = span[first[0] / SPAN], to = span[last[0] / SPAN + 1];
            if (from >= to)
                continue;
            if (need_candidates(b, *at + (to - from) + NSDF_HIT_LANES) != 0)
                return -1;
            *at = passes->list(b, map, least, from, to, *at);
        }
    return 0;
}

/* Sets the candidates aside, so that those of some blocks can be found anew between the others'. */
static int keep_candidates(const nsdf_block_batch *b, nsdf_block_work *w, uint32_t blocks) {
    const size_t count = b->first[blocks];
    if (count > w->kept_capacity) {
        uint16_t *kept = realloc(w->kept, 2 * count * sizeof *kept);
        if (!kept)
            return -1;
        w->kept = kept;
        w->kept_capacity = 2 * count;
    }
    memcpy(w->kept_first, b->first, ((size_t)blocks + 1) * sizeof *b->first);
    if (count > 0)
        memcpy(w->kept, b->near, count * sizeof *b->near);
    return 0;
}

static int take_back(nsdf_block_batch *b, const nsdf_block_work *w, uint32_t block, size_t *at) {
    const size_t from = w->kept_first[block], count = w->kept_first[block + 1] - from;
    if (need_candidates(b, *at + count + NSDF_HIT_LANES) != 0)
        return -1;
    if (count > 0)
        memcpy(b->near + *at, w->kept + from, count * sizeof *b->near);
    *at += count;
    return 0;
}

int nsdf_block_batch_list(nsdf_block_batch *b, nsdf_block_work *w, const nsdf_block_passes *passes,
                          const nsdf_block_frame *frame, const float (*map)[12], const float (*reach)[6],
                          const uint32_t *stamp, uint32_t blocks, float margin) {
    size_t at = 0;
    if (need_candidates(b, NSDF_HIT_LANES) != 0 || (stamp && keep_candidates(b, w, blocks) != 0))
        return -1;
    for (uint32_t k = 0; k < blocks; k++) {
        const int kept = stamp && b->listed[k] == stamp[k];
        b->first[k] = (uint32_t)at;
        if (!frame->alive[k])
            continue;
        if (kept ? take_back(b, w, k, &at) : list_block(b, passes, frame, map[k], reach[k], margin, &at))
            return -1;
        if (stamp)
            b->listed[k] = stamp[k];
    }
    b->first[blocks] = (uint32_t)at;
    memset(b->near + at, 0, NSDF_HIT_LANES * sizeof *b->near); /* for vectors that reach beyond the last */
    return 0;
}

/* ---- Hits ------------------------------------------------------------------------------------------------ */

int nsdf_block_batch_forward(nsdf_block_work *w, const nsdf_block_batch *b, const nsdf_block_passes *passes,
                             const nsdf_block_frame *frame, const float (*terms)[NSDF_BLOCK_MOST_TERMS],
                             uint32_t blocks, uint32_t degree) {
    const size_t room = b->first[blocks] + 2 * NSDF_HIT_LANES * ((size_t)blocks + 1);
    uint32_t at = 0;
    if (need_hits(w, room) != 0)
        return -1;
    memset(w->sum, 0, ((size_t)b->count + NSDF_HIT_LANES) * sizeof *w->sum);
    for (uint32_t k = 0; k < blocks; k++) {
        w->first[k] = at;
        at = passes->find(w, b, k, frame->map[k], at);
        w->first[k + 1] = at;
        passes->forward(w, k, degree, terms[k]);
    }
    return 0;
}
