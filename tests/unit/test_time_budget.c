/* Numbers of steps that follow a time. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "time_budget.h"

/* Makes steps on a clock of our own, each taking `pace(step)`, from time 100 on; behind step `at` there is an event.
 * Returns when the last step is made. */
static double run_with_event(nsdf_time_budget *b, double (*pace)(uint64_t step), uint64_t at,
                             void (*event)(nsdf_time_budget *b, double *now), uint64_t *steps) {
    double now = 100.0;
    uint64_t done = 0;
    while (done < nsdf_budget_plan(b, done, now)) {
        now += pace(done);
        if (++done == at)
            event(b, &now);
    }
    *steps = done;
    return now;
}

static double run(nsdf_time_budget *b, double (*pace)(uint64_t step), uint64_t *steps) {
    return run_with_event(b, pace, UINT64_MAX, NULL, steps);
}

static double even(uint64_t step) {
    (void)step;
    return 0.01;
}

static double slow_at_first(uint64_t step) {
    return step < 20 ? 1.0 : 0.01;
}

/* As when values are rounded from some step on. */
static double slower_later(uint64_t step) {
    return step < 5000 ? 0.01 : 0.02;
}

static void test_without_a_deadline_nothing_changes(void **state) {
    nsdf_time_budget b;
    uint64_t steps;
    (void)state;
    nsdf_budget_start(&b, 0.0, 777);
    (void)run(&b, even, &steps);
    assert_int_equal(steps, 777);
}

static void test_steps_fill_the_time(void **state) {
    nsdf_time_budget b;
    uint64_t steps;
    (void)state;
    nsdf_budget_start(&b, 200.0, 10); /* the plan may be far too small ... */
    double end = run(&b, even, &steps);
    assert_true(end > 199.9 && end < 200.1 && steps > 9990 && steps < 10010);
    nsdf_budget_start(&b, 200.0, 1000000); /* ... or too large */
    end = run(&b, even, &steps);
    assert_true(end > 199.9 && end < 200.1);
    nsdf_budget_start(&b, 200.0, 10000); /* the first steps do not count */
    end = run(&b, slow_at_first, &steps);
    assert_true(end > 199.0 && end < 201.0);
    nsdf_budget_start(&b, 200.0, 10000);
    end = run(&b, slower_later, &steps);
    assert_true(end > 195.0 && end < 217.0);
}

/* As networks, whose steps from 0.6 on take `by` times as long. */
static double run_late(nsdf_time_budget *b, double by, uint64_t *steps) {
    double now = 100.0;
    uint64_t done = 0;
    for (int late = 0; done < nsdf_budget_plan(b, done, now); done++) {
        late |= (double)done >= 0.6 * (double)b->steps;
        now += late ? 0.01 * by : 0.01;
    }
    *steps = done;
    return now;
}

/* Whether or not by as much as was expected. */
static void test_steps_that_become_slower_near_the_end_are_seen(void **state) {
    const double by[] = {1.5, 1.2, 1.9};
    uint64_t steps;
    (void)state;
    for (int i = 0; i < 3; i++) {
        nsdf_time_budget b;
        nsdf_budget_start(&b, 200.0, 10000);
        nsdf_budget_expect(&b, 0.6, 1.5);
        const double end = run_late(&b, by[i], &steps);
        assert_true(end > 199.0 && end < 201.0);
        assert_true(i > 0 || (steps > 8300 && steps < 8350)); /* 10000 / (0.6 + 0.4 * 1.5) */
    }
}

static void pass_without_a_step(nsdf_time_budget *b, double *now) {
    *now += 15.0;
    nsdf_budget_pause(b, 15.0);
}

static void test_what_no_step_took_does_not_count(void **state) {
    nsdf_time_budget b;
    uint64_t steps;
    (void)state;
    nsdf_budget_start(&b, 200.0, 10000);
    const double end = run_with_event(&b, even, 2000, pass_without_a_step, &steps);
    assert_true(end > 199.9 && end < 200.1);
    assert_int_equal(steps, 8500);
}

static void bring_deadline_near(nsdf_time_budget *b, double *now) {
    (void)now;
    b->deadline = 110.0;
}

/* What is left when the time is shorter than it was is enough for schedules to come to their end. */
static void test_a_fifth_of_the_steps_is_left(void **state) {
    nsdf_time_budget b;
    uint64_t steps;
    (void)state;
    nsdf_budget_start(&b, 200.0, 10000);
    (void)run_with_event(&b, even, 4000, bring_deadline_near, &steps);
    assert_true(steps >= 6250 && steps <= 6251);
}

static void test_a_time_that_has_passed_gives_few_steps(void **state) {
    nsdf_time_budget b;
    uint64_t steps;
    (void)state;
    nsdf_budget_start(&b, 1.0, 100000);
    (void)run(&b, even, &steps);
    assert_int_equal(steps, 200);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_without_a_deadline_nothing_changes),
        cmocka_unit_test(test_steps_fill_the_time),
        cmocka_unit_test(test_steps_that_become_slower_near_the_end_are_seen),
        cmocka_unit_test(test_what_no_step_took_does_not_count),
        cmocka_unit_test(test_a_fifth_of_the_steps_is_left),
        cmocka_unit_test(test_a_time_that_has_passed_gives_few_steps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
