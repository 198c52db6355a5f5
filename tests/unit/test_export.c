/* Mesh files: what is written reads back as the same mesh. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <float.h>
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "export/mesh_output.h"

typedef struct sink {
    unsigned char *bytes;
    size_t size, capacity, fail_at; /* writes beyond fail_at fail; 0 = never */
    size_t calls;
} sink;

static int sink_write(void *user, const void *data, size_t size) {
    sink *s = user;
    s->calls++;
    if (s->fail_at && s->size + size > s->fail_at)
        return -1;
    if (s->size + size > s->capacity) {
        s->capacity = 2 * (s->size + size);
        s->bytes = realloc(s->bytes, s->capacity);
        assert_non_null(s->bytes);
    }
    memcpy(s->bytes + s->size, data, size);
    s->size += size;
    return 0;
}

static void assert_written(const nsdf_mesh_view *view, nsdf_mesh_format format, const char *expected, size_t size) {
    sink s = {0};
    assert_int_equal(nsdf_write_mesh(view, format, sink_write, &s), NSDF_OK);
    assert_int_equal(s.size, size);
    assert_memory_equal(s.bytes, expected, size);
    free(s.bytes);
}

static const float tetra_positions[12] = {0, 0, 0, 1.5f, 0, 0, 0, -2, 0, 0.1f, 1e-7f, 1e10f};
static const float tetra_normals[12] = {0, 0, -1, 1, 0, 0, 0, -1, 0, 0.6f, 0, 0.8f};
static const uint32_t tetra_indices[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
static const nsdf_mesh_view tetra = {tetra_positions, tetra_normals, tetra_indices, 4, 4};

static nsdf_mesh_view without_normals(nsdf_mesh_view view) {
    view.normals = NULL;
    return view;
}

/* ---- Decimals ---------------------------------------------------------------------------------------------- */

static float float_of(uint32_t bits) {
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static size_t digits_of(const char *text) {
    size_t n = 0, zeros = 0;
    for (; *text && *text != 'e'; text++) {
        if (*text < '0' || *text > '9' || (n == 0 && *text == '0'))
            continue;
        n++;
        zeros = *text == '0' ? zeros + 1 : 0;
    }
    return n - zeros;
}

/* A decimal half way to the next float reads back as either, depending on the reader's care: not used. */
static int is_half_way(double decimal, float value) {
    const double up = (double)nextafterf(value, INFINITY), down = (double)nextafterf(value, -INFINITY);
    return decimal == 0.5 * ((double)value + up) || decimal == 0.5 * ((double)value + down);
}

/* Reads back equal, is at most as long as promised, and no shorter %g does it. */
static void assert_shortest(float value) {
    char text[64], shorter[512]; /* gcc reckons with the longest double */
    unsigned char *const end = nsdf_put_decimal((unsigned char *)text, value);
    *end = 0;
    assert_true(end - (unsigned char *)text <= 16);
    const float back = strtof(text, NULL);
    assert_memory_equal(&back, &value, sizeof value);
    const size_t digits = digits_of(text);
    assert_true(digits <= 9);
    if (digits < 2)
        return;
    snprintf(shorter, sizeof shorter, "%.*g", (int)digits - 1, (double)value);
    const float rounded = strtof(shorter, NULL);
    assert_true(memcmp(&rounded, &value, sizeof value) != 0 || is_half_way(strtod(shorter, NULL), value));
}

static void decimals_read_back_equal_and_are_the_shortest(void **state) {
    (void)state;
    uint64_t seed = 1;
    int tried = 0;
    while (tried < 1000000) {
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        const float value = float_of((uint32_t)(seed >> 32));
        if (!isfinite(value))
            continue;
        if (tried % 2 && !(fabsf(value) > 1e-6f && fabsf(value) < 1e6f))
            continue; /* half of them of usual size */
        assert_shortest(value);
        tried++;
    }
}

static void decimals_at_the_ends_of_the_range_read_back(void **state) {
    (void)state;
    const float values[] = {FLT_MAX,
                            -FLT_MAX,
                            FLT_MIN,
                            0x1p-149f,
                            -0x1p-149f,
                            1,
                            10,
                            9.9999995f,
                            0.1f,
                            123456789.0f,
                            999999984.0f,
                            1e9f,
                            9.99999998e9f,
                            1e-4f,
                            9.9999997e-5f,
                            16777216,
                            1e30f,
                            1e-30f,
                            3e-40f};
    for (size_t i = 0; i < sizeof values / sizeof *values; i++)
        assert_shortest(values[i]);
    for (uint32_t exponent = 1; exponent < 255; exponent++) { /* powers of two and their neighbours */
        for (int d = -1; d <= 1; d++) {
            char text[32];
            const float value = float_of((exponent << 23) + (uint32_t)d);
            *nsdf_put_decimal((unsigned char *)text, value) = 0;
            assert_true(strtof(text, NULL) == value);
        }
    }
}

static void decimals_look_as_expected(void **state) {
    (void)state;
    const struct {
        float value;
        const char *text;
    } cases[] = {{0, "0"},
                 {-0.0f, "-0"},
                 {1, "1"},
                 {-1.5f, "-1.5"},
                 {100, "100"},
                 {0.1f, "0.1"},
                 {0.001f, "0.001"},
                 {1e-5f, "1e-5"},
                 {1.25e-20f, "1.25e-20"},
                 {3e20f, "3e+20"},
                 {123456.79f, "123456.79"},
                 {0.33333334f, "0.33333334"},
                 {1.0f / 0x1p100f, "7.888609e-31"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[32];
        *nsdf_put_decimal((unsigned char *)text, cases[i].value) = 0;
        assert_string_equal(text, cases[i].text);
    }
}

static void integers_are_written_in_full(void **state) {
    (void)state;
    const uint32_t values[] = {0, 7, 10, 99, 100, 101, 999, 1000, 12345, 4294967295u};
    for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
        char text[16], expected[16];
        *nsdf_put_integer((unsigned char *)text, values[i]) = 0;
        snprintf(expected, sizeof expected, "%lu", (unsigned long)values[i]);
        assert_string_equal(text, expected);
    }
}

/* ---- Files ------------------------------------------------------------------------------------------------- */

static void obj_holds_positions_normals_and_faces_from_one(void **state) {
    (void)state;
    static const char with[] = "v 0 0 0\nv 1.5 0 0\nv 0 -2 0\nv 0.1 1e-7 1e+10\n"
                               "vn 0 0 -1\nvn 1 0 0\nvn 0 -1 0\nvn 0.6 0 0.8\n"
                               "f 1//1 3//3 2//2\nf 1//1 2//2 4//4\nf 2//2 3//3 4//4\nf 3//3 1//1 4//4\n";
    static const char without[] = "v 0 0 0\nv 1.5 0 0\nv 0 -2 0\nv 0.1 1e-7 1e+10\n"
                                  "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    const nsdf_mesh_view plain = without_normals(tetra);
    assert_written(&tetra, NSDF_MESH_OBJ, with, sizeof with - 1);
    assert_written(&plain, NSDF_MESH_OBJ, without, sizeof without - 1);
}

static void the_locale_does_not_change_obj(void **state) {
    (void)state;
    static const char *const with_comma[] = {"de_DE.UTF-8", "fr_FR.UTF-8", "cs_CZ.UTF-8"};
    for (size_t i = 0; i < 3; i++)
        if (setlocale(LC_ALL, with_comma[i]))
            break; /* where none is installed this repeats the test above */
    obj_holds_positions_normals_and_faces_from_one(NULL);
    setlocale(LC_ALL, "C");
}

static float float_at(const unsigned char *at) {
    return float_of((uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24);
}

static void ply_holds_the_header_and_packed_records(void **state) {
    (void)state;
    static const char header[] = "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\n"
                                 "property float y\nproperty float z\nproperty float nx\nproperty float ny\n"
                                 "property float nz\nelement face 4\nproperty list uchar int vertex_indices\n"
                                 "end_header\n";
    const size_t head = sizeof header - 1;
    sink s = {0};
    assert_int_equal(nsdf_write_mesh(&tetra, NSDF_MESH_PLY, sink_write, &s), NSDF_OK);
    assert_int_equal(s.size, head + 4 * 24 + 4 * 13);
    assert_memory_equal(s.bytes, header, head);
    for (size_t v = 0; v < 4; v++) {
        for (size_t a = 0; a < 3; a++) {
            assert_true(float_at(s.bytes + head + 24 * v + 4 * a) == tetra_positions[3 * v + a]);
            assert_true(float_at(s.bytes + head + 24 * v + 12 + 4 * a) == tetra_normals[3 * v + a]);
        }
    }
    static const unsigned char first_face[13] = {3, 0, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0};
    assert_memory_equal(s.bytes + head + 96, first_face, 13);
    free(s.bytes);
}

static void stl_holds_face_normals_and_corners(void **state) {
    (void)state;
    sink s = {0};
    assert_int_equal(nsdf_write_mesh(&tetra, NSDF_MESH_STL, sink_write, &s), NSDF_OK);
    assert_int_equal(s.size, 84 + 4 * 50);
    assert_true(memcmp(s.bytes, "solid", 5) != 0);
    assert_int_equal(s.bytes[80], 4);
    const float expected[12] = {0, 0, 1, 0, 0, 0, 0, -2, 0, 1.5f, 0, 0}; /* (0,-2,0) x (1.5,0,0) = (0,0,3) */
    for (size_t i = 0; i < 12; i++)
        assert_true(float_at(s.bytes + 84 + 4 * i) == expected[i]);
    free(s.bytes);
}

static void empty_meshes_are_valid_files(void **state) {
    (void)state;
    const nsdf_mesh_view empty = {NULL, NULL, NULL, 0, 0};
    assert_written(&empty, NSDF_MESH_OBJ, "", 0);
    sink s = {0};
    assert_int_equal(nsdf_write_mesh(&empty, NSDF_MESH_STL, sink_write, &s), NSDF_OK);
    assert_int_equal(s.size, 84);
    free(s.bytes);
}

/* A mesh much larger than the block comes through whole, in large writes. */
static void long_files_are_written_in_blocks(void **state) {
    (void)state;
    enum { COUNT = 20000 };
    static float positions[3 * COUNT];
    static uint32_t indices[3 * COUNT];
    uint32_t lines = 0;
    for (uint32_t i = 0; i < 3 * COUNT; i++) {
        positions[i] = 1.0f / (float)(i + 3);
        indices[i] = (i * 7u) % COUNT;
    }
    const nsdf_mesh_view view = {positions, positions, indices, COUNT, COUNT};
    sink s = {0};
    assert_int_equal(nsdf_write_mesh(&view, NSDF_MESH_OBJ, sink_write, &s), NSDF_OK);
    assert_true(s.size / s.calls > 16384);
    assert_int_equal(sink_write(&s, "", 1), 0);
    char *at = (char *)s.bytes;
    for (uint32_t v = 0; v < COUNT; v++, lines++) {
        float p[3];
        assert_memory_equal(at, "v ", 2);
        at++;
        for (int a = 0; a < 3; a++)
            p[a] = strtof(at, &at);
        assert_memory_equal(p, positions + 3 * (size_t)v, sizeof p);
        assert_int_equal(*at++, '\n');
    }
    for (; (at = strchr(at, '\n')); at++)
        lines++;
    assert_int_equal(lines, 3 * COUNT);
    free(s.bytes);
}

static void failing_writes_stop_with_io(void **state) {
    (void)state;
    for (nsdf_mesh_format format = NSDF_MESH_OBJ; format <= NSDF_MESH_STL; format++) {
        sink s = {.fail_at = 1};
        assert_int_equal(nsdf_write_mesh(&tetra, format, sink_write, &s), NSDF_IO);
        assert_int_equal(s.calls, 1);
    }
}

static void wrong_arguments_are_refused(void **state) {
    (void)state;
    static const uint32_t beyond[3] = {0, 1, 4};
    const nsdf_mesh_view bad = {tetra_positions, NULL, beyond, 4, 1};
    const nsdf_mesh_view missing = {NULL, NULL, NULL, 4, 0};
    sink s = {0};
    assert_int_equal(nsdf_write_mesh(&bad, NSDF_MESH_STL, sink_write, &s), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_write_mesh(&missing, NSDF_MESH_OBJ, sink_write, &s), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_write_mesh(NULL, NSDF_MESH_OBJ, sink_write, &s), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_write_mesh(&tetra, NSDF_MESH_OBJ, NULL, &s), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_write_mesh(&tetra, (nsdf_mesh_format)7, sink_write, &s), NSDF_INVALID_ARGUMENT);
    assert_int_equal(s.calls, 0);
}

static void formats_are_known_by_their_endings(void **state) {
    (void)state;
    nsdf_mesh_format format = NSDF_MESH_OBJ;
    assert_int_equal(nsdf_mesh_format_from_name("a/b.ply", &format), NSDF_OK);
    assert_int_equal(format, NSDF_MESH_PLY);
    assert_int_equal(nsdf_mesh_format_from_name("out_%04d.STL", &format), NSDF_OK);
    assert_int_equal(format, NSDF_MESH_STL);
    assert_int_equal(nsdf_mesh_format_from_name("x.Obj", &format), NSDF_OK);
    assert_int_equal(format, NSDF_MESH_OBJ);
    assert_int_equal(nsdf_mesh_format_from_name("x.obj.gz", &format), NSDF_UNSUPPORTED_FEATURE);
    assert_int_equal(nsdf_mesh_format_from_name(".obj", &format), NSDF_UNSUPPORTED_FEATURE);
    assert_int_equal(nsdf_mesh_format_from_name("", &format), NSDF_UNSUPPORTED_FEATURE);
    assert_int_equal(nsdf_mesh_format_from_name(NULL, &format), NSDF_INVALID_ARGUMENT);
}

/* ---- Hash -------------------------------------------------------------------------------------------------- */

static void the_hash_is_fnv_1a_of_the_little_endian_bytes(void **state) {
    (void)state;
    static const float position[3] = {1, -2, 0.5f};
    const nsdf_mesh_view view = {position, NULL, NULL, 1, 0};
    static const unsigned char bytes[20] = {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x80, 0x3f, 0, 0, 0, 0xc0, 0, 0, 0, 0x3f};
    uint64_t expected = 14695981039346656037u;
    for (int i = 0; i < 20; i++)
        expected = (expected ^ bytes[i]) * 1099511628211u;
    assert_true(nsdf_mesh_hash(&view) == expected);
}

static void the_hash_sees_every_part(void **state) {
    (void)state;
    const nsdf_mesh_view plain = without_normals(tetra);
    float positions[12];
    uint32_t indices[12];
    memcpy(positions, tetra_positions, sizeof positions);
    memcpy(indices, tetra_indices, sizeof indices);
    nsdf_mesh_view copy = {positions, tetra_normals, indices, 4, 4};
    assert_true(nsdf_mesh_hash(&tetra) != nsdf_mesh_hash(&plain));
    assert_true(nsdf_mesh_hash(&tetra) == nsdf_mesh_hash(&copy));
    positions[11] = nextafterf(positions[11], 0);
    assert_true(nsdf_mesh_hash(&tetra) != nsdf_mesh_hash(&copy));
    positions[11] = tetra_positions[11];
    indices[11] = 2;
    assert_true(nsdf_mesh_hash(&tetra) != nsdf_mesh_hash(&copy));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(decimals_read_back_equal_and_are_the_shortest),
        cmocka_unit_test(decimals_at_the_ends_of_the_range_read_back),
        cmocka_unit_test(decimals_look_as_expected),
        cmocka_unit_test(integers_are_written_in_full),
        cmocka_unit_test(obj_holds_positions_normals_and_faces_from_one),
        cmocka_unit_test(the_locale_does_not_change_obj),
        cmocka_unit_test(ply_holds_the_header_and_packed_records),
        cmocka_unit_test(stl_holds_face_normals_and_corners),
        cmocka_unit_test(empty_meshes_are_valid_files),
        cmocka_unit_test(long_files_are_written_in_blocks),
        cmocka_unit_test(failing_writes_stop_with_io),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(formats_are_known_by_their_endings),
        cmocka_unit_test(the_hash_is_fnv_1a_of_the_little_endian_bytes),
        cmocka_unit_test(the_hash_sees_every_part),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
