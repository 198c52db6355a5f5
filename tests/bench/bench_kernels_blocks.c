/* The encoder's blocks: a thousand balls on a sphere, batches of samples around it, the passes of a step.  Operations
 * are those of the formulas at points that a ball holds: finding them, values and gradients. */
#include <math.h>
#include <string.h>

#include "bench_kernels.h"
#include "block_batch.h"
#include "nsdf/encoder.h"
#include "random.h"

/* A step of the encoder is eight batches of 4096 points. */
enum { BLOCKS = 1000, POINTS = 4096, BATCHES = 8, DEGREE = 2, CELLS = 32 };

static const float sphere = 0.3f, ball = 0.0424f; /* radii: five balls hold a point of the surface */
static const float margin = 0.12f;                /* of candidates, as block_cache.c has it */

/* Operations at one point in one ball: u and |u|^2; the value, its weight and their sums; monomials, slopes of the
 * polynomial, and sums of the gradients. */
enum { FIND_FLOP = 18 + 6, FORWARD_FLOP = 6 + 15 + 4, BACKWARD_FLOP = 19 + 18 + 4 + 9 + 3 + 18 };
/* And once at each point: two quotients, the weight, the gradient. */
enum { LOSS_FLOP = 8 };

typedef struct balls {
    nsdf_block_frame frame;
    float map[BLOCKS][12], pose[BLOCKS][12], reach[BLOCKS][6], terms[BLOCKS][NSDF_BLOCK_MOST_TERMS];
    uint8_t alive[BLOCKS];
} balls;

typedef struct subject {
    const balls *balls;
    const nsdf_block_passes *passes;
    nsdf_block_batch batch[BATCHES];
    nsdf_block_work work[BATCHES];
    double hits, points;
} subject;

/* ---- Balls and samples ------------------------------------------------------------------------------------- */

static void on_sphere(nsdf_random *random, float radius, float p[3]) {
    float length = 0.0f;
    for (int k = 0; k < 3; k++) {
        p[k] = nsdf_random_normal(random);
        length += p[k] * p[k];
    }
    for (int k = 0; k < 3; k++)
        p[k] *= radius / sqrtf(length);
}

/* A spiral spreads the centres evenly. */
static void centre_of(uint32_t k, float c[3]) {
    const float z = 1.0f - (2.0f * (float)k + 1.0f) / BLOCKS, across = sqrtf(1.0f - z * z);
    const float angle = 2.39996323f * (float)k;
    c[0] = sphere * across * cosf(angle);
    c[1] = sphere * across * sinf(angle);
    c[2] = sphere * z;
}

static balls *create_balls(void) {
    balls *b = bench_allocate_zeroed(1, sizeof *b);
    nsdf_random random = nsdf_random_start(1, 1);
    for (uint32_t k = 0; k < BLOCKS; k++) {
        float c[3];
        centre_of(k, c);
        for (int row = 0; row < 3; row++) {
            b->pose[k][4 * row + row] = 1.0f;
            b->pose[k][4 * row + 3] = c[row];
            b->map[k][4 * row + row] = 1.0f / ball;
            b->map[k][4 * row + 3] = -c[row] / ball;
            b->reach[k][row] = c[row] - ball;
            b->reach[k][3 + row] = c[row] + ball;
        }
        for (int t = 0; t < 10; t++)
            b->terms[k][t] = 0.1f * (nsdf_random_unit(&random) - 0.5f);
        b->alive[k] = 1;
    }
    b->frame = (nsdf_block_frame){
        b->map, b->pose, b->terms, b->reach, b->alive, NULL, NULL, {-0.5f, -0.5f, -0.5f}, CELLS, {CELLS, CELLS, CELLS}};
    return b;
}

/* As block fitting draws them: displaced by 0.002, 0.006 and half a ball (35 : 30 : 30), and a few anywhere. */
static void draw_samples(nsdf_sample_set *set, uint64_t seed) {
    nsdf_random random = nsdf_random_start(seed, 2);
    set->x = bench_floats(POINTS);
    set->y = bench_floats(POINTS);
    set->z = bench_floats(POINTS);
    set->d = bench_floats(POINTS);
    set->count = POINTS;
    for (uint32_t i = 0; i < POINTS; i++) {
        const float kind = nsdf_random_unit(&random);
        const float noise = kind < 0.35f ? 0.002f : kind < 0.65f ? 0.006f : kind < 0.95f ? 0.5f * ball : 0.2f;
        float p[3];
        set->d[i] = noise * nsdf_random_normal(&random);
        on_sphere(&random, sphere + set->d[i], p);
        set->x[i] = p[0];
        set->y[i] = p[1];
        set->z[i] = p[2];
    }
}

