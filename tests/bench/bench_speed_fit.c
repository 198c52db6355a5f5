/* Fitting: samples a second of forward and backward pass with gradients of all parameters, and the same in
 * floating-point operations beside what the machine can do.  Only the operations of matrix products count. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench_peak.h"
#include "bench_speed.h"
#include "bench_network.h"
#include "fit_network.h"

/* A step of the encoder: eight frames of 1024 points, each frame a task, worked off in tiles of so many panels. */
enum { SLOTS = 8, POINTS = 1024, TILE_PANELS = 16, LAYERS = 3, FRAMES = 48 };
/* The default width, at which instruction sets are compared. */
enum { COMPARED_WIDTH = 80 };
enum { MOST_WORKERS = 8, MOST_CASES = 64 };

static const char section[] = "fit";

/* A network, and memory to fit it. */
typedef struct subject {
    nsdf_model model;
    float *composed, *gradient; /* [composed_size]; [SLOTS][composed_size] */
    float *x, *y, *z, *d;       /* [POINTS] */
    nsdf_fit_scratch *scratch[MOST_WORKERS];
    uint32_t workers;
} subject;

/* Fitting, or one kernel on the widest layer and as many panels as the encoder gives it at once. */
typedef struct job {
    subject *subject;
    const nsdf_fit_kernels *kernels;
    nsdf_workers *team;
    float *a, *b, *matrix; /* [TILE_PANELS][width + 1][NSDF_PANEL], the same, [width][width + 1] */
    uint32_t width;
    bench_isa isa;
    double flop;    /* of a call */
    double samples; /* of a call; 0 for a kernel alone */
} job;

typedef struct bench {
    const bench_speed_options *options;
    nsdf_workers *team[BENCH_TEAMS];
    bench_peak *peak[BENCH_TEAMS];
    bench_case cases[MOST_CASES];
    job jobs[MOST_CASES];
    subject *subjects[8];
    uint32_t count, subject_count;
} bench;

/* ---- What is fitted ---------------------------------------------------------------------------------------- */

static subject *create_subject(uint32_t width, uint32_t workers) {
    subject *s = bench_allocate_zeroed(1, sizeof *s);
    s->composed = bench_network(&s->model, LAYERS, width, FRAMES);
    s->gradient = bench_floats(SLOTS * s->model.composed_size);
    s->x = bench_random_floats(POINTS, 0.5f, 3);
    s->y = bench_random_floats(POINTS, 0.5f, 4);
    s->z = bench_random_floats(POINTS, 0.5f, 5);
    s->d = bench_random_floats(POINTS, 0.05f, 6);
    s->workers = workers;
    for (uint32_t i = 0; i < workers; i++)
        s->scratch[i] = bench_checked(nsdf_fit_scratch_create(&s->model));
    return s;
}

static void free_subject(subject *s) {
    for (uint32_t i = 0; i < s->workers; i++)
        nsdf_fit_scratch_free(s->scratch[i]);
    free(s->composed);
    free(s->gradient);
    free(s->x);
    free(s->y);
    free(s->z);
    free(s->d);
    free(s);
}

/* Forward, gradients of the weights and biases, and gradients of the inputs of all layers but the first. */
static double flop_a_sample(const nsdf_model *model) {
    double sum = 0;
    for (uint32_t l = 0; l < model->desc.layer_count; l++) {
        const double in = nsdf_layer_inputs(model, l), out = model->desc.layers[l].width;
        sum += 2 * 2 * out * (in + 1) + (l > 0 ? 2 * out * in : 0);
    }
    return sum;
}

/* ---- Calls ------------------------------------------------------------------------------------------------- */

static void fit_slot(void *data, uint32_t index, uint32_t worker) {
    const job *j = data;
    const subject *s = j->subject;
    const nsdf_fit_points points = {s->x, s->y, s->z, s->d, POINTS, 0.0f};
    const nsdf_loss_params loss = {NSDF_LOSS_WEIGHTED_MAE, 0.02f, 0.01f, 1.0f, 1.0f};
    nsdf_fit_sums sums = {0, 0, 0};
    nsdf_fit_backward(&s->model, j->kernels, s->scratch[worker], s->composed, &points, &loss, 1e-4f,
                      s->gradient + index * s->model.composed_size, NULL, &sums);
}

