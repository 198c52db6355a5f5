/* Decoding: opening a file, the first frame, frames at several resolutions, and evaluating points. */
#include <stdio.h>
#include <stdlib.h>

#include "bench_frames.h"
#include "bench_peak.h"
#include "bench_points.h"
#include "bench_speed.h"

enum { MOST_CASES = 32 };

static const char section[] = "decode";

/* ---- Opening ----------------------------------------------------------------------------------------------- */

typedef struct opening {
    const bench_speed_options *options;
    uint32_t threads;
    int extract; /* the first frame, at the file's default resolution */
    int failed;
} opening;

static void run_opening(void *data) {
    opening *o = data;
    bench_frames frames;
    o->failed |= bench_frames_open(&frames, o->options, o->threads, NSDF_CPU_ALL);
    frames.count = 1;
    if (!o->failed && o->extract) {
        bench_frames_run(&frames);
        o->failed |= bench_check("extracting a mesh", frames.status);
    }
    bench_frames_close(&frames);
}

static int bench_opening(const bench_speed_options *options) {
    static const char *const names[2] = {"open and close", "open to first frame"};
    opening openings[2 * BENCH_TEAMS];
    bench_case cases[2 * BENCH_TEAMS];
    int failed = 0;
    for (int i = 0; i < 2 * BENCH_TEAMS; i++) {
        openings[i] = (opening){options, options->threads[i % BENCH_TEAMS], i / BENCH_TEAMS, 0};
        cases[i] = (bench_case){"", openings[i].threads, run_opening, &openings[i], 0, 0, 0, 0};
        snprintf(cases[i].measure, sizeof cases[i].measure, "%s", names[i / BENCH_TEAMS]);
    }
    bench_run(&options->plan, cases, 2 * BENCH_TEAMS);
    for (int i = 0; i < 2 * BENCH_TEAMS; i++) {
        const bench_row row = bench_time(section, &cases[i], 1e3, "ms");
        bench_print(&row);
        failed |= openings[i].failed;
    }
    return failed;
}

/* ---- Frames ------------------------------------------------------------------------------------------------ */

static int print_frames(const bench_frames *frames, const bench_case *timed, uint32_t resolution) {
    char name[48];
    bench_row row = bench_time(section, timed, 1e3 / frames->count, "ms/frame");
    bench_print(&row);
    if (timed->threads == 1) {
        snprintf(name, sizeof name, "frame at %lu: size", (unsigned long)resolution);
        row = bench_count(section, name, 1, frames->triangles / frames->count, "triangles");
        bench_print(&row);
    }
    return bench_check("extracting a mesh", frames->status);
}

/* What the frames cost in points; `frames` has one thread. */
static int print_points(const bench_frames *frames, uint32_t resolution) {
    bench_points sum = {0, 0, 0, 0}, one;
    char name[3][48];
    for (uint32_t i = 0; i < frames->count; i++) {
        if (bench_check("counting points", bench_count_points(frames->decoder, frames->times[i], resolution, &one)))
            return -1;
        sum.values += one.values;
        sum.gradients += one.gradients;
        sum.seconds_field += one.seconds_field;
        sum.seconds += one.seconds;
    }
    static const char *const what[3] = {"values", "gradients", "share of evaluation"};
    for (int i = 0; i < 3; i++)
        snprintf(name[i], sizeof name[i], "frame at %lu: %s", (unsigned long)resolution, what[i]);
    const bench_row rows[3] = {
        bench_count(section, name[0], 1, (double)sum.values / frames->count, "points"),
        bench_count(section, name[1], 1, (double)sum.gradients / frames->count, "points"),
        bench_count(section, name[2], 1, 100 * sum.seconds_field / sum.seconds, "% of time"),
    };
    for (int i = 0; i < 3; i++)
        bench_print(&rows[i]);
    return 0;
}

