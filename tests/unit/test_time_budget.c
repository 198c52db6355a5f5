/* Numbers of steps that follow a time. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "time_budget.h"

/* Makes steps on a clock of our own, each taking `pace(step)`, from time 100 on.  Returns when the last is made. */
static double run(nsdf_time_budget *b, double (*pace)(uint64_t step), uint64_t *steps) {
    double now = 100.0;
    uint64_t done = 0;
    while (done < nsdf_budget_plan(b, done, now)) {
        now += pace(done);
        done++;
    }
    *steps = done;
    return now;
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
        cmocka_unit_test(test_a_time_that_has_passed_gives_few_steps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
