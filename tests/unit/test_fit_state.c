/* The fields of checkpoints: what is written comes back, and what cannot be is refused. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "fit_state.h"

#include <math.h>
#include <stdlib.h>

typedef struct {
    uint8_t a;
    uint32_t b;
    uint64_t c;
    float d;
    double e;
    nsdf_random random;
    nsdf_frame_order order;
    nsdf_adam adam;
    nsdf_sample_set set;
} example;

enum { ROOM = 5 };

static void example_fields(example *x, nsdf_fit_state *f) {
    nsdf_state_u8(f, &x->a);
    nsdf_state_u32(f, &x->b);
    nsdf_state_u64(f, &x->c);
    nsdf_state_f32(f, &x->d);
    nsdf_state_f64(f, &x->e);
    nsdf_state_random(f, &x->random);
    nsdf_state_order(f, &x->order);
    nsdf_state_adam(f, &x->adam);
    nsdf_state_samples(f, &x->set, ROOM);
}

static void make_example(example *x) {
    memset(x, 0, sizeof *x);
    x->random = nsdf_random_start(1, 1);
    assert_int_equal(nsdf_frame_order_create(&x->order, 4), 0);
    assert_int_equal(nsdf_adam_create(&x->adam, 3), 0);
    float **arrays[] = {&x->set.x, &x->set.y, &x->set.z, &x->set.d};
    for (int i = 0; i < 4; i++)
        *arrays[i] = calloc(ROOM, sizeof(float));
}

static void free_example(example *x) {
    nsdf_frame_order_free(&x->order);
    nsdf_adam_free(&x->adam);
    nsdf_sample_set_free(&x->set);
}

static void fill_example(example *x) {
    x->a = 200;
    x->b = 0xdeadbeef;
    x->c = UINT64_C(0x0123456789abcdef);
    x->d = -0.0f;
    x->e = 1.0 / 3.0;
    x->random = nsdf_random_start(9, 4);
    (void)nsdf_frame_order_next(&x->order, &x->random);
    x->adam.step = 17;
    for (int i = 0; i < 3; i++) {
        x->adam.mean[i] = 0.1f * (float)i;
        x->adam.square[i] = NAN;
    }
    x->set.count = 2;
    x->set.x[1] = 3.0f;
    x->set.d[0] = -4.0f;
}

static void test_fields_come_back_bit_by_bit(void **state) {
    example written, read;
    nsdf_buffer out = {0}, again = {0};
    (void)state;
    make_example(&written);
    make_example(&read);
    fill_example(&written);
    example_fields(&written, &(nsdf_fit_state){.out = &out});
    nsdf_fit_state in = {.in = nsdf_cursor_start(out.data, out.size, 0)};
    example_fields(&read, &in);
    assert_int_equal(in.in.status, NSDF_PARSE_OK);
    assert_int_equal(in.in.at, out.size);
    assert_true(read.a == 200 && read.b == 0xdeadbeef && read.c == written.c && read.e == written.e);
    assert_true(signbit(read.d) && read.set.count == 2 && read.set.x[1] == 3.0f && read.adam.step == 17);
    assert_int_equal(nsdf_frame_order_next(&read.order, &read.random),
                     nsdf_frame_order_next(&written.order, &written.random));
    fill_example(&read);
    fill_example(&written);
    out.size = 0;
    example_fields(&written, &(nsdf_fit_state){.out = &out});
    example_fields(&read, &(nsdf_fit_state){.out = &again});
    assert_int_equal(again.size, out.size);
    assert_memory_equal(again.data, out.data, out.size);
    nsdf_buffer_free(&out);
    nsdf_buffer_free(&again);
    free_example(&written);
    free_example(&read);
}

/* Spoils an example, writes it, and expects that reading it fails. */
static void assert_spoiled(void (*spoil)(example *), const char *text) {
    example written, read;
    nsdf_buffer out = {0};
    make_example(&written);
    make_example(&read);
    spoil(&written);
    example_fields(&written, &(nsdf_fit_state){.out = &out});
    nsdf_fit_state in = {.in = nsdf_cursor_start(out.data, out.size, 0)};
    example_fields(&read, &in);
    assert_int_equal(in.in.status, NSDF_PARSE_CORRUPT);
    assert_string_equal(in.in.fault.what, text);
    assert_int_equal(read.set.count, 0);
    nsdf_buffer_free(&out);
    written.set.count = 0;
    free_example(&written);
    free_example(&read);
}

static void spoil_stream(example *x) {
    x->random.stream = 4;
}

static void spoil_order(example *x) {
    x->order.frames[2] = 4;
}

static void spoil_used(example *x) {
    x->order.used = 5;
}

static void test_fields_that_cannot_be_are_refused(void **state) {
    (void)state;
    assert_spoiled(spoil_stream, "no random stream");
    assert_spoiled(spoil_order, "a frame that there is not");
    assert_spoiled(spoil_used, "more frames used than there are");
    uint8_t many[8] = {ROOM + 1};
    example x;
    make_example(&x);
    nsdf_fit_state in = {.in = nsdf_cursor_start(many, sizeof many, 0)};
    nsdf_state_samples(&in, &x.set, ROOM);
    assert_int_equal(in.in.status, NSDF_PARSE_CORRUPT);
    assert_int_equal(x.set.count, 0);
    free_example(&x);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_fields_come_back_bit_by_bit),
        cmocka_unit_test(test_fields_that_cannot_be_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
