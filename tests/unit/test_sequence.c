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

#include "nsdf/sequence.h"
#include "number_pattern.h"
#include "sequence_paths.h"

#define TRIANGLE "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"

static void write_file(const char *name, const char *text) {
    FILE *file = fopen(name, "wb");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static const char *const files[] = {
    "w/frame2.obj", "w/frame10.obj", "w/frame1.OBJ", "w/.hidden.obj",    "w/notes.md", "w/a_0001.obj",
    "w/a_0003.obj", "w/a_12345.obj", "w/a_02.obj",   "w/a_00012345.obj", "p/x7y.obj",  "p/x10y.obj",
    "p/x07y.obj",   "p/100%.obj",    "q/b10.ply",    "q/b9.PLY",         "w/b1.ply",   "p/bad.obj"};
static const char *const folders[] = {"w/sub.obj", "w", "p", "q", "empty"};

/* Works in a folder of its own, so that messages are predictable. */
static int enter_folder(void **state) {
    char *folder = strdup("/tmp/nsdf-sequence-XXXXXX");
    if (folder == NULL || mkdtemp(folder) == NULL || chdir(folder) != 0) {
        return -1;
    }
    *state = folder;
    for (size_t i = sizeof folders / sizeof folders[0]; i-- > 0;) {
        if (mkdir(folders[i], 0700) != 0) {
            return -1;
        }
    }
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        write_file(files[i], i + 1 < sizeof files / sizeof files[0] ? TRIANGLE : "v 0 0 0\nv 1 0 0\nf 1 2 7\n");
    }
    return 0;
}

static int leave_folder(void **state) {
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        unlink(files[i]);
    }
    unlink("w/list.txt");
    unlink("w/with 3 blanks 4.obj");
    for (size_t i = 0; i < sizeof folders / sizeof folders[0]; i++) {
        rmdir(folders[i]);
    }
    int result = chdir("/") | rmdir(*state);
    free(*state);
    return result;
}

static void assert_frames(const char *input, const char *wanted) {
    nsdf_sequence *sequence = NULL;
    nsdf_encoder_error error = {NSDF_OK, ""};
    char got[1024] = "";
    if (nsdf_sequence_open(&sequence, &input, 1, NULL, &error) != NSDF_OK) {
        fail_msg("%s", error.message);
    }
    for (uint32_t i = 0; i < nsdf_sequence_mesh_count(sequence); i++) {
        strcat(got, i == 0 ? "" : " ");
        strcat(got, nsdf_sequence_frame_path(sequence, nsdf_sequence_mesh_frame(sequence, i)));
    }
    assert_null(nsdf_sequence_frame_path(sequence, nsdf_sequence_frame_count(sequence)));
    assert_string_equal(got, wanted);
    nsdf_sequence_close(&sequence);
    assert_null(sequence);
}

static void assert_failure(const char *input, nsdf_status status, const char *message) {
    nsdf_sequence *sequence = (nsdf_sequence *)&sequence;
    nsdf_encoder_error error = {NSDF_OK, ""};
    assert_int_equal(nsdf_sequence_open(&sequence, &input, 1, NULL, &error), status);
    assert_int_equal(error.status, status);
    assert_string_equal(error.message, message);
    assert_ptr_equal(sequence, &sequence);
}

static void folders_list_their_obj_files_in_natural_order(void **state) {
    (void)state;
    assert_frames("w", "w/a_0001.obj w/a_02.obj w/a_0003.obj w/a_00012345.obj w/a_12345.obj w/frame1.OBJ w/frame2.obj "
                       "w/frame10.obj");
    assert_frames("p/", "p/100%.obj p/bad.obj p/x07y.obj p/x7y.obj p/x10y.obj");
}

static void folders_without_obj_files_list_their_ply_files(void **state) {
    (void)state;
    assert_frames("q", "q/b9.PLY q/b10.ply");
}

static void printf_patterns_find_the_numbers_that_exist(void **state) {
    (void)state;
    assert_frames("w/a_%04d.obj", "w/a_0001.obj w/a_0003.obj w/a_12345.obj");
    assert_frames("w/a_%02d.obj", "w/a_02.obj w/a_12345.obj");
    assert_frames("p/x%dy.obj", "p/x7y.obj p/x10y.obj");
}

static void globs_expand_in_natural_order(void **state) {
    (void)state;
    assert_frames("w/frame*", "w/frame1.OBJ w/frame2.obj w/frame10.obj");
    assert_frames("?/x[17]*", "p/x7y.obj p/x10y.obj");
}