static void run_fit(void *data) {
    job *j = data;
    nsdf_workers_run(j->team, SLOTS, fit_slot, j);
}

static void run_multiply(void *data) {
    const job *j = data;
    const size_t panel = (size_t)(j->width + 1) * NSDF_PANEL;
    j->kernels->multiply_short(j->matrix, j->width + 1, j->width, j->width + 1, j->a, panel, j->b, panel, TILE_PANELS);
}

/* As the gradient of a layer's inputs is made: with the transposed matrix, which has no column of biases. */
static void run_transposed(void *data) {
    const job *j = data;
    const size_t panel = (size_t)(j->width + 1) * NSDF_PANEL;
    j->kernels->multiply_short(j->matrix, j->width, j->width, j->width, j->a, panel, j->b, panel, TILE_PANELS);
}

static void run_outer(void *data) {
    const job *j = data;
    const size_t panel = (size_t)(j->width + 1) * NSDF_PANEL;
    j->kernels->outer_short(j->b, panel, j->width, j->a, panel, j->width + 1, j->matrix, j->width + 1, TILE_PANELS);
}

/* The values stay small: sin(sin(...)). */
static void run_sine(void *data) {
    const job *j = data;
    j->kernels->sine(j->b, j->a, (size_t)TILE_PANELS * j->width * NSDF_PANEL, 1.0f);
}

/* ---- The list of cases ------------------------------------------------------------------------------------- */

static job *add_case(bench *b, const char *measure, uint32_t threads, void (*run)(void *data)) {
    job *j = &b->jobs[b->count];
    bench_case *timed = &b->cases[b->count++];
    *timed = (bench_case){"", threads, run, j, 0, 0, 0, 0};
    snprintf(timed->measure, sizeof timed->measure, "%s", measure);
    return j;
}

static void add_sgemm(bench *b, int team) {
    bench_case timed;
    const double flop = bench_peak_sgemm_case(b->peak[team], &timed);
    if (flop <= 0)
        return;
    b->jobs[b->count].flop = flop;
    b->jobs[b->count].isa = bench_isa_best();
    b->cases[b->count++] = timed;
}

static void add_loops(bench *b) {
    for (int t = 0; t < BENCH_TEAMS; t++)
        for (int isa = 0; isa < BENCH_ISA_COUNT; isa++) {
            if (!bench_isa_is_here((bench_isa)isa))
                continue;
            b->jobs[b->count].flop = bench_peak_fma_case(b->peak[t], (bench_isa)isa, &b->cases[b->count]);
            b->jobs[b->count++].isa = (bench_isa)isa;
        }
}

static void add_fit(bench *b, subject *s, uint32_t width, const nsdf_fit_kernels *kernels, int team) {
    char name[48];
    snprintf(name, sizeof name, "fitting %d x %lu %s", LAYERS, (unsigned long)width, kernels->name);
    job *j = add_case(b, name, b->options->threads[team], run_fit);
    j->subject = s;
    j->kernels = kernels;
    j->isa = bench_isa_of_name(kernels->name);
    j->team = b->team[team];
    j->samples = SLOTS * POINTS;
    j->flop = j->samples * flop_a_sample(&s->model);
}

static void add_kernel(bench *b, const char *name, uint32_t width, void (*run)(void *data), double flop) {
    char measure[48];
    snprintf(measure, sizeof measure, "kernel: %s %lu wide", name, (unsigned long)width);
    job *j = add_case(b, measure, 1, run);
    const size_t floats = (size_t)TILE_PANELS * (width + 1) * NSDF_PANEL;
    j->kernels = nsdf_fit_kernels_select();
    j->isa = bench_isa_of_name(j->kernels->name);
    j->width = width;
    j->a = bench_random_floats(floats, 1.0f, 7);
    j->b = bench_random_floats(floats, 1.0f, 8);
    j->matrix = bench_random_floats((size_t)width * (width + 1), 0.1f, 9);
    j->flop = flop;
}