static int forward(subject *s, int i) {
    return nsdf_block_batch_forward(&s->work[i], &s->batch[i], s->passes, &s->balls->frame, s->balls->terms, BLOCKS,
                                    DEGREE);
}

static subject *create_subject(const balls *b, const nsdf_block_passes *passes) {
    subject *s = bench_allocate_zeroed(1, sizeof *s);
    s->balls = b;
    s->passes = passes;
    for (int i = 0; i < BATCHES; i++) {
        nsdf_sample_set set;
        draw_samples(&set, (uint64_t)i);
        if (nsdf_block_work_create(&s->work[i], POINTS, BLOCKS, &b->frame) != 0 ||
            nsdf_block_batch_create(&s->batch[i], POINTS, BLOCKS, &b->frame) != 0)
            bench_checked(NULL);
        nsdf_block_batch_fill(&s->batch[i], &s->work[i], &b->frame, &set, 0, 1, POINTS);
        nsdf_sample_set_free(&set);
        if (nsdf_block_batch_list(&s->batch[i], &s->work[i], passes, &b->frame, b->map, b->reach, NULL, BLOCKS,
                                  margin) != 0 ||
            forward(s, i) != 0)
            bench_checked(NULL);
        for (uint32_t h = 0; h < s->work[i].first[BLOCKS]; h++)
            s->hits += s->work[i].point[h] < POINTS;
        s->points += POINTS;
    }
    return s;
}

/* ---- Calls ------------------------------------------------------------------------------------------------- */

static void run_find(void *data) {
    subject *s = data;
    for (int i = 0; i < BATCHES; i++)
        for (uint32_t k = 0; k < BLOCKS; k++)
            s->work[i].first[k + 1] =
                s->passes->find(&s->work[i], &s->batch[i], k, s->balls->map[k], s->work[i].first[k]);
}

static void run_values(void *data) {
    subject *s = data;
    for (int i = 0; i < BATCHES; i++) {
        memset(s->work[i].sum, 0, POINTS * sizeof *s->work[i].sum);
        for (uint32_t k = 0; k < BLOCKS; k++)
            s->passes->forward(&s->work[i], k, DEGREE, s->balls->terms[k]);
    }
}

static void run_gradients(void *data) {
    subject *s = data;
    nsdf_block_gradient sums;
    for (int i = 0; i < BATCHES; i++)
        for (uint32_t k = 0; k < BLOCKS; k++)
            s->passes->backward(&s->work[i], k, DEGREE, s->balls->terms[k], &sums);
}

/* One worker's memory for all batches, as in fitting. */
static void run_all(void *data) {
    subject *s = data;
    const nsdf_block_loss loss = {1e-4f, 0.005f, 0.25f, 0.01f};
    nsdf_block_gradient sums;
    for (int i = 0; i < BATCHES; i++) {
        nsdf_block_work *w = &s->work[0];
        if (nsdf_block_batch_forward(w, &s->batch[i], s->passes, &s->balls->frame, s->balls->terms, BLOCKS, DEGREE) !=
            0)
            bench_checked(NULL);
        s->passes->differentiate(w, &s->batch[i], &loss);
        for (uint32_t k = 0; k < BLOCKS; k++)
            s->passes->backward(w, k, DEGREE, s->balls->terms[k], &sums);
    }
    forward(s, 0); /* what the other cases expect */
}

/* ---- Cases ------------------------------------------------------------------------------------------------- */

static void add_set(kernels_list *list, const balls *b, bench_isa isa, const nsdf_block_passes *passes) {
    subject *s = create_subject(b, passes);
    const double flop[] = {FIND_FLOP * s->hits, FORWARD_FLOP * s->hits, BACKWARD_FLOP * s->hits};
    const kernels_entry all = {
        "blocks", isa, KERNELS_FLOP, flop[0] + flop[1] + flop[2] + LOSS_FLOP * s->points, s->hits, "hits", -1};
    kernels_entry part = {"blocks", isa, KERNELS_FLOP, flop[0], s->hits, "hits", -1};
    kernels_add(list, &all, "all passes", run_all, s);
    kernels_add(list, &part, "find", run_find, s);
    part.work = flop[1];
    kernels_add(list, &part, "forward", run_values, s);
    part.work = flop[2];
    kernels_add(list, &part, "backward", run_gradients, s);
}

void kernels_add_blocks(kernels_list *list) {
    const nsdf_block_passes *const sets[BENCH_ISA_COUNT] = {nsdf_block_passes_generic(), nsdf_block_passes_avx2(),
                                                            nsdf_block_passes_avx512()};
    const balls *b = create_balls();
    for (int isa = BENCH_ISA_COUNT - 1; isa >= 0; isa--)
        if (sets[isa] && bench_isa_is_here((bench_isa)isa))
            add_set(list, b, (bench_isa)isa, sets[isa]);
}