static void list_files_are_relative_to_their_folder(void **state) {
    (void)state;
    write_file("w/list.txt", "# frames\n\n  frame10.obj \r\n\t../p/x7y.obj\nframe2.obj");
    assert_frames("w/list.txt", "w/frame10.obj w/../p/x7y.obj w/frame2.obj");
}

static void existing_files_are_taken_whatever_their_name(void **state) {
    (void)state;
    assert_frames("p/100%.obj", "p/100%.obj");
    assert_frames("w/notes.md", "w/notes.md");
}

static void inputs_keep_their_order(void **state) {
    (void)state;
    const char *const inputs[2] = {"w/frame10.obj", "p/x%dy.obj"};
    nsdf_sequence *sequence = NULL;
    assert_int_equal(nsdf_sequence_open(&sequence, inputs, 2, NULL, NULL), NSDF_OK);
    assert_int_equal(nsdf_sequence_frame_count(sequence), 3);
    assert_string_equal(nsdf_sequence_frame_path(sequence, 0), "w/frame10.obj");
    assert_string_equal(nsdf_sequence_frame_path(sequence, 2), "p/x10y.obj");
    nsdf_sequence_close(&sequence);
}

/* ---- Times ---- */

/* The numbers of the frames of files whose names are in `names`, between blanks; all in the folder "t". */
static void assert_numbers(const char *names, int ignore, const char *wanted, const char *missing) {
    char paths[8][32], all[256], got[256] = "", text[256];
    const char *inputs[8];
    size_t count = 0;
    snprintf(all, sizeof all, "%s", names);
    assert_int_equal(mkdir("t", 0700), 0);
    for (char *name = strtok(all, " "); name != NULL; name = strtok(NULL, " ")) {
        snprintf(paths[count], sizeof paths[count], "t/%s", name);
        write_file(paths[count], TRIANGLE);
        inputs[count] = paths[count];
        count++;
    }
    nsdf_sequence *sequence = NULL;
    nsdf_sequence_options options;
    nsdf_encoder_error error;
    nsdf_sequence_options_init(&options);
    options.ignore_numbers = ignore;
    if (nsdf_sequence_open(&sequence, inputs, count, &options, &error) != NSDF_OK) {
        fail_msg("%s", error.message);
    }
    assert_int_equal(nsdf_sequence_mesh_count(sequence), count);
    assert_int_equal(nsdf_sequence_mesh_frame(sequence, (uint32_t)count), UINT32_MAX);
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t frame = nsdf_sequence_mesh_frame(sequence, i);
        snprintf(got + strlen(got), sizeof got - strlen(got), "%s%u", i > 0 ? " " : "", frame);
        assert_string_equal(nsdf_sequence_frame_path(sequence, frame), inputs[i]);
    }
    assert_string_equal(got, wanted);
    const uint32_t last = nsdf_sequence_mesh_frame(sequence, (uint32_t)count - 1);
    assert_int_equal(nsdf_sequence_frame_count(sequence), last + 1);
    assert_int_equal(nsdf_sequence_missing(sequence, text, sizeof text), last + 1 - count);
    assert_string_equal(text, missing);
    nsdf_sequence_close(&sequence);
    for (size_t i = 0; i < count; i++) {
        unlink(paths[i]);
    }
    assert_int_equal(rmdir("t"), 0);
}

static void numbers_of_files_tell_their_frames(void **state) {
    (void)state;
    assert_numbers("f_0.obj f_1.obj f_3.obj", 0, "0 1 3", "2");
    assert_numbers("f_0.obj f_1.obj f_3.obj", 1, "0 1 2", "");
    assert_numbers("f_1007.obj f_1008.obj f_1012.obj f_1013.obj f_1015.obj", 0, "0 1 5 6 8", "1009-1011, 1014");
    /* Wherever the number is, and with a step that all differences share. */
    assert_numbers("f_9.v2.obj f_10.v2.obj f_12.v2.obj", 0, "0 1 3", "11");
    assert_numbers("f_0010.obj f_0020.obj f_0050.obj", 0, "0 1 4", "30-40");
    assert_numbers("f_1.obj f_9.obj", 0, "0 1", "");
    /* Names that are not alike follow each other. */
    assert_numbers("a_0.obj a_2.obj a_3.obj b_7.obj b_8.obj c.obj", 0, "0 2 3 4 5 6", "1");
    /* Numbers that do not ascend say nothing. */
    assert_numbers("f_0.obj f_2.obj f_5.obj f_4.obj", 0, "0 1 2 3", "");
    assert_numbers("f_0.obj f_2.obj f_5.obj f_05.obj", 0, "0 1 2 3", "");
}