static int bench_resolution(const bench_speed_options *options, bench_frames frames[BENCH_TEAMS], uint32_t resolution) {
    bench_case cases[BENCH_TEAMS];
    int failed = 0;
    for (int t = 0; t < BENCH_TEAMS; t++) {
        frames[t].options.resolution = resolution;
        cases[t] = (bench_case){"", options->threads[t], bench_frames_run, &frames[t], 0, 0, 0, 0};
        snprintf(cases[t].measure, sizeof cases[t].measure, "frame at %lu", (unsigned long)resolution);
    }
    bench_run(&options->plan, cases, BENCH_TEAMS);
    for (int t = 0; t < BENCH_TEAMS; t++)
        failed |= print_frames(&frames[t], &cases[t], resolution);
    return failed || print_points(&frames[0], resolution) ? -1 : 0;
}

/* ---- Evaluation -------------------------------------------------------------------------------------------- */

typedef struct evaluation {
    bench_frames frames;
    bench_isa isa;
    const float *xyz; /* [count][3] */
    float *distance, *gradient;
    uint32_t count;
    int with_gradient;
    double flop; /* of a call; 0: not known */
} evaluation;

typedef struct bench {
    const bench_speed_options *options;
    nsdf_workers *team[BENCH_TEAMS];
    bench_peak *peak[BENCH_TEAMS];
    float *xyz, *distance, *gradient;
    evaluation evaluations[MOST_CASES];
    double peak_flop[MOST_CASES];
    bench_isa peak_isa[MOST_CASES];
    bench_case cases[MOST_CASES];
    uint32_t peaks, count; /* the peaks come first */
} bench;

static void run_evaluation(void *data) {
    evaluation *e = data;
    bench_frames *f = &e->frames;
    if (f->status == NSDF_OK)
        f->status = nsdf_evaluate(f->decoder, f->times[0], e->xyz, e->count, e->distance,
                                  e->with_gradient ? e->gradient : NULL);
}

static int add_evaluation(bench *b, uint32_t threads, uint32_t cpu_mask, int with_gradient) {
    bench_case *timed = &b->cases[b->count];
    evaluation *e = &b->evaluations[b->count++];
    bench_flop flop;
    *timed = (bench_case){"", threads, run_evaluation, e, 0, 0, 0, 0};
    if (bench_frames_open(&e->frames, b->options, threads, cpu_mask) != 0 ||
        bench_check("the network", bench_network_flop(e->frames.decoder, 0.0, &flop)) != 0)
        return -1;
    const char *kernels = nsdf_kernel_name(e->frames.decoder);
    snprintf(timed->measure, sizeof timed->measure, "nsdf_evaluate: %s %s", with_gradient ? "gradient" : "value",
             kernels);
    e->isa = bench_isa_of_name(kernels);
    e->xyz = b->xyz;
    e->distance = b->distance;
    e->gradient = b->gradient;
    e->count = b->options->points;
    e->with_gradient = with_gradient;
    e->flop = e->count * (flop.value + (with_gradient ? flop.gradient : 0.0));
    return 0;
}

static void add_peaks(bench *b) {
    for (int t = 0; t < BENCH_TEAMS; t++)
        for (int isa = 0; isa < BENCH_ISA_COUNT; isa++) {
            if (!bench_isa_is_here((bench_isa)isa))
                continue;
            b->peak_flop[b->count] = bench_peak_fma_case(b->peak[t], (bench_isa)isa, &b->cases[b->count]);
            b->peak_isa[b->count++] = (bench_isa)isa;
        }
    b->peaks = b->count;
}

/* Every instruction set on one thread, the best one with every team. */
static int add_evaluations(bench *b) {
    static const uint32_t masks[BENCH_ISA_COUNT] = {0, NSDF_CPU_AVX2, NSDF_CPU_ALL};
    int failed = 0;
    for (int with_gradient = 0; with_gradient < 2; with_gradient++) {
        for (int isa = 0; isa < (int)bench_isa_best(); isa++)
            failed |= add_evaluation(b, 1, masks[isa], with_gradient);
        for (int t = 0; t < BENCH_TEAMS; t++)
            failed |= add_evaluation(b, b->options->threads[t], NSDF_CPU_ALL, with_gradient);
    }
    return failed;
}

