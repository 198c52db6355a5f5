#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "input_file.h"
#include "nsdf/export.h"
#include "obj_read.h"
#include "ply_read.h"
#include "random.h"

/* ---- Files made here ---- */

typedef struct bytes {
    char data[4096];
    size_t size;
} bytes;

static void put_text(bytes *b, const char *text) {
    memcpy(b->data + b->size, text, strlen(text));
    b->size += strlen(text);
}

/* The lowest `size` bytes of a number. */
static void put_bits(bytes *b, uint64_t bits, int size, bool big_endian) {
    for (int i = 0; i < size; i++) {
        b->data[b->size++] = (char)(bits >> 8 * (big_endian ? size - 1 - i : i));
    }
}

static void put_float(bytes *b, float value, bool big_endian) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_bits(b, bits, 4, big_endian);
}

static void put_double(bytes *b, double value, bool big_endian) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_bits(b, bits, 8, big_endian);
}

/* A square and a triangle at its side, with everything around them that a reader must step over. */
static const double positions[5][3] = {{0, 0, 0.5}, {1, 0, -0.25}, {1, 1, 0}, {0, 1, 0}, {2, 0.5, 1e-3f}};
static const char rich_obj[] = "v 0 0 .5\nv 1 0 -.25\nv 1 1 0\nv 0 1 0\nv 2 .5 0.0010000000474974513\n"
                               "f 1 2 3 4\nf 2 5 3\n";

static void put_rich_header(bytes *b, const char *format, const char *line_end) {
    const char *const lines[] = {"ply",
                                 "format",
                                 "comment made by a test",
                                 "obj_info of no use",
                                 "element camera 1",
                                 "property list uchar short view",
                                 "property double focus",
                                 "element nothing 1000000000000",
                                 "element vertex 5",
                                 "property uchar red",
                                 "property float32 x",
                                 "property double z",
                                 "property list ushort float weights",
                                 "property float y",
                                 "element face 2",
                                 "property int8 flags",
                                 "property list uint8 uint vertex_index",
                                 "property list uchar float texcoord",
                                 "end_header"};
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        put_text(b, lines[i]);
        put_text(b, i == 1 ? format : "");
        put_text(b, line_end);
    }
}

static const uint32_t rich_faces[2][4] = {{0, 1, 2, 3}, {1, 4, 2, 0}};

static void make_rich_binary(bytes *b, bool big, const char *line_end) {
    b->size = 0;
    put_rich_header(b, big ? " binary_big_endian 1.0" : " binary_little_endian 1.0", line_end);
    put_bits(b, 2, 1, big);
    put_bits(b, 0x0a0d, 2, big);
    put_bits(b, 7, 2, big);
    put_double(b, 35.0, big);
    for (unsigned i = 0; i < 5; i++) {
        put_bits(b, 200 + i, 1, big);
        put_float(b, (float)positions[i][0], big);
        put_double(b, positions[i][2], big);
        put_bits(b, i, 2, big);
        for (unsigned k = 0; k < i; k++) {
            put_float(b, 0.5f, big);
        }
        put_float(b, (float)positions[i][1], big);
    }
    for (unsigned f = 0; f < 2; f++) {
        put_bits(b, 0xff, 1, big);
        put_bits(b, 4 - f, 1, big);
        for (unsigned k = 0; k < 4 - f; k++) {
            put_bits(b, rich_faces[f][k], 4, big);
        }
        put_bits(b, 0, 1, big);
    }
}

static void make_rich_ascii(bytes *b, const char *line_end) {
    const char *const lines[] = {"2 1 -2 35",
                                 "",
                                 "200 0 .5 0 0",
                                 "201 1 -2.5e-1 1 nan 0 ",
                                 "202 1 0 2 7 7 1",
                                 "\t203 0  0 0 1",
                                 "204 2 0.0010000000474974513 0 .5",
                                 "-1 4 0 1 2 3 0",
                                 "  ",
                                 "-1 3 1 4 2 2 .5 .5"};
    b->size = 0;
    put_rich_header(b, " ascii 1.0", line_end);
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        put_text(b, lines[i]);
        put_text(b, line_end);
    }
}

/* ---- Reading them ---- */

/* Parses a copy of exactly the size needed, so that the address sanitizer sees every step too far. */
static nsdf_status parse_bytes(const char *data, size_t size, nsdf_file_mesh *mesh, nsdf_encoder_error *error) {
    char *copy = malloc(size + 1);
    memcpy(copy, data, size);
    copy[size] = '\0';
    nsdf_status status = nsdf_ply_parse("a.ply", copy, size, mesh, error);
    free(copy);
    return status;
}

