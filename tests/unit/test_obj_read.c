#include <locale.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "input_file.h"
#include "obj_number.h"
#include "obj_read.h"
#include "random.h"

/* Parses a copy of exactly the size needed, so that the address sanitizer sees every step too far. */
static nsdf_status parse_bytes(const char *text, size_t size, nsdf_file_mesh *mesh, nsdf_encoder_error *error) {
    char *copy = malloc(size + 1);
    memcpy(copy, text, size);
    copy[size] = '\0';
    nsdf_status status = nsdf_obj_parse("a.obj", copy, size, mesh, error);
    free(copy);
    return status;
}

static void assert_mesh(const char *text, uint32_t vertices, const char *triangles) {
    nsdf_file_mesh mesh = {0};
    nsdf_encoder_error error = {NSDF_OK, ""};
    char got[256] = "";
    if (parse_bytes(text, strlen(text), &mesh, &error) != NSDF_OK) {
        fail_msg("%s", error.message);
    }
    assert_int_equal(mesh.vertex_count, vertices);
    for (size_t i = 0; i < 3 * (size_t)mesh.triangle_count; i++) {
        size_t length = strlen(got);
        snprintf(got + length, sizeof got - length, "%s%u", i == 0 ? "" : i % 3 == 0 ? ", " : " ", mesh.indices[i]);
    }
    assert_string_equal(got, triangles);
    nsdf_file_mesh_free(&mesh);
}

static void assert_failure(const char *text, const char *message) {
    nsdf_file_mesh mesh = {0};
    nsdf_encoder_error error = {NSDF_OK, ""};
    assert_int_equal(parse_bytes(text, strlen(text), &mesh, &error), NSDF_CORRUPT);
    assert_int_equal(error.status, NSDF_CORRUPT);
    assert_string_equal(error.message, message);
    assert_int_equal(mesh.triangle_count, 0);
    assert_int_equal(parse_bytes(text, strlen(text), &mesh, NULL), NSDF_CORRUPT);
    nsdf_file_mesh_free(&mesh);
}

#define THREE "v 0 0 0\nv 1 0 0\nv 0 1 0\n"

static void every_form_of_face_is_read(void **state) {
    (void)state;
    assert_mesh(THREE "f 1 2 3\n", 3, "0 1 2");
    assert_mesh(THREE "f 1/4 2/5 3/6\n", 3, "0 1 2");
    assert_mesh(THREE "f 1//4 2//5 3//6\n", 3, "0 1 2");
    assert_mesh(THREE "f 1/4/7 2/5/8 3/6/-1\n", 3, "0 1 2");
    assert_mesh(THREE "f -3 -2 -1\nv 5 5 5\nf -1 -2 -3", 4, "0 1 2, 3 2 1");
    assert_mesh("f 1 2 3\n" THREE, 3, "0 1 2");
}

static void vertices_may_have_more_than_three_numbers(void **state) {
    (void)state;
    assert_mesh("v 0 0 0 1\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0 whatever\nf 1 2 3\n", 3, "0 1 2");
}

static void line_ends_blanks_comments_and_other_records_are_understood(void **state) {
    (void)state;
    assert_mesh("v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n", 3, "0 1 2");
    assert_mesh("v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r", 3, "0 1 2");
    assert_mesh(
        "# a\n\n  \t v\t0  0 0 \n v 1 0 0 # b\nv 0 1 0 #c\nvn 0 0 x\nvt\no f 1 2 9\ng\ns off\nusemtl v\nf 1 2 3 # 9", 3,
        "0 1 2");
    assert_mesh("v 0 \\\n0 \\\r\n0\nv 1 0 0\nv 0 1 0\nf 1 2\\\n 3\n", 3, "0 1 2");
    assert_mesh("\xef\xbb\xbf" THREE "f 1 2 3", 3, "0 1 2");
    assert_mesh("# C:\\models\\\n" THREE "f 1 2 3", 3, "0 1 2");
}

static void quadrilaterals_are_cut_well(void **state) {
    (void)state;
    assert_mesh("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1.1 0\nf 1 2 3 4\n", 4, "0 1 2, 0 2 3");
    assert_mesh("v 0 0 0\nv 1 0 0\nv 3 3 0\nv 0 1 0\nf 1 2 3 4\n", 4, "1 2 3, 1 3 0");
    /* An arrow head: the short diagonal is outside. */
    assert_mesh("v 0 0 0\nv 3 -1 0\nv 0.5 0 0\nv 3 1 0\nf 2 3 4 1\n", 4, "2 3 0, 2 0 1");
}

