/* The encoder's networks: forward and backward pass with the gradients of all parameters, as a step does them, and the
 * kernels alone.  Only the operations of matrix products count. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench_kernels.h"
#include "bench_network.h"
#include "fit_network.h"

/* A slot of the encoder's step, in tiles of so many panels. */
enum { POINTS = 1024, TILE_PANELS = 16, LAYERS = 3, FRAMES = 48, MOST_SUBJECTS = 16 };

static const uint32_t widths[] = {16, 32, 64, 80, 96, 128};
enum { WIDTHS = sizeof widths / sizeof *widths };

typedef struct subject {
    nsdf_model model;
    const nsdf_fit_kernels *kernels;
    nsdf_fit_scratch *scratch;
    float *composed, *gradient;
    float *x, *y, *z, *d;                  /* [POINTS] */
    float *input, *output, *values, *grad; /* [TILE_PANELS][width + 1][NSDF_PANEL]; [width][width + 1] */
    uint32_t width;
} subject;

static subject *create_subject(uint32_t width, const nsdf_fit_kernels *kernels) {
    subject *s = bench_allocate_zeroed(1, sizeof *s);
    const size_t matrix = (size_t)TILE_PANELS * (width + 1) * NSDF_PANEL;
    s->composed = bench_network(&s->model, LAYERS, width, FRAMES);
    s->gradient = bench_floats(s->model.composed_size);
    s->x = bench_random_floats(POINTS, 0.5f, 3);
    s->y = bench_random_floats(POINTS, 0.5f, 4);
    s->z = bench_random_floats(POINTS, 0.5f, 5);
    s->d = bench_random_floats(POINTS, 0.05f, 6);
    s->input = bench_random_floats(matrix, 1.0f, 7);
    s->output = bench_random_floats(matrix, 1.0f, 8);
    s->values = bench_random_floats((size_t)width * (width + 1), 0.1f, 9);
    s->grad = bench_floats((size_t)width * (width + 1));
    s->scratch = bench_checked(nsdf_fit_scratch_create(&s->model));
    s->kernels = kernels;
    s->width = width;
    return s;
}

/* Forward, gradients of weights and biases, and gradients of the inputs of all layers but the first. */
static double flop_a_sample(const nsdf_model *model) {
    double sum = 0;
    for (uint32_t l = 0; l < model->desc.layer_count; l++) {
        const double in = nsdf_layer_inputs(model, l), out = model->desc.layers[l].width;
        sum += 2 * 2 * out * (in + 1) + (l > 0 ? 2 * out * in : 0);
    }
    return sum;
}

/* ---- Calls ------------------------------------------------------------------------------------------------- */

static void run_fit(void *data) {
    subject *s = data;
    const nsdf_fit_points points = {s->x, s->y, s->z, s->d, POINTS, 0.0f};
    const nsdf_loss_params loss = {NSDF_LOSS_WEIGHTED_MAE, 0.02f, 0.01f, 1.0f, 1.0f};
    nsdf_fit_sums sums = {0, 0, 0};
    nsdf_fit_backward(&s->model, s->kernels, s->scratch, s->composed, &points, &loss, 1e-4f, s->gradient, NULL, &sums);
}

static void run_multiply(void *data) {
    subject *s = data;
    const size_t panel = (size_t)(s->width + 1) * NSDF_PANEL;
    s->kernels->multiply_short(s->values, s->width + 1, s->width, s->width + 1, s->input, panel, s->output, panel,
                               TILE_PANELS);
}

static void run_outer(void *data) {
    subject *s = data;
    const size_t panel = (size_t)(s->width + 1) * NSDF_PANEL;
    s->kernels->outer_short(s->output, panel, s->width, s->input, panel, s->width + 1, s->grad, s->width + 1,
                            TILE_PANELS);
}

/* ---- Cases ------------------------------------------------------------------------------------------------- */

static void add_width(kernels_list *list, uint32_t width, const nsdf_fit_kernels *kernels, bench_isa isa, int alone) {
    subject *s = create_subject(width, kernels);
    const int exact = kernels->multiply_short == kernels->multiply;
    const char *factors = exact ? "" : kernels == nsdf_fit_kernels_bf16() ? ", bf16" : ", bf16 tiles";
    const double product = 2.0 * width * (width + 1) * TILE_PANELS * NSDF_PANEL;
    const kernels_entry fit = {"fit", isa, KERNELS_FLOP, POINTS * flop_a_sample(&s->model), POINTS, "samples", -1};
    const kernels_entry kernel = {"fit", isa, KERNELS_FLOP, product, 0.0, "", -1};
    char name[48];
    snprintf(name, sizeof name, "3 x %u%s: all passes", (unsigned)width, factors);
    kernels_add(list, &fit, name, run_fit, s);
    if (!alone)
        return;
    snprintf(name, sizeof name, "product %u wide%s", (unsigned)width, factors);
    kernels_add(list, &kernel, name, run_multiply, s);
    snprintf(name, sizeof name, "outer product %u wide%s", (unsigned)width, factors);
    kernels_add(list, &kernel, name, run_outer, s);
}

static void add_widths(kernels_list *list, const nsdf_fit_kernels *kernels, bench_isa isa) {
    const int best = isa == bench_isa_best();
    for (int i = 0; i < WIDTHS; i++)
        if (!list->quick || widths[i] == 64)
            add_width(list, widths[i], kernels, isa, best && (widths[i] == 64 || widths[i] == 128));
}

void kernels_add_fit(kernels_list *list) {
    const nsdf_fit_kernels *const sets[BENCH_ISA_COUNT] = {nsdf_fit_kernels_generic(), nsdf_fit_kernels_avx2(),
                                                           nsdf_fit_kernels_avx512()};
    const nsdf_fit_kernels *short_sets[NSDF_FIT_SHORT_SETS];
    const uint32_t shorts = nsdf_fit_kernels_list_short(short_sets);
    for (uint32_t i = 0; i < shorts; i++)
        add_widths(list, short_sets[i], BENCH_ISA_AVX512);
    for (int isa = BENCH_ISA_COUNT - 1; isa >= 0; isa--)
        if (sets[isa] && bench_isa_is_here((bench_isa)isa))
            add_widths(list, sets[isa], (bench_isa)isa);
}
