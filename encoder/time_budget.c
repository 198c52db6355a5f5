#include "time_budget.h"

#include <math.h>

enum { WARM_STEPS = 20, FIRST_STEPS = 120, LEAST_STEPS = 200 };

/* Shares of the steps at which the plan is made anew, the first being after FIRST_STEPS.  Not later: the last part sees
 * rounded values, and the rate has come down by then. */
static const double plans[] = {0.0, 0.1, 0.3, 0.5, 0.66};
enum { PLANS = sizeof plans / sizeof *plans };

/* A plan does not cut off more: the share of the steps in which schedules come to their end. */
static const double least_left = 0.2;

void nsdf_budget_start(nsdf_time_budget *budget, double deadline, uint64_t steps) {
    const uint64_t least = deadline > 0.0 ? LEAST_STEPS : 0; /* room for the first plan */
    const nsdf_time_budget start = {deadline, steps > least ? steps : least, 0.0, 0, 0, 1.0, 1.0, false};
    *budget = start;
}

void nsdf_budget_expect(nsdf_time_budget *budget, double from, double by) {
    budget->late_from = from;
    budget->late_by = by;
}

static void measure_from(nsdf_time_budget *budget, uint64_t done, double now) {
    budget->began = now;
    budget->began_at = done;
}

/* Steps in all when there is time for `left` more of those that are made now. */
static double all_steps(const nsdf_time_budget *budget, uint64_t done, double left) {
    const double share = budget->late_from + (1.0 - budget->late_from) * budget->late_by;
    return budget->is_late ? (double)done + left : ((double)done + left) / share;
}

static void plan(nsdf_time_budget *budget, uint64_t done, double now) {
    const double pace = (now - budget->began) / (double)(done - budget->began_at);
    const double left = pace > 0.0 ? (budget->deadline - now) / pace : 0.0;
    const double least = fmin((double)budget->steps, (double)done / (1.0 - least_left));
    const double total = fmax(all_steps(budget, done, left), least);
    budget->steps = total < LEAST_STEPS ? LEAST_STEPS : total < 1e12 ? (uint64_t)total : (uint64_t)1e12;
    budget->planned++;
    measure_from(budget, done, now); /* what has become slower or faster since is to be seen */
}

uint64_t nsdf_budget_plan(nsdf_time_budget *budget, uint64_t done, double now) {
    if (!(budget->deadline > 0.0) || budget->planned == PLANS)
        return budget->steps;
    const double share = (double)done / (double)budget->steps;
    if (done == WARM_STEPS)
        measure_from(budget, done, now);
    if (!budget->is_late && share >= budget->late_from) {
        budget->is_late = true;
        measure_from(budget, done, now);
    }
    if (done >= FIRST_STEPS && done >= budget->began_at + WARM_STEPS && share >= plans[budget->planned])
        plan(budget, done, now);
    return budget->steps;
}

void nsdf_budget_pause(nsdf_time_budget *budget, double seconds) {
    budget->began += seconds;
}
