#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "input_file.h"
#include "stl_read.h"

#include <stdio.h>
#include <string.h>

#define FACET "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1.5 0\n endloop\nendfacet\n"

static nsdf_status parse(const char *text, size_t size, nsdf_file_mesh *mesh, nsdf_encoder_error *error) {
    return nsdf_stl_parse("a.stl", text, size, mesh, error);
}

static void expect_failure(const char *text, const char *message) {
    nsdf_file_mesh mesh = {0};
    nsdf_encoder_error error;
    assert_int_equal(parse(text, strlen(text), &mesh, &error), NSDF_CORRUPT);
    assert_string_equal(error.message, message);
    assert_int_equal(mesh.triangle_count, 0);
    nsdf_file_mesh_free(&mesh);
}

static void ascii_files_give_their_triangles(void **state) {
    static const char text[] = "solid facet of a thing\r\n" FACET FACET "endsolid\nSOLID two\n" FACET "EndSolid two";
    nsdf_file_mesh mesh = {0};
    (void)state;
    assert_int_equal(parse(text, strlen(text), &mesh, NULL), NSDF_OK);
    assert_true(mesh.triangle_count == 3 && mesh.vertex_count == 9);
    assert_true(mesh.positions[3 * 8 + 1] == 1.5 && mesh.positions[3 * 7] == 1.0);
    nsdf_file_mesh_free(&mesh);
}

static void ascii_errors_name_the_line(void **state) {
    (void)state;
    expect_failure("", "a.stl: no vertices");
    expect_failure("solid\nendsolid\n", "a.stl: no vertices");
    expect_failure("v 0 0 0\n",
                   "a.stl:1: expected 'facet', 'endsolid' or 'solid': this is no STL file, or it is cut off");
    expect_failure("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0\nvertex 0 1 0\n",
                   "a.stl:6: a vertex needs three finite coordinates");
    expect_failure("solid\nfacet\nouter loop\nvertex 0 0 nan\n", "a.stl:4: a vertex needs three finite coordinates");
    expect_failure("solid\nfacet\nouter\nvertex 0 0 0\n", "a.stl:4: expected 'outer loop'");
    expect_failure("solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 0 0 1\nendloop",
                   "a.stl:6: expected three times 'vertex', then 'endloop' and 'endfacet'");
}

/* A binary file of `count` triangles, which may begin with "solid" as well. */
static size_t make_binary(char *bytes, uint32_t count) {
    static const float corners[12] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1.5f, 0};
    memset(bytes, 0, 84 + 50 * (size_t)count);
    memcpy(bytes, "solid", 5);
    memcpy(bytes + 80, &count, 4);
    for (size_t i = 0; i < count; i++)
        memcpy(bytes + 84 + 50 * i, corners, sizeof corners);
    return 84 + 50 * (size_t)count;
}

static void binary_files_give_their_triangles(void **state) {
    char bytes[400];
    nsdf_file_mesh mesh = {0};
    nsdf_encoder_error error;
    (void)state;
    size_t size = make_binary(bytes, 3);
    assert_int_equal(parse(bytes, size, &mesh, NULL), NSDF_OK);
    assert_true(mesh.triangle_count == 3 && mesh.vertex_count == 9 && mesh.positions[3 * 8 + 1] == 1.5);
    memset(bytes + 84 + 50 + 12 + 12, 0xff, 4);
    assert_int_equal(parse(bytes, size, &mesh, &error), NSDF_CORRUPT);
    assert_string_equal(error.message, "a.stl: byte 158: a coordinate is not a finite number");
    size = make_binary(bytes, 3);
    bytes[size - 1] = 0;
    assert_int_equal(parse(bytes, size - 1, &mesh, &error), NSDF_CORRUPT);
    assert_non_null(strstr(error.message, "zero byte"));
    nsdf_file_mesh_free(&mesh);
}

/* A triangle moved by its node, in a file of text with its buffer in it. */
static void gltf_nodes_place_their_meshes(void **state) {
    static const char text[] =
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
        "\"nodes\":[{\"children\":[1],\"translation\":[10,0,0]},{\"mesh\":0,\"scale\":[2,3,4],"
        "\"rotation\":[0,0,0.7071067811865476,0.7071067811865476]}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],"
        "\"max\":[1,1,0]}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"byteLength\":36,\"uri\":"
        "\"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}";
    static const double wanted[9] = {10, 0, 0, 10, 2, 0, 7, 0, 0};
    nsdf_file_mesh mesh = {0};
    nsdf_encoder_error error;
    (void)state;
    FILE *file = fopen("test_gltf_read.gltf", "wb");
    assert_true(file && fputs(text, file) >= 0 && fclose(file) == 0);
    const nsdf_status status = nsdf_input_read_mesh("test_gltf_read.gltf", &mesh, &error);
    remove("test_gltf_read.gltf");
    if (status == NSDF_UNSUPPORTED_FEATURE)
        skip();
    assert_int_equal(status, NSDF_OK);
    assert_int_equal(mesh.triangle_count, 1);
    for (int i = 0; i < 9; i++)
        assert_float_equal(mesh.positions[i], wanted[i], 1e-6);
    nsdf_file_mesh_free(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ascii_files_give_their_triangles),
        cmocka_unit_test(ascii_errors_name_the_line),
        cmocka_unit_test(binary_files_give_their_triangles),
        cmocka_unit_test(gltf_nodes_place_their_meshes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