/* The mesh of the file is that of rich_obj, triangles too. */
static void assert_rich(const bytes *b) {
    nsdf_file_mesh mesh = {0}, wanted = {0};
    nsdf_encoder_error error = {NSDF_OK, ""};
    if (parse_bytes(b->data, b->size, &mesh, &error) != NSDF_OK) {
        fail_msg("%s", error.message);
    }
    assert_int_equal(nsdf_obj_parse("a.obj", rich_obj, strlen(rich_obj), &wanted, NULL), NSDF_OK);
    assert_int_equal(mesh.vertex_count, 5);
    assert_int_equal(mesh.triangle_count, 3);
    assert_memory_equal(mesh.positions, positions, sizeof positions);
    assert_memory_equal(mesh.positions, wanted.positions, sizeof positions);
    assert_memory_equal(mesh.indices, wanted.indices, 9 * sizeof *mesh.indices);
    nsdf_file_mesh_free(&mesh);
    nsdf_file_mesh_free(&wanted);
}

static void all_formats_and_line_ends_give_the_same_mesh(void **state) {
    (void)state;
    static const char *const line_ends[] = {"\n", "\r\n", "\r"};
    bytes b;
    for (int e = 0; e < 3; e++) {
        make_rich_ascii(&b, line_ends[e]);
        assert_rich(&b);
        b.size -= strlen(line_ends[e]); /* the last line may lack its end */
        assert_rich(&b);
        make_rich_binary(&b, false, line_ends[e]);
        assert_rich(&b);
        make_rich_binary(&b, true, line_ends[e]);
        assert_rich(&b);
        put_text(&b, line_ends[e]);
        assert_rich(&b);
    }
}

static void assert_all_prefixes_fail(const bytes *b, size_t least) {
    nsdf_file_mesh mesh = {0};
    for (size_t size = 0; size < b->size - least; size++) {
        nsdf_encoder_error error = {NSDF_OK, ""};
        assert_int_equal(parse_bytes(b->data, size, &mesh, &error), NSDF_CORRUPT);
        assert_int_equal(mesh.triangle_count, 0);
        assert_memory_equal(error.message, "a.ply:", 6);
    }
    nsdf_file_mesh_free(&mesh);
}

static void every_truncated_file_is_refused(void **state) {
    (void)state;
    bytes b;
    make_rich_binary(&b, false, "\n");
    assert_all_prefixes_fail(&b, 0);
    make_rich_binary(&b, true, "\r\n");
    assert_all_prefixes_fail(&b, 0);
    make_rich_ascii(&b, "\n");
    assert_all_prefixes_fail(&b, 3); /* the last number may lose its digits, not its line */
}

/* Faces may come first: their indices are those of the vertices that the header announces. */
static void faces_may_precede_vertices(void **state) {
    (void)state;
    static const char text[] = "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\n"
                               "element vertex 3\nproperty int x\nproperty int y\nproperty int z\nend_header\n"
                               "3 2 1 0\n0 0 0\n1 0 0\n0 1 0\n";
    nsdf_file_mesh mesh = {0};
    assert_int_equal(parse_bytes(text, strlen(text), &mesh, NULL), NSDF_OK);
    assert_int_equal(mesh.indices[0], 2);
    assert_true(mesh.positions[3] == 1.0);
    nsdf_file_mesh_free(&mesh);
}

static void signed_integers_are_extended(void **state) {
    (void)state;
    bytes b = {.size = 0};
    put_text(&b, "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty char x\nproperty short y\n"
                 "property int z\nelement face 1\nproperty list char short vertex_indices\nend_header\n");
    for (unsigned i = 0; i < 3; i++) {
        put_bits(&b, 0x80 + i, 1, true);
        put_bits(&b, 0xffff, 2, true);
        put_bits(&b, UINT32_C(0x80000000), 4, true);
    }
    put_bits(&b, 3, 1, true);
    for (unsigned i = 0; i < 3; i++) {
        put_bits(&b, i, 2, true);
    }
    nsdf_file_mesh mesh = {0};
    assert_int_equal(parse_bytes(b.data, b.size, &mesh, NULL), NSDF_OK);
    assert_true(mesh.positions[0] == -128.0 && mesh.positions[3] == -127.0);
    assert_true(mesh.positions[1] == -1.0 && mesh.positions[2] == -2147483648.0);
    nsdf_file_mesh_free(&mesh);
}