static double signed_area(const nsdf_file_mesh *m, uint32_t t) {
    const double *p[3];
    for (uint32_t k = 0; k < 3; k++) {
        p[k] = &m->positions[3 * m->indices[3 * t + k]];
    }
    return 0.5 * ((p[1][0] - p[0][0]) * (p[2][2] - p[0][2]) - (p[1][2] - p[0][2]) * (p[2][0] - p[0][0]));
}

static void concave_polygons_are_clipped_without_overlap(void **state) {
    (void)state;
    /* A comb in the plane y = 2: area 8, none of its 8 triangles may be turned over. */
    const char *comb = "v 0 2 0\nv 5 2 0\nv 5 2 2\nv 4 2 2\nv 4 2 1\nv 3 2 1\nv 3 2 2\nv 1 2 2\nv 1 2 1\nv 0 2 1\n"
                       "f 1 2 3 4 5 6 7 8 9 10\n";
    nsdf_file_mesh mesh = {0};
    assert_int_equal(parse_bytes(comb, strlen(comb), &mesh, NULL), NSDF_OK);
    assert_int_equal(mesh.triangle_count, 8);
    double area = 0.0;
    for (uint32_t t = 0; t < 8; t++) {
        assert_true(signed_area(&mesh, t) >= 0.0);
        area += signed_area(&mesh, t);
    }
    assert_true(fabs(area - 8.0) < 1e-12);
    nsdf_file_mesh_free(&mesh);
}

static void polygons_of_many_corners_are_fans(void **state) {
    (void)state;
    char *text = malloc(100000);
    int n = 0;
    for (int i = 0; i < 300; i++) {
        n += sprintf(text + n, "v %d %d 0\n", i, i * i);
    }
    n += sprintf(text + n, "f");
    for (int i = 1; i <= 300; i++) {
        n += sprintf(text + n, " %d", i);
    }
    nsdf_file_mesh mesh = {0};
    assert_int_equal(parse_bytes(text, (size_t)n, &mesh, NULL), NSDF_OK);
    assert_int_equal(mesh.triangle_count, 298);
    assert_int_equal(mesh.indices[3 * 297], 0);
    nsdf_file_mesh_free(&mesh);
    free(text);
}

static void coordinate_errors_name_the_line(void **state) {
    (void)state;
    assert_failure("v 0 0 0\nv 1 nan 0\nf 1 2 1\n", "a.obj:2: coordinate 'nan' is not a finite number");
    assert_failure("v 0 0 -Inf\nf 1 1 1\n", "a.obj:1: coordinate '-Inf' is not a finite number");
    assert_failure("v inf nan 0\nv 0 0 0\nv 1 nan 0\nf 2 3 2\n", "a.obj:3: coordinate 'nan' is not a finite number");
    assert_failure("v 0 0 1e999\n", "a.obj:1: coordinate '1e999' is too large");
    assert_failure("\n\nv 0 0\n", "a.obj:3: a vertex needs three coordinates");
    assert_failure("v", "a.obj:1: a vertex needs three coordinates");
    assert_failure("v 0 \\\n 0 # 0", "a.obj:2: a vertex needs three coordinates");
    assert_failure("v 0 0,5 0\n", "a.obj:1: malformed coordinate '0,5', expected a number");
    assert_failure("#\r\n#\rv 0 1.#QNAN 0\n", "a.obj:3: malformed coordinate '1.#QNAN', expected a number");
    assert_failure("v 0 - 0\n", "a.obj:1: malformed coordinate '-', expected a number");
    assert_failure("v . 0 0\n", "a.obj:1: malformed coordinate '.', expected a number");
    assert_failure("v 1e 0 0\n", "a.obj:1: malformed coordinate '1e', expected a number");
}

