/* Peak memory of a process that decodes two frames, as a row like those of bench_speed.  A program of its own that is
 * started anew for each measurement, because the peak of a process never falls.
 *
 *     bench_speed_memory FILE.nsdf RESOLUTION THREADS      resolution 0: opens the file only */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "bench_frames.h"

static const double kilobytes_a_megabyte = 1024.0;

int main(int argc, char **argv) {
    bench_speed_options options = {.frames = 2};
    bench_frames frames;
    struct rusage usage;
    char name[48] = "open only";
    if (argc != 4) {
        fputs("usage: bench_speed_memory FILE.nsdf RESOLUTION THREADS\n", stderr);
        return 2;
    }
    options.file = argv[1];
    const unsigned long resolution = strtoul(argv[2], NULL, 10), threads = strtoul(argv[3], NULL, 10);
    int failed = bench_frames_open(&frames, &options, (uint32_t)threads, NSDF_CPU_ALL);
    if (!failed && resolution > 0) {
        snprintf(name, sizeof name, "frame at %lu", resolution);
        frames.options.resolution = (uint32_t)resolution;
        bench_frames_run(&frames);
        failed = bench_check("extracting a mesh", frames.status);
    }
    if (!failed && getrusage(RUSAGE_SELF, &usage) == 0) {
        const double peak = (double)usage.ru_maxrss / kilobytes_a_megabyte;
        const bench_row row = bench_count("memory", name, (uint32_t)threads, peak, "MB");
        bench_print(&row);
    }
    bench_frames_close(&frames);
    return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