static void print_evaluation(const bench *b, uint32_t index) {
    const bench_case *timed = &b->cases[index];
    const evaluation *e = &b->evaluations[index];
    bench_row row = bench_rate(section, timed, 1e-6 * e->count, "Mpoints/s");
    bench_print(&row);
    if (!(e->flop > 0))
        return;
    row = bench_rate(section, timed, 1e-9 * e->flop, "GFLOP/s");
    for (uint32_t i = 0; i < b->peaks; i++)
        if (b->peak_isa[i] == e->isa && b->cases[i].threads == timed->threads)
            row.of_fma =
                e->flop / bench_compared_seconds(timed) / (b->peak_flop[i] / bench_compared_seconds(&b->cases[i]));
    bench_print(&row);
}

/* Points spread evenly over the domain (the R3 sequence of Roberts). */
static void place_points(const nsdf_info *info, uint32_t count, float *xyz) {
    static const double ratio[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t a = 0; a < 3; a++) {
            const double x = ratio[a] * (i + 1), part = x - (double)(uint64_t)x;
            xyz[3 * i + a] = (float)(info->domain_min[a] + part * (info->domain_max[a] - info->domain_min[a]));
        }
}

static void create_bench(bench *b, const nsdf_info *info) {
    const uint32_t points = b->options->points;
    for (int t = 0; t < BENCH_TEAMS; t++) {
        b->team[t] = bench_checked(nsdf_workers_create(b->options->threads[t]));
        b->peak[t] = bench_peak_create(b->team[t], 1);
    }
    b->xyz = bench_floats(3 * (size_t)points);
    b->distance = bench_floats(points);
    b->gradient = bench_floats(3 * (size_t)points);
    place_points(info, points, b->xyz);
}

static void free_bench(bench *b) {
    for (uint32_t i = b->peaks; i < b->count; i++)
        bench_frames_close(&b->evaluations[i].frames);
    for (int t = 0; t < BENCH_TEAMS; t++) {
        bench_peak_free(b->peak[t]);
        nsdf_workers_free(b->team[t]);
    }
    free(b->xyz);
    free(b->distance);
    free(b->gradient);
    free(b);
}

static int bench_evaluation(const bench_speed_options *options, const nsdf_info *info) {
    bench *b = bench_allocate_zeroed(1, sizeof *b);
    b->options = options;
    create_bench(b, info);
    add_peaks(b);
    int failed = add_evaluations(b);
    if (!failed)
        bench_run(&options->plan, b->cases, b->count);
    for (uint32_t i = 0; !failed && i < b->peaks; i++) {
        const bench_row row = bench_rate(section, &b->cases[i], 1e-9 * b->peak_flop[i], "GFLOP/s");
        bench_print(&row);
    }
    for (uint32_t i = b->peaks; !failed && i < b->count; i++) {
        print_evaluation(b, i);
        failed |= bench_check("nsdf_evaluate", b->evaluations[i].frames.status);
    }
    free_bench(b);
    return failed;
}

int bench_speed_decode(const bench_speed_options *options) {
    bench_frames frames[BENCH_TEAMS];
    nsdf_info info;
    int failed = bench_opening(options);
    for (int t = 0; t < BENCH_TEAMS; t++)
        failed |= bench_frames_open(&frames[t], options, options->threads[t], NSDF_CPU_ALL);
    if (!failed)
        failed = bench_check(options->file, nsdf_get_info(frames[0].decoder, &info));
    for (const uint32_t *resolution = options->resolutions; *resolution > 0 && !failed; resolution++)
        failed = bench_resolution(options, frames, *resolution);
    if (!failed)
        failed = bench_evaluation(options, &info);
    for (int t = 0; t < BENCH_TEAMS; t++)
        bench_frames_close(&frames[t]);
    return failed;
}