static void face_errors_name_the_line(void **state) {
    (void)state;
    assert_failure(THREE "f 1 2 0\n", "a.obj:4: face index 0: indices start at 1");
    assert_failure(THREE "f 1 2 3\nf 1 2 90\nf 1 2 91\nv 1 1 1\n",
                   "a.obj:5: face index 90 is out of range (the file has 4 vertices)");
    assert_failure(THREE "f -1 -2 -4\nv 0 0 0\n",
                   "a.obj:4: face index -4 is out of range (the file has 3 vertices so far)");
    assert_failure(THREE "f 1 2 99999999999999999999\n",
                   "a.obj:4: face index 9007199254740992 is out of range (the file has 3 vertices)");
    assert_failure(THREE "f 1 2\n", "a.obj:4: a face needs at least three vertices");
    assert_failure(THREE "f\n", "a.obj:4: a face needs at least three vertices");
    assert_failure(THREE "f 1 2 x\n", "a.obj:4: malformed face index 'x', expected v, v/vt, v//vn or v/vt/vn");
    assert_failure(THREE "f 1 2 3.5\n", "a.obj:4: malformed face index '3.5', expected v, v/vt, v//vn or v/vt/vn");
    assert_failure(THREE "f 1 2 3/1/1/1\n",
                   "a.obj:4: malformed face index '3/1/1/1', expected v, v/vt, v//vn or v/vt/vn");
}

static void files_without_a_surface_are_refused(void **state) {
    (void)state;
    assert_failure("", "a.obj: no vertices");
    assert_failure("<html>\n<p>not found</p>\n", "a.obj: no vertices");
    assert_failure("v 0 0 0\n", "a.obj: no faces");
}

static void binary_files_are_refused_at_once(void **state) {
    (void)state;
    nsdf_encoder_error error;
    nsdf_file_mesh mesh = {0};
    assert_int_equal(parse_bytes("PK\003\004\024\000\000\000", 8, &mesh, &error), NSDF_CORRUPT);
    assert_string_equal(error.message, "a.obj: not an OBJ text file (it holds binary data)");
    char late[8192];
    memset(late, '\n', sizeof late);
    late[6000] = '\0';
    assert_int_equal(parse_bytes(late, sizeof late, &mesh, &error), NSDF_CORRUPT);
    assert_string_equal(error.message, "a.obj:6001: a zero byte: this is not an OBJ text file");
    nsdf_file_mesh_free(&mesh);
}

static void long_names_are_shown_by_their_end(void **state) {
    (void)state;
    char name[400];
    memset(name, 'x', sizeof name);
    strcpy(name + 390, "end.obj");
    nsdf_file_mesh mesh = {0};
    nsdf_encoder_error error;
    assert_int_equal(nsdf_obj_parse(name, "", 0, &mesh, &error), NSDF_CORRUPT);
    assert_non_null(strstr(error.message, "xend.obj: no vertices"));
    assert_memory_equal(error.message, "...xxx", 6);
}

static void files_are_read_and_other_things_refused(void **state) {
    (void)state;
    char folder[] = "/tmp/nsdf-obj-XXXXXX", path[64];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/a.obj", folder);
    nsdf_file_mesh mesh = {0};
    nsdf_encoder_error error;
    assert_int_equal(nsdf_input_read_mesh(path, &mesh, &error), NSDF_IO);
    assert_non_null(strstr(error.message, "a.obj: no such file"));
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(THREE "f 3 2 1", file);
    fclose(file);
    assert_int_equal(nsdf_input_read_mesh(path, &mesh, &error), NSDF_OK);
    assert_int_equal(mesh.indices[0], 2);
    assert_true(mesh.positions[3] == 1.0);
    assert_int_equal(nsdf_input_read_mesh(folder, &mesh, &error), NSDF_IO);
    assert_non_null(strstr(error.message, ": not a regular file"));
    nsdf_file_mesh_free(&mesh);
    unlink(path);
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_int_equal(nsdf_input_read_mesh(path, &mesh, &error), NSDF_IO);
    unlink(path);
    rmdir(folder);
}

static void assert_number(const char *text, double tolerance_ulp) {
    double got = 0.0, wanted = strtod(text, NULL);
    const char *end = nsdf_read_number(text, &got);
    assert_ptr_equal(end, text + strlen(text));
    if (isinf(wanted) || wanted == 0.0) {
        assert_true(got == wanted);
        return;
    }
    double ulp = nextafter(fabs(wanted), INFINITY) - fabs(wanted);
    if (!(fabs(got - wanted) <= tolerance_ulp * ulp)) {
        fail_msg("%s: got %.17g, wanted %.17g", text, got, wanted);
    }
}

