/* The account of memory. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <string.h>

#include "memory.h"

static void test_blocks_are_aligned_and_counted(void **state) {
    nsdf_memory memory;
    void *blocks[20];
    (void)state;
    nsdf_memory_init(&memory, NULL, 1 << 20);
    for (uint64_t i = 0; i < 20; i++) {
        assert_int_equal(nsdf_memory_take(&memory, 1 + 37 * i, &blocks[i]), NSDF_OK);
        assert_int_equal((uintptr_t)blocks[i] % 64, 0);
        memset(blocks[i], 0xaa, (size_t)(1 + 37 * i));
    }
    assert_true(memory.used >= 20 + 37 * 190);
    const uint64_t peak = memory.peak;
    for (int i = 0; i < 20; i++)
        nsdf_memory_give(&memory, blocks[i]);
    nsdf_memory_give(&memory, NULL);
    assert_int_equal(memory.used, 0);
    assert_int_equal(memory.peak, peak);
}

static void test_nothing_costs_nothing(void **state) {
    nsdf_memory memory;
    void *block = &memory;
    (void)state;
    nsdf_memory_init(&memory, NULL, 0);
    assert_int_equal(nsdf_memory_take(&memory, 0, &block), NSDF_OK);
    assert_null(block);
}

static void test_the_limit_holds_for_any_size(void **state) {
    nsdf_memory memory, other;
    void *block = NULL;
    (void)state;
    nsdf_memory_init(&memory, NULL, 1000);
    assert_int_equal(nsdf_memory_take(&memory, 1001, &block), NSDF_LIMIT);
    assert_int_equal(nsdf_memory_take(&memory, UINT64_MAX, &block), NSDF_LIMIT);
    assert_int_equal(nsdf_memory_take(&memory, UINT64_MAX - 100, &block), NSDF_LIMIT);
    assert_null(block);
    nsdf_memory_init(&other, NULL, 1000);
    assert_int_equal(nsdf_memory_take(&other, 600, &block), NSDF_OK);
    memory.beside = &other;
    void *second = NULL;
    assert_int_equal(nsdf_memory_take(&memory, 600, &second), NSDF_LIMIT);
    nsdf_memory_give(&other, block);
    assert_int_equal(nsdf_memory_take(&memory, 600, &second), NSDF_OK);
    nsdf_memory_give(&memory, second);
}

static void test_growing_keeps_what_is_used(void **state) {
    nsdf_memory memory;
    void *array = NULL;
    uint64_t capacity = 0;
    (void)state;
    nsdf_memory_init(&memory, NULL, 1 << 16);
    for (uint64_t i = 0; i < 1000; i++) {
        assert_int_equal(nsdf_memory_grow(&memory, &array, &capacity, i + 1, i, sizeof(uint32_t)), NSDF_OK);
        assert_true(capacity > i);
        ((uint32_t *)array)[i] = (uint32_t)i;
    }
    for (uint32_t i = 0; i < 1000; i++)
        assert_int_equal(((uint32_t *)array)[i], i);
    const uint64_t before = capacity;
    assert_int_equal(nsdf_memory_grow(&memory, &array, &capacity, UINT64_MAX / 2, 1000, 4), NSDF_LIMIT);
    assert_int_equal(capacity, before);
    nsdf_memory_give(&memory, array);
    assert_int_equal(memory.used, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_blocks_are_aligned_and_counted),
        cmocka_unit_test(test_nothing_costs_nothing),
        cmocka_unit_test(test_the_limit_holds_for_any_size),
        cmocka_unit_test(test_growing_keeps_what_is_used),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