/* ---- Messages ---- */

static void assert_failure_of(const bytes *b, const char *message) {
    nsdf_file_mesh mesh = {0};
    nsdf_encoder_error error = {NSDF_OK, ""};
    assert_int_equal(parse_bytes(b->data, b->size, &mesh, &error), NSDF_CORRUPT);
    assert_int_equal(error.status, NSDF_CORRUPT);
    assert_string_equal(error.message, message);
    assert_int_equal(mesh.triangle_count, 0);
    assert_int_equal(parse_bytes(b->data, b->size, &mesh, NULL), NSDF_CORRUPT);
    nsdf_file_mesh_free(&mesh);
}

static void assert_failure(const char *text, const char *message) {
    bytes b = {.size = 0};
    put_text(&b, text);
    assert_failure_of(&b, message);
}

#define START "ply\nformat ascii 1.0\n"
#define VERTICES "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
#define FACES "element face 1\nproperty list uchar int vertex_indices\n"
#define HEADER START VERTICES FACES "end_header\n"
#define THREE "0 0 0\n1 0 0\n0 1 0\n"

static void header_errors_name_the_line(void **state) {
    (void)state;
    assert_failure("", "a.ply:1: not a PLY file: expected the line 'ply'");
    assert_failure("plymouth\n", "a.ply:1: not a PLY file: expected the line 'ply'");
    assert_failure("ply ply\n", "a.ply:1: expected nothing after 'ply'");
    assert_failure("ply\nformat ascii 1.0\n",
                   "a.ply:3: the file ends inside its header, expected the line 'end_header'");
    assert_failure("ply\nformat ascii 2.0\n", "a.ply:2: expected 'format', one of ascii, binary_little_endian and "
                                              "binary_big_endian, and '1.0'");
    assert_failure("ply\n\n" VERTICES FACES "end_header\n", "a.ply:9: the header has no line 'format'");
    assert_failure(START "elements 3\n",
                   "a.ply:3: unknown line 'elements', expected format, comment, obj_info, element, property or "
                   "end_header");
    assert_failure(START "element vertex\n", "a.ply:3: expected 'element', a name and a count");
    assert_failure(START "element vertex -3\n", "a.ply:3: malformed count '-3', expected a whole number");
    assert_failure(START "element vertex 9999999999999999999\n",
                   "a.ply:3: malformed count '9999999999999999999', expected a whole number");
    assert_failure(START VERTICES VERTICES, "a.ply:7: a second element 'vertex'");
    assert_failure(START "property float x\n", "a.ply:3: a property before the first element");
}

static void property_errors_name_the_line(void **state) {
    (void)state;
    assert_failure(START "element vertex 3\nproperty float\n",
                   "a.ply:4: expected 'property', a type and a name, or 'property list', two types and a name");
    assert_failure(START "element vertex 3\nproperty real x\n",
                   "a.ply:4: unknown type 'real', expected char, uchar, short, ushort, int, uint, float or double");
    assert_failure(START "element vertex 3\nproperty list uchar float x\n",
                   "a.ply:4: property 'x' must be one number, not a list");
    assert_failure(START VERTICES "property double x\n", "a.ply:7: a second property 'x'");
    assert_failure(START "element face 1\nproperty list float int vertex_indices\n",
                   "a.ply:4: the length of a list must be of an integer type");
    assert_failure(START "element face 1\nproperty list uchar float vertex_indices\n",
                   "a.ply:4: property 'vertex_indices' must be a list of an integer type");
    assert_failure(START FACES "property list uchar int vertex_index\n", "a.ply:5: a second property 'vertex_index'");
    assert_failure(START FACES "end_header\n",
                   "a.ply:5: the header has no element vertex with the properties x, y and z");
    assert_failure(START VERTICES "end_header\n",
                   "a.ply:7: the header has no element face with the property vertex_indices: not a surface");
}

static void headers_beyond_the_limits_are_refused(void **state) {
    (void)state;
    bytes b = {.size = 0};
    put_text(&b, START);
    for (int i = 0; i < 33; i++) {
        put_text(&b, "element a 1\n");
    }
    assert_failure_of(&b, "a.ply:35: more than 32 elements");
    b.size = 0;
    put_text(&b, START "element a 1\n");
    for (int i = 0; i < 257; i++) {
        put_text(&b, "property int a\n");
    }
    assert_failure_of(&b, "a.ply:260: more than 256 properties");
}