static void numbers_are_rounded_as_strtod_does(void **state) {
    (void)state;
    static const char *const texts[] = {"0",
                                        "-0.0",
                                        "+1.5",
                                        "1e3",
                                        ".5",
                                        "5.",
                                        "0.1",
                                        "1E-22",
                                        "1e22",
                                        "1e23",
                                        "1e308",
                                        "1e309",
                                        "1e-320",
                                        "9007199254740993",
                                        "4.9406564584124654e-324",
                                        "1.7976931348623157e308",
                                        "2.2250738585072011e-308",
                                        "0e999999999999",
                                        "1e-999999999999",
                                        "123456789012345678901234567890",
                                        "0.000000000000000000000000000000123456789012345678",
                                        "1e99999999999"};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        assert_number(texts[i], 1.0);
    }
    nsdf_random random = nsdf_random_start(1, 1);
    for (int i = 0; i < 100000; i++) {
        char text[64];
        double magnitude = pow(10.0, (double)nsdf_random_unit(&random) * 40.0 - 20.0);
        double x = ((double)nsdf_random_unit(&random) - 0.5) * magnitude;
        snprintf(text, sizeof text, "%.*f", (int)(nsdf_random_u32(&random) % 10), x > 1e5 || x < -1e5 ? x / 1e15 : x);
        assert_number(text, 0.0);
        snprintf(text, sizeof text, "%.*g", 1 + (int)(nsdf_random_u32(&random) % 17), x);
        assert_number(text, 0.0);
    }
}

static void numbers_do_not_depend_on_the_locale(void **state) {
    (void)state;
    if (setlocale(LC_ALL, "de_DE.UTF-8") == NULL) {
        skip();
    }
    double value = 0.0;
    assert_non_null(nsdf_read_number("1.25", &value));
    (void)setlocale(LC_ALL, "C");
    assert_true(value == 1.25);
}

/* Mutated files give a mesh or a message; meshes have indices in range.  The sanitizers see the rest. */
static void mutated_files_never_give_indices_out_of_range(void **state) {
    (void)state;
    static const char seed[] = "# s\r\nv 0 0.5e1 -1\nv 1 0 \\\n 0 1\nv 0 1 0\nv 2 2 2\nf 1/2/3 2//1 3\nf -1 -2 -3 -4\n";
    static const char alphabet[] = "vf 0123456789.-+/e#\\\n\r\tnai";
    nsdf_random random = nsdf_random_start(2, 1);
    nsdf_file_mesh mesh = {0};
    int good = 0, bad = 0;
    for (int round = 0; round < 20000; round++) {
        char text[sizeof seed];
        memcpy(text, seed, sizeof seed);
        for (uint32_t k = nsdf_random_below(&random, 6); k > 0; k--) {
            uint32_t at = nsdf_random_below(&random, sizeof seed - 1), any = nsdf_random_u32(&random);
            text[at] = any % 16 == 0 ? (char)(any >> 8) : alphabet[(any >> 8) % (sizeof alphabet - 1)];
        }
        nsdf_encoder_error error = {NSDF_OK, ""};
        size_t size = sizeof seed - 1 - (round % 2 ? nsdf_random_below(&random, sizeof seed - 1) : 0);
        if (parse_bytes(text, size, &mesh, &error) == NSDF_OK) {
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_form_of_face_is_read),
        cmocka_unit_test(vertices_may_have_more_than_three_numbers),
        cmocka_unit_test(line_ends_blanks_comments_and_other_records_are_understood),
        cmocka_unit_test(quadrilaterals_are_cut_well),
        cmocka_unit_test(concave_polygons_are_clipped_without_overlap),
        cmocka_unit_test(polygons_of_many_corners_are_fans),
        cmocka_unit_test(coordinate_errors_name_the_line),
        cmocka_unit_test(face_errors_name_the_line),
        cmocka_unit_test(files_without_a_surface_are_refused),
        cmocka_unit_test(binary_files_are_refused_at_once),
        cmocka_unit_test(long_names_are_shown_by_their_end),
        cmocka_unit_test(files_are_read_and_other_things_refused),
        cmocka_unit_test(numbers_are_rounded_as_strtod_does),
        cmocka_unit_test(numbers_do_not_depend_on_the_locale),
        cmocka_unit_test(mutated_files_never_give_indices_out_of_range),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
