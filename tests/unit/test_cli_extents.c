/* Known bytes of a file: compared with a plain copy of it, byte by byte. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>

/* The programs' sources are in no library. */
#include "cli/cli_extents.c"

enum { SIZE = 500 };

static uint8_t value_of(uint64_t offset) {
    return (uint8_t)(offset * 7 + offset / 256);
}

static void add(nsdf_cli_extents *extents, uint8_t *known, uint64_t from, uint64_t to) {
    uint8_t *data = malloc((size_t)(to - from));
    assert_non_null(data);
    for (uint64_t i = from; i < to; i++) {
        data[i - from] = value_of(i);
        known[i] = 1;
    }
    assert_int_equal(nsdf_cli_extents_add(extents, from, data, (size_t)(to - from)), 0);
}

/* The first gap and what lies behind it are where the bytes say. */
static int check_gap(const nsdf_cli_extents *extents, const uint8_t *known, uint64_t offset, uint64_t size,
                     uint64_t *from, uint64_t *to) {
    uint64_t at = offset, last, room;
    while (at < offset + size && known[at])
        at++;
    const int found = nsdf_cli_extents_gap(extents, offset, size, from, to, &room);
    assert_int_equal(found, at < offset + size);
    if (!found)
        return 0;
    assert_int_equal(*from, at);
    for (last = at; last < offset + size && !known[last]; last++)
        ;
    assert_int_equal(*to, last);
    for (; last < SIZE && !known[last]; last++)
        ;
    if (last < SIZE)
        assert_int_equal(room, last);
    else
        assert_true(room == UINT64_MAX);
    return 1;
}

static void random_reads_find_their_bytes(void **state) {
    (void)state;
    srand(5);
    for (int round = 0; round < 200; round++) {
        nsdf_cli_extents extents = {NULL, 0, 0, 0, 0};
        uint8_t known[SIZE] = {0}, out[SIZE];
        for (int i = 0; i < 20; i++) {
            const uint64_t offset = (uint64_t)rand() % SIZE, size = 1 + (uint64_t)rand() % (SIZE - offset) / 4;
            uint64_t from, to;
            while (check_gap(&extents, known, offset, size, &from, &to))
                add(&extents, known, from, to);
            nsdf_cli_extents_copy(&extents, offset, out, (size_t)size);
            for (uint64_t k = 0; k < size; k++)
                assert_int_equal(out[k], value_of(offset + k));
        }
        nsdf_cli_extents_free(&extents);
        assert_int_equal(extents.count, 0);
    }
}

static void the_longest_unused_are_dropped_first(void **state) {
    nsdf_cli_extents extents = {NULL, 0, 0, 0, 0};
    uint8_t known[SIZE] = {0}, byte;
    uint64_t from, to, room;
    (void)state;
    for (uint64_t at = 0; at < 300; at += 100)
        add(&extents, known, at, at + 100);
    nsdf_cli_extents_copy(&extents, 5, &byte, 1);
    nsdf_cli_extents_trim(&extents, 300);
    assert_int_equal(extents.count, 3);
    nsdf_cli_extents_trim(&extents, 299);
    assert_int_equal(extents.count, 2);
    assert_int_equal(nsdf_cli_extents_gap(&extents, 0, 300, &from, &to, &room), 1);
    assert_int_equal(from, 100);
    assert_int_equal(to, 200);
    nsdf_cli_extents_trim(&extents, 0);
    assert_int_equal(extents.count, 1);
    assert_int_equal(extents.bytes, 100);
    assert_int_equal(nsdf_cli_extents_gap(&extents, 0, 100, &from, &to, &room), 0);
    nsdf_cli_extents_free(&extents);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_reads_find_their_bytes),
        cmocka_unit_test(the_longest_unused_are_dropped_first),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