static void body_errors_name_the_line(void **state) {
    (void)state;
    assert_failure(HEADER "0 0 0\n1 x 0\n", "a.ply:11: malformed number 'x', expected a finite number");
    assert_failure(HEADER "0 0 0\n\nnan 0 0\n", "a.ply:12: malformed number 'nan', expected a finite number");
    assert_failure(HEADER "0 0 1e999\n1 0 0\n0 1 0\n3 0 1 2\n", "a.ply:10: a coordinate is not a finite number");
    assert_failure(HEADER "0 0\n1 0 0\n", "a.ply:10: the line ends where a number was expected");
    assert_failure(HEADER "0 0 0 0\n", "a.ply:10: more on the line than the header says");
    assert_failure(HEADER THREE, "a.ply:13: the file ends where more vertices, faces or other elements were expected");
    assert_failure(HEADER THREE "3 0 1 3\n", "a.ply:13: face index 3 is out of range (the file has 3 vertices)");
    assert_failure(HEADER THREE "3 0 1 -1\n", "a.ply:13: face index -1 is out of range (the file has 3 vertices)");
    assert_failure(HEADER THREE "3 0 1 2.5\n", "a.ply:13: malformed number '2.5', expected a whole number");
    assert_failure(HEADER THREE "2 0 1\n", "a.ply:13: a face needs at least three vertices");
    assert_failure(HEADER THREE "-1\n", "a.ply:13: a face needs at least three vertices");
    assert_failure(HEADER THREE "3 0 1 2\n3 2 1 0\n", "a.ply:14: more data than the header says");
    assert_failure(START "element vertex 0\nproperty float x\nproperty float y\nproperty float z\n" FACES
                         "end_header\n3 0 0 0\n",
                   "a.ply:10: face index 0 is out of range (the file has 0 vertices)");
}

/* A scanner may leave points that it could not see, which no face uses. */
static void unused_vertices_may_be_anything(void **state) {
    (void)state;
    static const char header[] = "ply\nformat binary_little_endian 1.0\n" VERTICES FACES "end_header\n";
    nsdf_file_mesh mesh = {0};
    bytes b = {.size = 0};
    put_text(&b, header);
    put_bits(&b, UINT32_C(0x7fc00000), 4, false);
    for (int i = 1; i < 9; i++) {
        put_float(&b, (float)i, false);
    }
    put_bits(&b, 3, 1, false);
    put_bits(&b, 1, 4, false);
    put_bits(&b, 2, 4, false);
    put_bits(&b, 1, 4, false);
    assert_int_equal(parse_bytes(b.data, b.size, &mesh, NULL), NSDF_OK);
    assert_int_equal(mesh.triangle_count, 1);
    nsdf_file_mesh_free(&mesh);
}

static void binary_errors_name_the_byte(void **state) {
    (void)state;
    static const char header[] = "ply\nformat binary_little_endian 1.0\n" VERTICES FACES "end_header\n";
    char message[160];
    bytes b = {.size = 0};
    put_text(&b, header);
    for (int i = 0; i < 9; i++) {
        put_float(&b, (float)i, false);
    }
    snprintf(message, sizeof message,
             "a.ply: byte %zu: the file ends where more vertices, faces or other elements were expected", b.size);
    assert_failure_of(&b, message);
    put_bits(&b, 3, 1, false);
    put_bits(&b, 0, 4, false);
    snprintf(message, sizeof message, "a.ply: byte %zu: face index 90 is out of range (the file has 3 vertices)",
             b.size);
    put_bits(&b, 90, 4, false);
    assert_failure_of(&b, message);
    b.size = sizeof header - 1 + 4;
    put_bits(&b, UINT32_C(0x7fc00000), 4, false); /* not a number, in the second coordinate */
    for (int i = 2; i < 9; i++) {
        put_float(&b, (float)i, false);
    }
    put_bits(&b, 3, 1, false);
    for (uint64_t i = 0; i < 3; i++) {
        put_bits(&b, i, 4, false);
    }
    snprintf(message, sizeof message, "a.ply: byte %zu: a coordinate is not a finite number", sizeof header - 1 + 4);
    assert_failure_of(&b, message);
}

/* ---- Hostile files ---- */

static void mutate(bytes *b, nsdf_random *random) {
    for (uint32_t k = 1 + nsdf_random_below(random, 4); k > 0; k--) {
        b->data[nsdf_random_below(random, (uint32_t)b->size)] = (char)nsdf_random_u32(random);
    }
}

