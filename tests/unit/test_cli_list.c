/* Lists of frame numbers. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <string.h>

/* The programs' sources are in no library. */
#include "cli/cli_list.c"
#include "cli/cli_util.c"

static void assert_numbers(const nsdf_cli_list *list, const char *wanted) {
    char got[256] = "";
    for (uint32_t i = 0; i < list->count; i++) {
        const size_t length = strlen(got);
        snprintf(got + length, sizeof got - length, "%s%lu", i ? " " : "", (unsigned long)list->numbers[i]);
    }
    assert_string_equal(got, wanted);
}

static void assert_list(const char *text, const char *wanted) {
    nsdf_cli_list list;
    assert_int_equal(nsdf_cli_list_parse(&list, "--frames", text, 20), NSDF_CLI_SUCCESS);
    assert_numbers(&list, wanted);
    nsdf_cli_list_free(&list);
    assert_null(list.numbers);
}

static void numbers_ranges_and_steps_keep_their_order(void **state) {
    (void)state;
    assert_list("7", "7");
    assert_list("19,0-3", "19 0 1 2 3");
    assert_list("1-8/2", "1 3 5 7");
    assert_list("1-9/2,4-4/3,0", "1 3 5 7 9 4 0");
    assert_list("3-5/100", "3");
    assert_list("2,2,1-2", "2 2 1 2");
}

static void everything_else_is_wrong_usage(void **state) {
    (void)state;
    static const char *const wrong[] = {"",
                                        ",",
                                        "1,",
                                        "x",
                                        "-3",
                                        "3-",
                                        "3-x",
                                        "5-2",
                                        "20",
                                        "0-20",
                                        "1/2",
                                        "0-9/0",
                                        "0-9/-1",
                                        "0-9/",
                                        "0-9/2x",
                                        " 1",
                                        "4294967296",
                                        "+1",
                                        "00000000000000000001"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        nsdf_cli_list list;
        assert_int_equal(nsdf_cli_list_parse(&list, "--frames", wrong[i], 20), NSDF_CLI_USAGE);
        nsdf_cli_list_free(&list);
    }
}

static void very_long_lists_fail(void **state) {
    (void)state;
    nsdf_cli_list list;
    assert_int_equal(nsdf_cli_list_parse(&list, "--frames", "0-4294967294", UINT32_MAX), NSDF_CLI_FAILURE);
    nsdf_cli_list_free(&list);
    assert_int_equal(nsdf_cli_list_parse(&list, "--frames", "0-9999998,7,7", UINT32_MAX), NSDF_CLI_FAILURE);
    nsdf_cli_list_free(&list);
}

static void sorting_leaves_each_number_once(void **state) {
    (void)state;
    nsdf_cli_list list;
    assert_int_equal(nsdf_cli_list_parse(&list, "--frames", "9,3-5,4,9,0", 20), NSDF_CLI_SUCCESS);
    nsdf_cli_list_sort(&list);
    assert_numbers(&list, "0 3 4 5 9");
    nsdf_cli_list_free(&list);
    assert_int_equal(nsdf_cli_list_all(&list, 3), NSDF_CLI_SUCCESS);
    nsdf_cli_list_sort(&list);
    assert_numbers(&list, "0 1 2");
    nsdf_cli_list_free(&list);
}

static int note_item(void *user, const char *text) {
    char *seen = user;
    strcat(strcat(seen, text), ";");
    return strcmp(text, "stop") == 0 ? NSDF_CLI_FAILURE : NSDF_CLI_SUCCESS;
}

static void items_are_visited_until_one_fails(void **state) {
    (void)state;
    char seen[64] = "";
    assert_int_equal(nsdf_cli_each_item("a,,bc", note_item, seen), NSDF_CLI_SUCCESS);
    assert_string_equal(seen, "a;;bc;");
    assert_int_equal(nsdf_cli_each_item("d,stop,e", note_item, seen), NSDF_CLI_FAILURE);
    assert_string_equal(seen, "a;;bc;d;stop;");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_ranges_and_steps_keep_their_order),
        cmocka_unit_test(everything_else_is_wrong_usage),
        cmocka_unit_test(very_long_lists_fail),
        cmocka_unit_test(sorting_leaves_each_number_once),
        cmocka_unit_test(items_are_visited_until_one_fails),
    };
    nsdf_cli_begin("test_cli_list");
    return cmocka_run_group_tests(tests, NULL, NULL);
}