static void numbers_too_far_apart_are_refused(void **state) {
    (void)state;
    const char *const inputs[3] = {"t1.obj", "t2.obj", "t4294967297.obj"};
    nsdf_sequence *sequence = NULL;
    nsdf_encoder_error error;
    for (size_t i = 0; i < 3; i++) {
        write_file(inputs[i], TRIANGLE);
    }
    assert_int_equal(nsdf_sequence_open(&sequence, inputs, 3, NULL, &error), NSDF_LIMIT);
    assert_string_equal(error.message, "t4294967297.obj: its number is too far from that of the first file to count "
                                       "frames; --numbers ignore takes files one after the other");
    for (size_t i = 0; i < 3; i++) {
        unlink(inputs[i]);
    }
}

/* Numbers of the frames of w/list.txt at a rate. */
static void assert_list(const char *text, uint32_t rate_num, uint32_t rate_den, const char *wanted) {
    const char *input = "w/list.txt";
    char got[256] = "", missing[32];
    nsdf_sequence *sequence = NULL;
    nsdf_sequence_options options;
    nsdf_encoder_error error;
    write_file(input, text);
    nsdf_sequence_options_init(&options);
    options.rate_num = rate_num;
    options.rate_den = rate_den;
    if (nsdf_sequence_open(&sequence, &input, 1, &options, &error) != NSDF_OK) {
        snprintf(got, sizeof got, "%s", error.message);
    }
    for (uint32_t i = 0; i < nsdf_sequence_mesh_count(sequence); i++) {
        snprintf(got + strlen(got), sizeof got - strlen(got), "%s%u", i > 0 ? " " : "",
                 nsdf_sequence_mesh_frame(sequence, i));
    }
    (void)nsdf_sequence_missing(sequence, missing, sizeof missing);
    assert_string_equal(missing, "");
    assert_string_equal(got, wanted);
    nsdf_sequence_close(&sequence);
}

static void list_files_may_tell_times(void **state) {
    (void)state;
    assert_list("frame1.OBJ 0\nframe2.obj\t0.04\n# c\nframe10.obj  1.6e-1 \n", 25, 1, "0 1 4");
    /* From the first on, and as near as milliseconds come. */
    assert_list("frame1.OBJ 10\nframe2.obj 10.033\nframe10.obj 10.1\n", 30000, 1001, "0 1 3");
    /* Names with blanks and numbers are names. */
    write_file("w/with 3 blanks 4.obj", TRIANGLE);
    assert_list("frame2.obj\nwith 3 blanks 4.obj\n", 25, 1, "0 1");
    assert_list("frame2.obj 0\nwith 3 blanks 4.obj 0.08\n", 25, 1, "0 2");
    /* Without times, numbers count here too. */
    assert_list("a_0001.obj\na_02.obj\n", 25, 1, "0 1");
    assert_list("frame1.OBJ\nframe2.obj\nframe10.obj\n", 25, 1, "0 1 9");
}