/* The sets that are here but not the first choice, on one thread. */
static void add_other_sets(bench *b, subject *s, uint32_t width) {
    const nsdf_fit_kernels *const sets[BENCH_ISA_COUNT] = {nsdf_fit_kernels_generic(), nsdf_fit_kernels_avx2(),
                                                           nsdf_fit_kernels_avx512()};
    for (int isa = 0; isa < BENCH_ISA_COUNT; isa++)
        if (sets[isa] && bench_isa_is_here((bench_isa)isa) && sets[isa] != nsdf_fit_kernels_select())
            add_fit(b, s, width, sets[isa], 0);
}

static void add_width(bench *b, uint32_t width) {
    subject *s = b->subjects[b->subject_count++] = create_subject(width, nsdf_workers_count(b->team[BENCH_TEAMS - 1]));
    const double square = 2.0 * width * width * TILE_PANELS * NSDF_PANEL, product = square * (width + 1) / width;
    for (int t = 0; t < BENCH_TEAMS; t++)
        add_fit(b, s, width, nsdf_fit_kernels_select(), t);
    if (width == COMPARED_WIDTH)
        add_other_sets(b, s, width);
    add_kernel(b, "multiply", width, run_multiply, product);
    add_kernel(b, "multiply transposed", width, run_transposed, square);
    add_kernel(b, "outer product", width, run_outer, product);
    if (width == COMPARED_WIDTH)
        add_kernel(b, "sine and cosine", width, run_sine, 0.0);
}

/* ---- Rows -------------------------------------------------------------------------------------------------- */

/* Operations a second of the peak with as many threads; 0 when there is none. */
static double peak_of(const bench *b, const char *measure, uint32_t threads) {
    for (uint32_t i = 0; i < b->count; i++)
        if (b->cases[i].threads == threads && strncmp(b->cases[i].measure, measure, strlen(measure)) == 0)
            return b->jobs[i].flop / bench_compared_seconds(&b->cases[i]);
    return 0.0;
}

static void print_case(const bench *b, uint32_t i) {
    const job *j = &b->jobs[i];
    const bench_case *timed = &b->cases[i];
    char loop[48];
    if (j->flop <= 0) {
        bench_row row = bench_rate(section, timed, 1e-9 * TILE_PANELS * NSDF_PANEL * j->width, "Gvalues/s");
        bench_print(&row);
        return;
    }
    const double rate = j->flop / bench_compared_seconds(timed), sgemm = peak_of(b, "OpenBLAS", timed->threads);
    snprintf(loop, sizeof loop, "register loop %s", bench_isa_name(j->isa));
    bench_row row = bench_rate(section, timed, 1e-9 * j->flop, "GFLOP/s");
    row.of_sgemm = sgemm > 0 ? rate / sgemm : 0.0;
    row.of_fma = rate / peak_of(b, loop, timed->threads);
    bench_print(&row);
    if (j->samples > 0) {
        row = bench_rate(section, timed, j->samples, "samples/s");
        bench_print(&row);
    }
}

static void free_bench(bench *b) {
    for (uint32_t i = 0; i < b->count; i++) {
        free(b->jobs[i].a);
        free(b->jobs[i].b);
        free(b->jobs[i].matrix);
    }
    for (uint32_t i = 0; i < b->subject_count; i++)
        free_subject(b->subjects[i]);
    for (int t = 0; t < BENCH_TEAMS; t++) {
        bench_peak_free(b->peak[t]);
        nsdf_workers_free(b->team[t]);
    }
    free(b);
}

int bench_speed_fit(const bench_speed_options *options) {
    bench *b = bench_allocate_zeroed(1, sizeof *b);
    b->options = options;
    for (int t = 0; t < BENCH_TEAMS; t++) {
        b->team[t] = nsdf_workers_create(options->threads[t]);
        b->peak[t] = bench_peak_create(b->team[t], options->sgemm_size);
    }
    /* OpenBLAS's threads go on spinning for a while after their work: next in turn after the last case comes the first,
     * which has one thread and leaves them another core. */
    add_sgemm(b, 0);
    add_loops(b);
    for (const uint32_t *width = options->widths; *width > 0; width++)
        add_width(b, *width);
    add_sgemm(b, BENCH_TEAMS - 1);
    bench_run(&options->plan, b->cases, b->count);
    for (uint32_t i = 0; i < b->count; i++)
        print_case(b, i);
    free_bench(b);
    return 0;
}
