#include "time_budget.h"

#include <math.h>

enum { WARM_STEPS = 20, FIRST_STEPS = 120, LEAST_STEPS = 200 };

/* Shares of the steps at which the plan is made anew, the first being after FIRST_STEPS.  Not later: the last part sees
 * rounded values, and the rate has come down by then. */
static const double plans[] = {0.0, 0.1, 0.3, 0.6};
enum { PLANS = sizeof plans / sizeof *plans };

void nsdf_budget_start(nsdf_time_budget *budget, double deadline, uint64_t steps) {
    const uint64_t least = deadline > 0.0 ? LEAST_STEPS : 0; /* room for the first plan */
    const nsdf_time_budget start = {deadline, steps > least ? steps : least, 0.0, 0, 0};
    *budget = start;
}

uint64_t nsdf_budget_plan(nsdf_time_budget *budget, uint64_t done, double now) {
    if (!(budget->deadline > 0.0) || budget->planned == PLANS)
        return budget->steps;
    if (done == WARM_STEPS) {
        budget->began = now;
        budget->began_at = done;
    }
    if (done < FIRST_STEPS || (double)done < plans[budget->planned] * (double)budget->steps)
        return budget->steps;
    const double pace = (now - budget->began) / (double)(done - budget->began_at);
    const double left = pace > 0.0 ? (budget->deadline - now) / pace : 0.0;
    const double total = (double)done + fmax(left, 0.0);
    budget->steps = total < LEAST_STEPS ? LEAST_STEPS : total < 1e12 ? (uint64_t)total : (uint64_t)1e12;
    budget->planned++;
    budget->began = now; /* what has become slower or faster since is to be seen */
    budget->began_at = done;
    return budget->steps;
}