static void times_that_cannot_be_are_refused_by_line(void **state) {
    (void)state;
    assert_list("frame1.OBJ 0\nframe2.obj 0.04\nframe10.obj 0.04\n", 25, 1,
                "w/list.txt:3: the time 0.04 s does not come after 0.04 s in line 2");
    assert_list("frame1.OBJ 0.2\n\nframe2.obj 0.1\n", 25, 1,
                "w/list.txt:3: the time 0.1 s does not come after 0.2 s in line 1");
    assert_list("frame1.OBJ -0.04\n", 25, 1, "w/list.txt:1: the time -0.04 s is negative");
    assert_list("frame1.OBJ 1e999\n", 25, 1, "w/list.txt:1: the time inf s is not finite");
    assert_list("frame1.OBJ 0\nframe2.obj\n", 25, 1, "w/list.txt:2: no time, but the lines before it have one");
    assert_list("frame1.OBJ\nframe2.obj 1\n", 25, 1, "w/list.txt:2: a time, but the lines before it have none");
    assert_list("frame1.OBJ 0\nframe3.obj 1\n", 25, 1, "w/list.txt:2: no such file 'frame3.obj'");
    assert_list("frame1.OBJ 0\nframe2.obj 0.05\n", 25, 1,
                "w/list.txt:2: 0.05 s is not the time of a frame at 25 frames a second; all times fit --fps 20");
    assert_list("frame1.OBJ 0\nframe2.obj 0.01\nframe10.obj 0.02\n", 10, 1,
                "w/list.txt:2: 0.01 s is not the time of a frame at 10 frames a second; all times fit --fps 100");
    assert_list("frame1.OBJ 0\nframe2.obj 0.033\nframe10.obj 0.1\n", 30000, 2001,
                "w/list.txt:2: 0.033 s is not the time of a frame at 30000/2001 frames a second; all times fit "
                "--fps 30");
    assert_list("frame1.OBJ 0\nframe2.obj 0.00021\nframe10.obj 0.1\n", 25, 1,
                "w/list.txt:2: 0.00021 s is not the time of a frame at 25 frames a second");
    assert_list("frame1.OBJ 0\nframe2.obj 1e12\n", 25, 1, "w/list.txt:2: 1e+12 s is too late to count frames");
    write_file("w/list.txt", "frame1.OBJ 0\n");
    const char *const inputs[2] = {"w/list.txt", "w/frame2.obj"};
    nsdf_sequence *sequence = NULL;
    nsdf_encoder_error error;
    assert_int_equal(nsdf_sequence_open(&sequence, inputs, 2, NULL, &error), NSDF_INVALID_ARGUMENT);
    assert_string_equal(error.message, "w/list.txt: a list with times must be the only input");
}

static void frames_without_a_file_cannot_be_loaded(void **state) {
    (void)state;
    const char *input = "w/frame*";
    nsdf_sequence *sequence = NULL;
    nsdf_input_mesh mesh;
    nsdf_encoder_error error;
    assert_int_equal(nsdf_sequence_open(&sequence, &input, 1, NULL, &error), NSDF_OK);
    assert_int_equal(nsdf_sequence_frame_count(sequence), 10);
    assert_null(nsdf_sequence_frame_path(sequence, 2));
    assert_int_equal(nsdf_sequence_load(sequence, 9, &mesh, &error), NSDF_OK);
    assert_int_equal(nsdf_sequence_load(sequence, 2, &mesh, &error), NSDF_INVALID_ARGUMENT);
    assert_string_equal(error.message, "the sequence has 10 frames, but frame 2 has no mesh");
    nsdf_sequence_close(&sequence);
}

static void nothing_found_is_an_error_that_names_what_was_looked_for(void **state) {
    (void)state;
    assert_failure("empty", NSDF_IO, "empty folder 'empty': no .obj, .ply, .stl, .glb or .gltf files");
    assert_failure("w/walk_%04d.obj", NSDF_IO, "no file matches 'w/walk_%04d.obj'");
    assert_failure("nowhere/walk_%04d.obj", NSDF_IO, "no such folder 'nowhere/'");
    assert_failure("w/walk*.obj", NSDF_IO, "no file matches 'w/walk*.obj'");
    assert_failure("w/walk.obj", NSDF_IO, "no such file or folder 'w/walk.obj'");
    assert_failure("w/none.lst", NSDF_IO, "no such file or folder 'w/none.lst'");
    assert_failure("/dev/null", NSDF_IO, "'/dev/null' is neither a regular file nor a folder");
    assert_failure("", NSDF_INVALID_ARGUMENT, "input 1 has no name");
    assert_int_equal(nsdf_sequence_open(NULL, NULL, 0, NULL, NULL), NSDF_INVALID_ARGUMENT);
}

static void list_file_errors_name_the_line(void **state) {
    (void)state;
    write_file("w/list.txt", "# c\nframe2.obj\nframe3.obj\n");
    assert_failure("w/list.txt", NSDF_IO, "w/list.txt:3: no such file 'frame3.obj'");
    write_file("w/list.txt", "../w\n");
    assert_failure("w/list.txt", NSDF_IO, "w/list.txt:1: not a regular file '../w'");
    write_file("w/list.txt", "# nothing\n");
    assert_failure("w/list.txt", NSDF_CORRUPT, "empty list file 'w/list.txt': no paths");
    FILE *file = fopen("w/list.txt", "wb");
    fwrite("\nPK\0\0\n", 1, 6, file);
    fclose(file);
    assert_failure("w/list.txt", NSDF_CORRUPT, "w/list.txt:2: a zero byte: this is not a list of paths");
    write_file("w/list.txt", "frame2.obj\nframe\0332.obj\n");
    assert_failure("w/list.txt", NSDF_CORRUPT, "w/list.txt:2: control characters: this is not a list of paths");
    file = fopen("w/list.txt", "wb");
    for (int i = 0; i < 5000; i++) {
        fputc('x', file);
    }
    fclose(file);
    assert_failure("w/list.txt", NSDF_CORRUPT, "w/list.txt:1: the line is too long for a path");
}

