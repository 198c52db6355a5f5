/* How many steps fit into a time: measured while they are made, so that the schedule, which is a function of all steps,
 * comes to its end when the time does. */
#ifndef NSDF_TIME_BUDGET_H
#define NSDF_TIME_BUDGET_H

#include <stdbool.h>
#include <stdint.h>

typedef struct nsdf_time_budget {
    double deadline; /* nsdf_clock() when the last step should be made; 0 = none */
    uint64_t steps;  /* in all, as planned now */
    /* The pace is measured from here on: behind the first steps, which also fill caches, and from plan to plan. */
    double began;
    uint64_t began_at;
    uint32_t planned; /* times that `steps` was planned anew */
    double late_from, late_by;
    bool is_late;
} nsdf_time_budget;

/* Without a deadline it is `steps` all the time. */
void nsdf_budget_start(nsdf_time_budget *budget, double deadline, uint64_t steps);

/* Steps from the share `from` on, behind the half, will take about `by` times as long as those before. */
void nsdf_budget_expect(nsdf_time_budget *budget, double from, double by);

/* To be called before each step with the number that are made: the number in all.  Changes at the beginning, and at a
 * tenth, three tenths, a half and two thirds of the way; a fifth of the steps at least are left then, so that schedules
 * come to their end. */
uint64_t nsdf_budget_plan(nsdf_time_budget *budget, uint64_t done, double now);

/* Seconds since the last plan that no step took. */
void nsdf_budget_pause(nsdf_time_budget *budget, double seconds);

#endif
