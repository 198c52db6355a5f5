/* How far the inner loops of fitting and decoding are from what one core can do at most.
 * usage: bench_kernels [--quick | --tiny] [--csv] */
#include "bench_kernels.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TURNS = 20000 };

typedef struct loop {
    bench_isa isa;
    volatile float result;
} loop;

int kernels_add(kernels_list *list, const kernels_entry *entry, const char *name, void (*run)(void *data), void *data) {
    if (list->count >= KERNELS_MOST_CASES) {
        fputs("bench_kernels: more cases than there is room for\n", stderr);
        exit(EXIT_FAILURE);
    }
    bench_case *timed = &list->cases[list->count];
    *timed = (bench_case){"", 1, run, data, 0, 0, 0, 0};
    snprintf(timed->measure, sizeof timed->measure, "%s", name);
    list->entries[list->count] = *entry;
    return (int)list->count++;
}

static void run_loop(void *data) {
    loop *l = data;
    l->result = bench_fma_loop(l->isa, TURNS);
}

/* The register loops are the first cases; returns where each set's is, or -1. */
static void add_loops(kernels_list *list, int place[BENCH_ISA_COUNT]) {
    static loop loops[BENCH_ISA_COUNT];
    for (int isa = BENCH_ISA_COUNT - 1; isa >= 0; isa--) {
        place[isa] = -1;
        if (!bench_isa_is_here((bench_isa)isa))
            continue;
        const kernels_entry entry = {
            "peak", (bench_isa)isa, KERNELS_FLOP, bench_fma_flop((bench_isa)isa, TURNS), 0.0, "", -1};
        loops[isa].isa = (bench_isa)isa;
        place[isa] = kernels_add(list, &entry, "register loop", run_loop, &loops[isa]);
    }
}

static double rate(const kernels_list *list, int i) {
    return list->entries[i].work / bench_compared_seconds(&list->cases[i]);
}

static void print_row(const kernels_list *list, int i, const int place[BENCH_ISA_COUNT], int csv) {
    const kernels_entry *e = &list->entries[i];
    const double seconds = bench_compared_seconds(&list->cases[i]), busy = list->cases[i].median / seconds;
    char share[16] = "", each[24] = "", times[16] = "";
    if (e->bound == KERNELS_FLOP && strcmp(e->section, "peak") != 0)
        snprintf(share, sizeof share, "%.1f", 100.0 * rate(list, i) / rate(list, place[e->isa]));
    if (e->items > 0.0)
        snprintf(each, sizeof each, "%.2f", 1e9 * seconds / e->items);
    if (e->compared >= 0)
        snprintf(times, sizeof times, "%.2f", seconds / bench_compared_seconds(&list->cases[e->compared]));
    printf(csv ? "%s,%s,%s,%.4g,%s,%s,%s,%s,%s,%.2f\n" : "%-7s %-30s %-7s %8.4g %-8s %6s %8s %-8s %5s %6.2f\n",
           e->section, list->cases[i].measure, bench_isa_name(e->isa), 1e-9 * rate(list, i),
           e->bound == KERNELS_FLOP ? "GFLOP/s" : "GB/s", share, each, e->item, times, busy);
}

static void print_all(const kernels_list *list, const int place[BENCH_ISA_COUNT], int csv) {
    if (csv)
        puts("section,kernel,set,rate,unit,percent_of_peak,ns,per,times_value,busy");
    else
        printf("%-7s %-30s %-7s %8s %-8s %6s %8s %-8s %5s %6s\n", "", "kernel", "set", "rate", "", "% peak", "ns per",
               "", "x", "busy");
    for (size_t i = 0; i < list->count; i++)
        print_row(list, (int)i, place, csv);
}

int main(int argc, char **argv) {
    static kernels_list list;
    bench_plan plan = {40, 10, 60.0, 0.004};
    int csv = 0, place[BENCH_ISA_COUNT];
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--csv") == 0) {
            csv = 1;
        } else if (strcmp(argv[i], "--quick") == 0) {
            plan.budget_seconds = 15.0;
        } else if (strcmp(argv[i], "--tiny") == 0) {
            plan = (bench_plan){1, 1, 0.0, 0.0};
            list.quick = 1;
        } else {
            fputs("usage: bench_kernels [--quick | --tiny] [--csv]\n", stderr);
            return 2;
        }
    }
    add_loops(&list, place);
    kernels_add_memory(&list);
    kernels_add_fit(&list);
    kernels_add_blocks(&list);
    kernels_add_decode(&list);
    bench_run(&plan, list.cases, list.count);
    print_all(&list, place, csv);
    return 0;
}