static void ply_frames_load_beside_obj_frames(void **state) {
    (void)state;
    const char *const inputs[2] = {"w/frame2.obj", "q/b10.ply"};
    nsdf_sequence *sequence = NULL;
    nsdf_input_mesh mesh = {0};
    nsdf_encoder_error error = {NSDF_OK, ""};
    assert_int_equal(nsdf_sequence_open(&sequence, inputs, 2, NULL, &error), NSDF_OK);
    assert_int_equal(nsdf_sequence_load(sequence, 1, &mesh, &error), NSDF_CORRUPT);
    assert_string_equal(error.message, "q/b10.ply:1: not a PLY file: expected the line 'ply'");
    write_file("q/b10.ply", "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                            "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
                            "0 0 0\n2 0 0\n2 2 0\n0 2 0\n4 0 1 2 3\n");
    assert_int_equal(nsdf_sequence_load(sequence, 1, &mesh, &error), NSDF_OK);
    assert_int_equal(mesh.vertex_count, 4);
    assert_int_equal(mesh.triangle_count, 2);
    assert_true(mesh.positions[3] == 2.0);
    assert_int_equal(nsdf_sequence_load(sequence, 0, &mesh, &error), NSDF_OK);
    assert_int_equal(mesh.vertex_count, 3);
    nsdf_sequence_close(&sequence);
}

static void frames_load_and_errors_name_file_and_line(void **state) {
    (void)state;
    const char *const inputs[2] = {"w/frame2.obj", "p/bad.obj"};
    nsdf_sequence *sequence = NULL;
    nsdf_input_mesh mesh = {0};
    nsdf_encoder_error error = {NSDF_OK, ""};
    assert_int_equal(nsdf_sequence_open(&sequence, inputs, 2, NULL, &error), NSDF_OK);
    assert_int_equal(nsdf_sequence_load(sequence, 0, &mesh, &error), NSDF_OK);
    assert_int_equal(mesh.vertex_count, 3);
    assert_int_equal(mesh.triangle_count, 1);
    assert_true(mesh.positions[3] == 1.0 && mesh.indices[2] == 2);
    nsdf_input_mesh untouched = mesh;
    assert_int_equal(nsdf_sequence_load(sequence, 1, &mesh, &error), NSDF_CORRUPT);
    assert_string_equal(error.message, "p/bad.obj:3: face index 7 is out of range (the file has 2 vertices)");
    assert_memory_equal(&mesh, &untouched, sizeof mesh);
    assert_int_equal(nsdf_sequence_load(sequence, 2, &mesh, &error), NSDF_INVALID_ARGUMENT);
    assert_string_equal(error.message, "the sequence has 2 frames, there is no frame 2");
    nsdf_sequence_close(&sequence);
    nsdf_sequence_close(&sequence);
    nsdf_sequence_close(NULL);
}

static void shared_handles_load_for_themselves(void **state) {
    (void)state;
    const char *const inputs[2] = {"w/frame2.obj", "q/b10.ply"};
    nsdf_sequence *sequence = NULL, *other = NULL;
    nsdf_input_mesh a, b;
    nsdf_encoder_error error;
    assert_int_equal(nsdf_sequence_open(&sequence, inputs, 2, NULL, &error), NSDF_OK);
    assert_int_equal(nsdf_sequence_share(sequence, &other, &error), NSDF_OK);
    assert_int_equal(nsdf_sequence_frame_count(other), 2);
    assert_int_equal(nsdf_sequence_load(sequence, 0, &a, &error), NSDF_OK);
    assert_int_equal(nsdf_sequence_load(other, 1, &b, &error), NSDF_OK);
    assert_int_equal(a.vertex_count, 3);
    assert_int_equal(b.vertex_count, 4);
    assert_true(a.positions[3] == 1.0 && b.positions[3] == 2.0);
    nsdf_sequence_close(&other);
    assert_int_equal(nsdf_sequence_load(sequence, 1, &a, &error), NSDF_OK);
    nsdf_sequence_close(&sequence);
    assert_int_equal(nsdf_sequence_share(NULL, &other, &error), NSDF_INVALID_ARGUMENT);
}

