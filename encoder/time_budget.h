/* How many steps fit into a time: measured while they are made, so that the schedule, which is a function of all steps,
 * comes to its end when the time does. */
#ifndef NSDF_TIME_BUDGET_H
#define NSDF_TIME_BUDGET_H

#include <stdint.h>

typedef struct nsdf_time_budget {
    double deadline; /* nsdf_clock() when the last step should be made; 0 = none */
    uint64_t steps;  /* in all, as planned now */
    /* The pace is measured from here on: behind the first steps, which also fill caches, and from plan to plan. */
    double began;
    uint64_t began_at;
    uint32_t planned; /* times that `steps` was planned anew */
} nsdf_time_budget;

/* Without a deadline it is `steps` all the time. */
void nsdf_budget_start(nsdf_time_budget *budget, double deadline, uint64_t steps);

/* To be called before each step with the number that are made: the number in all.  Changes at the beginning, and at a
 * tenth, three tenths and six tenths of the way. */
uint64_t nsdf_budget_plan(nsdf_time_budget *budget, uint64_t done, double now);

#endif