/* Mutated files give a mesh or a message; meshes have indices in range.  The sanitizers see the rest. */
static void mutated_files_never_give_indices_out_of_range(void **state) {
    (void)state;
    nsdf_random random = nsdf_random_start(3, 1);
    nsdf_file_mesh mesh = {0};
    int good = 0, bad = 0;
    for (int round = 0; round < 15000; round++) {
        bytes b;
        if (round % 3 == 0) {
            make_rich_ascii(&b, "\n");
        } else {
            make_rich_binary(&b, round % 3 == 1, "\n");
        }
        mutate(&b, &random);
        nsdf_encoder_error error = {NSDF_OK, ""};
        if (parse_bytes(b.data, b.size, &mesh, &error) == NSDF_OK) {
            good++;
            for (size_t i = 0; i < 3 * (size_t)mesh.triangle_count; i++) {
                assert_true(mesh.indices[i] < mesh.vertex_count);
            }
        } else {
            bad++;
            assert_true(error.message[0] != '\0');
        }
    }
    assert_true(good > 1000 && bad > 1000);
    nsdf_file_mesh_free(&mesh);
}

/* Counts that lie end with the file, not with the memory. */
static void huge_counts_are_harmless(void **state) {
    (void)state;
    assert_failure(START
                   "element vertex 999999999999999999\nproperty float x\nproperty float y\nproperty float z\n" FACES
                   "end_header\n0 0 0\n",
                   "a.ply:11: the file ends where more vertices, faces or other elements were expected");
    assert_failure(START VERTICES "element face 1\nproperty list uint int vertex_indices\nend_header\n" THREE
                                  "4000000000 0 1 2\n",
                   "a.ply:13: the line ends where a number was expected");
}

/* ---- Files on disk ---- */

static int put_in_file(void *file, const void *data, size_t size) {
    return fwrite(data, 1, size, file) == size ? 0 : 1;
}

static void write_view(const char *path, const nsdf_mesh_view *view) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(nsdf_write_mesh(view, NSDF_MESH_PLY, put_in_file, file), NSDF_OK);
    fclose(file);
}

static void assert_equals_view(const char *path, const nsdf_mesh_view *view) {
    nsdf_file_mesh mesh = {0};
    nsdf_encoder_error error = {NSDF_OK, ""};
    if (nsdf_input_read_mesh(path, &mesh, &error) != NSDF_OK) {
        fail_msg("%s", error.message);
    }
    assert_int_equal(mesh.vertex_count, view->vertex_count);
    assert_int_equal(mesh.triangle_count, view->triangle_count);
    assert_memory_equal(mesh.indices, view->indices, 12 * (size_t)view->triangle_count);
    for (size_t i = 0; i < 3 * (size_t)view->vertex_count; i++) {
        assert_true(mesh.positions[i] == (double)view->positions[i]);
    }
    nsdf_file_mesh_free(&mesh);
}

/* Whatever the file is called: its first line says what it is. */
static void what_the_decoder_writes_reads_back_equal(void **state) {
    (void)state;
    static const float points[12] = {0, 0, 0, 1.5f, 0, 1e-30f, 0, -2, 0.1f, 3e38f, 1e-7f, 13.0f};
    static const float normals[12] = {1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 1};
    static const uint32_t indices[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    nsdf_mesh_view view = {points, normals, indices, 4, 4};
    char path[] = "/tmp/nsdf-ply-XXXXXX";
    close(mkstemp(path));
    write_view(path, &view);
    assert_equals_view(path, &view);
    view.normals = NULL;
    write_view(path, &view);
    assert_equals_view(path, &view);
    unlink(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_formats_and_line_ends_give_the_same_mesh),
        cmocka_unit_test(every_truncated_file_is_refused),
        cmocka_unit_test(faces_may_precede_vertices),
        cmocka_unit_test(signed_integers_are_extended),
        cmocka_unit_test(header_errors_name_the_line),
        cmocka_unit_test(property_errors_name_the_line),
        cmocka_unit_test(headers_beyond_the_limits_are_refused),
        cmocka_unit_test(body_errors_name_the_line),
        cmocka_unit_test(unused_vertices_may_be_anything),
        cmocka_unit_test(binary_errors_name_the_byte),
        cmocka_unit_test(mutated_files_never_give_indices_out_of_range),
        cmocka_unit_test(huge_counts_are_harmless),
        cmocka_unit_test(what_the_decoder_writes_reads_back_equal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