static void natural_order_compares_digits_as_numbers(void **state) {
    (void)state;
    static const char *const sorted[] = {"",   "a",   "a-1",   "a1",     "a01", "a1b", "a2",
                                         "a9", "a10", "a10b2", "a10b10", "a11", "ab",  "b18446744073709551616"};
    for (size_t i = 0; i < sizeof sorted / sizeof sorted[0]; i++) {
        for (size_t j = 0; j < sizeof sorted / sizeof sorted[0]; j++) {
            int order = nsdf_natural_compare(sorted[i], sorted[j]);
            int wanted = (i > j) - (i < j);
            /* a1 and a01 are equal as numbers: any order but equality will do. */
            if (!((i == 3 && j == 4) || (i == 4 && j == 3))) {
                assert_int_equal((order > 0) - (order < 0), wanted);
            } else {
                assert_int_not_equal(order, 0);
            }
        }
    }
}

static void number_patterns_match_what_printf_would_write(void **state) {
    (void)state;
    static const char *const formats[] = {"%d", "%1d", "%4d", "%04d", "%09u", "%02i"};
    static const unsigned values[] = {0, 7, 12, 99, 100, 9999, 12345, 4000000000u};
    for (size_t f = 0; f < sizeof formats / sizeof formats[0]; f++) {
        nsdf_number_pattern pattern;
        assert_true(nsdf_number_pattern_parse(&pattern, formats[f]));
        for (size_t v = 0; v < sizeof values / sizeof values[0]; v++) {
            char name[32];
            uint64_t number = 0;
            int width = formats[f][1] == '0' ? formats[f][2] - '0' : formats[f][1] == 'd' ? 0 : formats[f][1] - '0';
            snprintf(name, sizeof name, formats[f][1] == '0' ? "%0*u" : "%*u", width, values[v]);
            assert_true(nsdf_number_pattern_match(&pattern, name, &number));
            assert_int_equal(number, values[v]);
        }
    }
}

static void number_patterns_refuse_everything_else(void **state) {
    (void)state;
    nsdf_number_pattern pattern;
    uint64_t number;
    static const char *const bad[] = {"a", "%", "a%", "%s", "%x", "%d%d", "%-4d", "%10d", "100%%", "%ld", "%.3d"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_false(nsdf_number_pattern_parse(&pattern, bad[i]));
    }
    assert_true(nsdf_number_pattern_parse(&pattern, "50%%_%04d.obj"));
    assert_true(nsdf_number_pattern_match(&pattern, "50%_0012.obj", &number));
    static const char *const other[] = {"50%_12.obj",   "50%_00012.obj", "50%_.obj",     "50%_001x.obj", "50%_0012.ob",
                                        "51%_0012.obj", "50%_-012.obj",  "50%_ 012.obj", "50%_.ob"};
    for (size_t i = 0; i < sizeof other / sizeof other[0]; i++) {
        assert_false(nsdf_number_pattern_match(&pattern, other[i], &number));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(folders_list_their_obj_files_in_natural_order),
        cmocka_unit_test(folders_without_obj_files_list_their_ply_files),
        cmocka_unit_test(printf_patterns_find_the_numbers_that_exist),
        cmocka_unit_test(globs_expand_in_natural_order),
        cmocka_unit_test(list_files_are_relative_to_their_folder),
        cmocka_unit_test(existing_files_are_taken_whatever_their_name),
        cmocka_unit_test(inputs_keep_their_order),
        cmocka_unit_test(numbers_of_files_tell_their_frames),
        cmocka_unit_test(numbers_too_far_apart_are_refused),
        cmocka_unit_test(list_files_may_tell_times),
        cmocka_unit_test(times_that_cannot_be_are_refused_by_line),
        cmocka_unit_test(frames_without_a_file_cannot_be_loaded),
        cmocka_unit_test(nothing_found_is_an_error_that_names_what_was_looked_for),
        cmocka_unit_test(list_file_errors_name_the_line),
        cmocka_unit_test(frames_load_and_errors_name_file_and_line),
        cmocka_unit_test(ply_frames_load_beside_obj_frames),
        cmocka_unit_test(shared_handles_load_for_themselves),
        cmocka_unit_test(natural_order_compares_digits_as_numbers),
        cmocka_unit_test(number_patterns_match_what_printf_would_write),
        cmocka_unit_test(number_patterns_refuse_everything_else),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
