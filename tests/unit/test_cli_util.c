/* What the command-line programs share: numbers, and files that appear complete or not at all. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* The programs' sources are in no library. */
#include "cli/cli_util.c"
#include "cli/cli_file.c"

static void whole_numbers_are_read_and_their_range_kept(void **state) {
    (void)state;
    uint32_t n = 77;
    uint64_t m = 77;
    assert_int_equal(nsdf_cli_parse_u32("192", 2, 4096, &n), 0);
    assert_int_equal(n, 192);
    static const char *const wrong[] = {"", "1", "4097", "-5", "+5", " 5", "5 ", "5x", "0x10", "99999999999999999999"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(nsdf_cli_parse_u32(wrong[i], 2, 4096, &n), -1);
    assert_int_equal(n, 192);
    assert_int_equal(nsdf_cli_parse_u64("18446744073709551615", &m), 0);
    assert_true(m == UINT64_MAX);
    assert_int_equal(nsdf_cli_parse_u64("18446744073709551616", &m), -1);
}

static void decimal_numbers_are_finite_and_complete(void **state) {
    (void)state;
    double x = 0;
    assert_int_equal(nsdf_cli_parse_double("-1.25e1", &x), 0);
    assert_true(x == -12.5);
    static const char *const wrong[] = {"", "nan", "inf", "1e999", "1,5", "1.5s", " 1", "."};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(nsdf_cli_parse_double(wrong[i], &x), -1);
    assert_true(x == -12.5);
}

static void bytes_take_a_suffix(void **state) {
    (void)state;
    uint64_t n = 0;
    assert_int_equal(nsdf_cli_parse_bytes("500", &n), 0);
    assert_true(n == 500);
    assert_int_equal(nsdf_cli_parse_bytes("3k", &n), 0);
    assert_true(n == 3072);
    assert_int_equal(nsdf_cli_parse_bytes("2M", &n), 0);
    assert_true(n == (uint64_t)2 << 20);
    assert_int_equal(nsdf_cli_parse_bytes("4G", &n), 0);
    assert_true(n == (uint64_t)4 << 30);
    static const char *const wrong[] = {"", "k", "1T", "1kk", "-1", "1.5G", "99999999999999999G"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(nsdf_cli_parse_bytes(wrong[i], &n), -1);
}

static void rates_are_exact_fractions(void **state) {
    (void)state;
    const struct {
        const char *text;
        uint32_t num, den;
    } good[] = {{"30", 30, 1}, {"29.97", 2997, 100}, {"60000/1001", 60000, 1001},   {"50/2", 25, 1}, {"12.50", 25, 2},
                {".5", 1, 2},  {"25.", 25, 1},       {"4294967295", 4294967295u, 1}};
    uint32_t num = 0, den = 0;
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        assert_int_equal(nsdf_cli_parse_rational(good[i].text, &num, &den), 0);
        assert_int_equal(num, good[i].num);
        assert_int_equal(den, good[i].den);
    }
    static const char *const wrong[] = {"", ".", "0", "0/5", "5/0", "-5", "1/2/3", "1.5/2", "a", "4294967296", "1..5"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(nsdf_cli_parse_rational(wrong[i], &num, &den), -1);
    assert_int_equal(num, 4294967295u);
}

/* ---- Files ------------------------------------------------------------------------------------------------- */

static char folder[] = "/tmp/nsdf_cli_test_XXXXXX";

static int make_folder(void **state) {
    (void)state;
    strcpy(folder + sizeof folder - 7, "XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static const char *in_folder(const char *name) {
    static char path[200];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static int remove_folder(void **state) {
    (void)state;
    static const char *const names[] = {"a", "b", "c"};
    nsdf_cli_abort();
    for (size_t i = 0; i < 3; i++)
        remove(in_folder(names[i]));
    return rmdir(folder);
}

static int files_in_folder(void) {
    int n = 0;
    DIR *open_folder = opendir(folder);
    assert_non_null(open_folder);
    for (struct dirent *entry; (entry = readdir(open_folder));)
        n += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    closedir(open_folder);
    return n;
}

static void write_some(const char *name, const char *text, size_t times) {
    nsdf_cli_file file;
    assert_int_equal(nsdf_cli_file_open(&file, in_folder(name)), 0);
    for (size_t i = 0; i < times; i++)
        assert_int_equal(nsdf_cli_file_write(&file, text, strlen(text)), 0);
    assert_int_equal(nsdf_cli_file_close(&file), 0);
}

static void files_appear_when_all_are_committed(void **state) {
    (void)state;
    struct stat info;
    write_some("a", "0123456789", 100000);
    write_some("b", "x", 1);
    assert_int_equal(files_in_folder(), 2);
    assert_int_equal(stat(in_folder("a"), &info), -1);
    assert_int_equal(nsdf_cli_commit(), 0);
    assert_int_equal(files_in_folder(), 2);
    assert_int_equal(stat(in_folder("a"), &info), 0);
    assert_int_equal(info.st_size, 1000000);
    assert_int_equal(stat(in_folder("b"), &info), 0);
    assert_int_equal(info.st_size, 1);
}

static void aborting_removes_every_file_and_keeps_older_ones(void **state) {
    (void)state;
    struct stat info;
    write_some("a", "old", 1);
    assert_int_equal(nsdf_cli_commit(), 0);
    write_some("a", "newer", 1);
    write_some("b", "x", 1);
    nsdf_cli_abort();
    assert_int_equal(files_in_folder(), 1);
    assert_int_equal(stat(in_folder("a"), &info), 0);
    assert_int_equal(info.st_size, 3);
}

static void a_failing_commit_leaves_none_of_the_files(void **state) {
    (void)state;
    write_some("a", "x", 1);
    write_some("b", "x", 1);
    assert_int_equal(mkdir(in_folder("b"), 0777), 0); /* a file cannot take a folder's name */
    assert_int_equal(nsdf_cli_commit(), -1);
    assert_int_equal(files_in_folder(), 1);
}

static void publish_some(const char *name, const char *text, int expected) {
    nsdf_cli_file file;
    assert_int_equal(nsdf_cli_file_open(&file, in_folder(name)), 0);
    assert_int_equal(nsdf_cli_file_write(&file, text, strlen(text)), 0);
    assert_int_equal(nsdf_cli_file_publish(&file), expected);
}

static off_t size_in_folder(const char *name) {
    struct stat info;
    return stat(in_folder(name), &info) == 0 ? info.st_size : -1;
}

static void a_published_file_has_its_name_before_the_others(void **state) {
    (void)state;
    write_some("a", "x", 1);
    publish_some("b", "old", 0);
    assert_int_equal(size_in_folder("b"), 3);
    publish_some("b", "newer", 0);
    assert_int_equal(size_in_folder("b"), 5);
    assert_int_equal(size_in_folder("a"), -1);
    assert_int_equal(files_in_folder(), 2);
    assert_int_equal(nsdf_cli_commit(), 0);
    assert_int_equal(size_in_folder("a"), 1);
    write_some("a", "xyz", 1);
    publish_some("b", "x", 0);
    nsdf_cli_abort();
    assert_int_equal(size_in_folder("a"), 1);
    assert_int_equal(size_in_folder("b"), 1);
    assert_int_equal(files_in_folder(), 2);
}

static void a_file_that_cannot_be_published_leaves_nothing(void **state) {
    (void)state;
    nsdf_cli_file file;
    assert_int_equal(nsdf_cli_file_open(&file, in_folder("b")), 0);
    assert_int_equal(mkdir(in_folder("b"), 0777), 0); /* a file cannot take a folder's name */
    assert_int_equal(nsdf_cli_file_publish(&file), -1);
    assert_int_equal(files_in_folder(), 1);
    assert_int_equal(nsdf_cli_commit(), 0);
}

static void folders_that_are_not_there_are_an_error(void **state) {
    (void)state;
    nsdf_cli_file file;
    assert_int_equal(nsdf_cli_file_open(&file, in_folder("none/a")), -1);
    assert_int_equal(nsdf_cli_file_open(&file, folder), -1);
    assert_int_equal(files_in_folder(), 0);
}

static void write_errors_are_remembered_until_closing(void **state) {
    (void)state;
    nsdf_cli_file file;
    static const char block[4096];
    if (access("/dev/full", W_OK) != 0)
        skip();
    assert_int_equal(nsdf_cli_file_open(&file, "/dev/full"), 0);
    int failed = 0;
    for (int i = 0; i < 1000; i++)
        failed |= nsdf_cli_file_write(&file, block, sizeof block) != 0;
    assert_true(failed);
    assert_int_equal(nsdf_cli_file_close(&file), -1);
    assert_int_equal(nsdf_cli_file_open(&file, "/dev/full"), 0);
    assert_int_equal(nsdf_cli_file_write(&file, block, 1), 0); /* fails when the buffer is written */
    assert_int_equal(nsdf_cli_file_close(&file), -1);
}

static void signals_are_counted(void **state) {
    (void)state;
    nsdf_cli_catch_signals();
    assert_int_equal(nsdf_cli_interrupts(), 0);
    raise(SIGINT);
    assert_int_equal(nsdf_cli_interrupts(), 1);
    raise(SIGINT);
    assert_int_equal(nsdf_cli_interrupts(), 2);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whole_numbers_are_read_and_their_range_kept),
        cmocka_unit_test(decimal_numbers_are_finite_and_complete),
        cmocka_unit_test(bytes_take_a_suffix),
        cmocka_unit_test(rates_are_exact_fractions),
        cmocka_unit_test_setup_teardown(files_appear_when_all_are_committed, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(aborting_removes_every_file_and_keeps_older_ones, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(a_published_file_has_its_name_before_the_others, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(a_file_that_cannot_be_published_leaves_nothing, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(a_failing_commit_leaves_none_of_the_files, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(folders_that_are_not_there_are_an_error, make_folder, remove_folder),
        cmocka_unit_test(write_errors_are_remembered_until_closing),
        cmocka_unit_test(signals_are_counted),
    };
    nsdf_cli_begin("test_cli_util");
    nsdf_cli_set_verbosity(-1);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
