/* The player's parts that need neither OpenGL nor a display: camera, clock, pace, frames, pictures, punctuality. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <setjmp.h>
#include <cmocka.h>
#include <string.h>
#include <time.h>

#include "cli_util.h"
#include "camera.h"
#include "frame_queue.h"
#include "heat.h"
#include "hud.h"
#include "obj_mesh.h"
#include "picture.h"
#include "punctuality.h"
#include "reference.h"
#include "view_setup.h"

/* ---- Camera ---------------------------------------------------------------------------------------------- */

static const play_box box = {{-1.0, 0.0, -0.5}, {1.5, 3.0, 0.5}};

/* Where the box's corners are in the picture: the extremes of x and y. */
static void corners(const play_camera *c, double aspect, double low[2], double high[2]) {
    const play_eye eye = play_camera_eye(c, aspect);
    low[0] = low[1] = 1e9;
    high[0] = high[1] = -1e9;
    for (int i = 0; i < 8; i++) {
        const double p[3] = {i & 1 ? box.high[0] : box.low[0], i & 2 ? box.high[1] : box.low[1],
                             i & 4 ? box.high[2] : box.low[2]};
        double at[2];
        play_eye_project(&eye, p, &at[0], &at[1]);
        for (int k = 0; k < 2; k++) {
            low[k] = fmin(low[k], at[k]);
            high[k] = fmax(high[k], at[k]);
        }
    }
}

static void test_the_box_just_fits(void **state) {
    (void)state;
    for (int up = 0; up < 6; up++)
        for (int turn = 0; turn < 12; turn++) {
            const double aspect = turn % 3 == 0 ? 0.5 : turn % 3 == 1 ? 1.0 : 1.8;
            play_camera c = play_camera_make(&box, (play_up)up, aspect);
            double low[2], high[2];
            play_camera_orbit(&c, 30.0 * turn, 7.0 * turn - 40.0);
            play_camera_fit(&c, &box, aspect);
            corners(&c, aspect, low, high);
            const double widest = fmax(high[0] - 0.5, fmax(0.5 - low[0], fmax(high[1] - 0.5, 0.5 - low[1])));
            assert_true(widest > 0.40 && widest < 0.5);
        }
}

static void test_up_is_up_and_the_front_is_in_front(void **state) {
    static const double front[6][3] = {{0, 0, -1}, {0, 0, 1}, {0, -1, 0}, {0, 0, -1}, {0, 0, 1}, {0, -1, 0}};
    (void)state;
    for (int up = 0; up < 6; up++) {
        play_camera c = play_camera_make(&box, (play_up)up, 1.0);
        c.azimuth = c.elevation = 0.0;
        const play_eye eye = play_camera_eye(&c, 1.0);
        const double axis[3] = {eye.up.x, eye.up.y, eye.up.z}, back[3] = {eye.back.x, eye.back.y, eye.back.z};
        for (int k = 0; k < 3; k++) {
            assert_true(fabs(axis[k] - (k == up % 3 ? (up < 3 ? 1.0 : -1.0) : 0.0)) < 1e-12);
            assert_true(fabs(back[k] - front[up][k]) < 1e-12);
        }
        const play_vec3 right = play_cross(eye.up, eye.back); /* right-handed: no mirror */
        assert_true(play_dot(right, eye.right) > 0.999);
    }
}

static void test_matrix_and_projection_agree(void **state) {
    play_camera c = play_camera_make(&box, PLAY_UP_Y, 1.6);
    (void)state;
    play_camera_orbit(&c, 50.0, -20.0);
    play_camera_pan(&c, 0.1, -0.2);
    play_camera_zoom(&c, 1.7);
    const play_eye eye = play_camera_eye(&c, 1.6);
    for (int i = 0; i < 8; i++) {
        const double p[3] = {0.3 * i - 1.0, 0.2 * i, 0.1 * i - 0.3};
        double x, y, clip[4];
        play_eye_project(&eye, p, &x, &y);
        for (int row = 0; row < 4; row++) {
            const float *m = eye.clip_of_world.m;
            clip[row] =
                (double)m[row] * p[0] + (double)m[4 + row] * p[1] + (double)m[8 + row] * p[2] + (double)m[12 + row];
        }
        assert_true(fabs(0.5 + 0.5 * clip[0] / clip[3] - x) < 1e-5 && fabs(0.5 - 0.5 * clip[1] / clip[3] - y) < 1e-5);
        assert_true(fabs(clip[2]) < clip[3]); /* between near and far */
    }
}

static void test_panning_moves_by_parts_of_the_picture(void **state) {
    play_camera c = play_camera_make(&box, PLAY_UP_Y, 1.5);
    double before[2], after[2];
    (void)state;
    const double p[3] = {c.target.x, c.target.y, c.target.z};
    play_eye eye = play_camera_eye(&c, 1.5);
    play_eye_project(&eye, p, &before[0], &before[1]);
    play_camera_pan(&c, 0.15, 0.1); /* of the shorter side, which is the height */
    eye = play_camera_eye(&c, 1.5);
    play_eye_project(&eye, p, &after[0], &after[1]);
    assert_true(fabs(after[0] - before[0] - 0.1) < 1e-6 && fabs(after[1] - before[1] + 0.1) < 1e-6);
}

static void test_words_for_up(void **state) {
    static const char *const good[] = {"x", "y", "+z", "-x", "-y", "-z"}, *const bad[] = {"", "w", "xy", "--x", "-"};
    play_up up = PLAY_UP_Y;
    (void)state;
    for (int i = 0; i < 6; i++)
        assert_true(play_up_parse(good[i], &up) == 0 && (int)up == i);
    for (int i = 0; i < 5; i++)
        assert_int_equal(play_up_parse(bad[i], &up), -1);
}

/* ---- Clock ----------------------------------------------------------------------------------------------- */

static void close_to(double a, double b) {
    assert_true(fabs(a - b) < 1e-9);
}

static void test_the_clock_goes_at_its_speed(void **state) {
    play_clock c = play_clock_make(2.0, 0.1);
    (void)state;
    close_to(play_clock_time(&c, 5.0), 0.0);
    assert_false(play_clock_moves(&c, 5.0));
    play_clock_play(&c, 10.0);
    close_to(play_clock_time(&c, 11.5), 1.5);
    play_clock_set_speed(&c, 11.5, 0.25);
    close_to(play_clock_time(&c, 12.5), 1.75);
    play_clock_set_speed(&c, 12.5, -1.0);
    close_to(play_clock_time(&c, 13.0), 1.25);
    play_clock_pause(&c, 13.0);
    close_to(play_clock_time(&c, 99.0), 1.25);
    play_clock_seek(&c, 99.0, 7.0);
    close_to(play_clock_time(&c, 99.0), 2.0);
    play_clock_set_speed(&c, 99.0, 1000.0);
    close_to(c.speed, 8.0);
    play_clock_set_speed(&c, 99.0, -1e-9);
    close_to(c.speed, -1.0 / 64);
}

static void test_loops_hold_the_last_frame(void **state) {
    play_clock c = play_clock_make(2.0, 0.1);
    (void)state;
    play_clock_play(&c, 0.0);
    close_to(play_clock_time(&c, 2.05), 2.0);
    close_to(play_clock_time(&c, 2.2), 0.1);
    close_to(play_clock_time(&c, 21.5), 0.5);
    play_clock_set_speed(&c, 0.0, -1.0);
    close_to(play_clock_time(&c, 0.05), 2.0);
    close_to(play_clock_time(&c, 0.6), 1.5);
}

static void test_without_a_loop_it_stops_and_begins_again(void **state) {
    play_clock c = play_clock_make(2.0, 0.1);
    (void)state;
    play_clock_set_loop(&c, 0.0, 0);
    play_clock_play(&c, 0.0);
    assert_true(play_clock_moves(&c, 1.9) && !play_clock_moves(&c, 2.0));
    close_to(play_clock_time(&c, 50.0), 2.0);
    play_clock_play(&c, 50.0);
    close_to(play_clock_time(&c, 50.5), 0.5);
    play_clock_set_speed(&c, 50.5, -1.0);
    assert_false(play_clock_moves(&c, 51.5));
    play_clock_play(&c, 60.0);
    close_to(play_clock_time(&c, 60.5), 1.5);
    play_clock still = play_clock_make(0.0, 0.04); /* a single frame */
    play_clock_play(&still, 0.0);
    assert_false(play_clock_moves(&still, 1.0));
}

/* ---- Pace ------------------------------------------------------------------------------------------------ */

/* A machine that takes `unit` seconds for resolution 100: where the pace settles. */
static uint32_t settle(double unit, double interval, uint32_t most) {
    play_pace p = play_pace_make(96, most);
    uint32_t changes = 0, last = 0;
    for (int i = 0; i < 2000; i++) {
        const double ratio = p.resolution / 100.0, seconds = unit * ratio * ratio;
        const int changed = play_pace_note(&p, p.resolution, seconds, interval, seconds > interval);
        if (changed && i > 1000)
            changes++;
        last = p.resolution;
    }
    assert_int_equal(changes, 0);
    return last;
}

static void test_the_pace_settles_where_frames_are_in_time(void **state) {
    (void)state;
    assert_int_equal(settle(0.001, 0.04, 192), 192);
    assert_int_equal(settle(0.010, 0.04, 512), 128);
    assert_int_equal(settle(10.0, 0.04, 192), 16);
    const uint32_t slow = settle(0.030, 0.04, 192);
    assert_true(slow >= 64 && slow <= 96);
    assert_int_equal(play_pace_step(128, 1, 192), 160);
    assert_int_equal(play_pace_step(192, 1, 192), 192);
    assert_int_equal(play_pace_step(100, -1, 192), 96);
    assert_int_equal(play_pace_step(16, -1, 192), 16);
}

/* ---- Frames ---------------------------------------------------------------------------------------------- */

static void sleep_for(double seconds) {
    const struct timespec t = {(time_t)seconds, (long)(1e9 * (seconds - (double)(time_t)seconds))};
    nanosleep(&t, NULL);
}

static nsdf_decoder *open_walker(nsdf_info *info) {
    nsdf_decoder *decoder = NULL;
    assert_int_equal(nsdf_open_file(&decoder, NSDF_SAMPLE, NULL, NULL), NSDF_OK);
    assert_int_equal(nsdf_get_info(decoder, info), NSDF_OK);
    return decoder;
}

static const play_frame *wait_for(play_queue *q, uint64_t after, double seconds) {
    const double until = nsdf_cli_clock() + seconds;
    for (;;) {
        const play_frame *f = play_queue_take(q, nsdf_cli_clock());
        if (f && f->number > after)
            return f;
        if (nsdf_cli_clock() > until)
            return NULL;
        sleep_for(0.001);
    }
}

/* Whether a frame has the surface of its time and resolution: that which another decoder extracts. */
static int is_surface_of(const play_frame *f) {
    nsdf_info info;
    nsdf_decoder *decoder = open_walker(&info);
    nsdf_mesh *mesh = NULL;
    nsdf_mesh_view view;
    nsdf_mesh_options options;
    nsdf_mesh_options_init(&options);
    options.resolution = f->resolution;
    assert_int_equal(nsdf_extract_mesh(decoder, f->time, &options, &mesh), NSDF_OK);
    assert_int_equal(nsdf_mesh_get_view(mesh, &view), NSDF_OK);
    const int same = view.vertex_count == f->view.vertex_count && view.vertex_count > 0 &&
                     memcmp(view.positions, f->view.positions, 12 * (size_t)view.vertex_count) == 0;
    nsdf_mesh_free(&mesh);
    nsdf_close(&decoder);
    return same;
}

static void test_frames_are_those_of_the_clock(void **state) {
    nsdf_info info;
    nsdf_decoder *decoder = open_walker(&info);
    play_plan plan = {.clock = play_clock_make(info.duration, 0.04), .rate = 50.0, .resolution = 24, .most = 48};
    (void)state;
    play_clock_set_speed(&plan.clock, nsdf_cli_clock(), 0.125);
    play_clock_play(&plan.clock, nsdf_cli_clock());
    play_queue *q = play_queue_create(decoder, NULL, &plan);
    assert_non_null(q);
    uint64_t number = 0;
    double before = -1.0;
    for (int i = 0; i < 12; i++) {
        const play_frame *f = wait_for(q, number, 2.0);
        assert_non_null(f);
        assert_true(f->time > before); /* slow motion: new surfaces every time */
        assert_true(fabs(f->time - play_clock_time(&plan.clock, f->due)) < 1e-9);
        assert_true(f->due <= nsdf_cli_clock());
        assert_true(i % 4 || is_surface_of(f));
        before = f->time;
        number = f->number;
    }
    play_queue_free(q);
    nsdf_close(&decoder);
}

static void test_a_standing_clock_gets_one_good_frame(void **state) {
    nsdf_info info;
    nsdf_decoder *decoder = open_walker(&info);
    play_plan plan = {.clock = play_clock_make(info.duration, 0.04), .rate = 50.0, .most = 160};
    (void)state;
    play_queue *q = play_queue_create(decoder, NULL, &plan);
    const play_frame *f = wait_for(q, 0, 2.0);
    assert_true(f && f->time == 0.0 && f->resolution == 96);
    f = wait_for(q, f->number, 2.0);
    assert_true(f && f->time == 0.0 && f->resolution == 160 && is_surface_of(f));
    uint64_t number = f->number;
    assert_null(wait_for(q, number, 0.05)); /* and no more */
    for (int i = 1; i < 5; i++) {
        play_clock_seek(&plan.clock, nsdf_cli_clock(), 0.3 * i);
        play_queue_set_plan(q, &plan);
        f = wait_for(q, number, 2.0);
        assert_true(f && fabs(f->time - 0.3 * i) < 1e-12);
        number = f->number;
    }
    play_queue_free(q);
    nsdf_close(&decoder);
}

/* Changing plans all the time, and ending in the midst of decoding. */
static void test_plans_may_change_at_any_moment(void **state) {
    nsdf_info info;
    nsdf_decoder *decoder = open_walker(&info);
    play_plan plan = {.clock = play_clock_make(info.duration, 0.04), .rate = 100.0, .most = 128};
    (void)state;
    play_queue *q = play_queue_create(decoder, NULL, &plan);
    for (int i = 0; i < 60; i++) {
        const double now = nsdf_cli_clock();
        if (i % 3 == 0)
            play_clock_seek(&plan.clock, now, 0.05 * (i % 30));
        if (i % 5 == 0)
            play_clock_play(&plan.clock, now);
        if (i % 7 == 0)
            play_clock_pause(&plan.clock, now);
        plan.resolution = i % 2 ? 0 : 16 + (uint32_t)i;
        play_queue_set_plan(q, &plan);
        sleep_for(0.002 * (i % 4));
        const play_frame *f = play_queue_take(q, nsdf_cli_clock());
        assert_true(!f || f->view.vertex_count > 0);
    }
    assert_int_equal(play_queue_get_state(q).status, NSDF_OK);
    play_queue_free(q);
    nsdf_close(&decoder);
}

/* ---- Texts and pictures ---------------------------------------------------------------------------------- */

static void test_places_on_the_time_bar(void **state) {
    (void)state;
    assert_true(play_hud_time_at(1280, 720, 640.0, 300.0) < 0.0);
    assert_true(fabs(play_hud_time_at(1280, 720, 640.0, 700.0) - 0.5) < 1e-6);
    assert_true(play_hud_time_at(1280, 720, 0.0, 719.0) == 0.0 && play_hud_time_at(1280, 720, 1279.0, 719.0) == 1.0);
}

static void test_texts_stay_within_the_picture(void **state) {
    const play_hud hud = {.file = "walker.nsdf",
                          .duration = 2.0,
                          .time = 1.0,
                          .frame_count = 48,
                          .help = 1,
                          .frame_rate = 24.0,
                          .speed = -0.125,
                          .playing = 1};
    play_overlay o = {NULL, 0, 0};
    (void)state;
    play_hud_draw(&o, &hud, 1280, 720);
    assert_true(o.count > 1000 && o.count % 3 == 0);
    for (size_t i = 0; i < o.count; i++)
        assert_true(o.corners[i].x >= 0.0f && o.corners[i].x <= 1280.0f && o.corners[i].y >= 0.0f &&
                    o.corners[i].y <= 720.0f);
    play_overlay_free(&o);
}

typedef struct bytes {
    unsigned char data[4096];
    size_t size;
} bytes;

static int append(void *user, const void *data, size_t size) {
    bytes *b = user;
    assert_true(b->size + size <= sizeof b->data);
    memcpy(b->data + b->size, data, size);
    b->size += size;
    return 0;
}

static int refuse(void *user, const void *data, size_t size) {
    (void)user;
    (void)data;
    (void)size;
    return -1;
}

static void test_frames_of_films(void **state) {
    static const unsigned char rgba[] = {255, 255, 255, 255, 0, 0, 0, 255, 255, 0, 0, 255, 0, 0, 255, 255};
    static const unsigned char planes[] = {235, 16, 82, 41, 128, 128, 90, 240, 128, 128, 240, 110};
    bytes b = {.size = 0};
    (void)state;
    assert_int_equal(play_write_y4m_header(2, 2, 30000, 1001, append, &b), 0);
    b.data[b.size] = 0;
    assert_string_equal((const char *)b.data, "YUV4MPEG2 W2 H2 F30000:1001 Ip A1:1 C444\n");
    b.size = 0;
    assert_int_equal(play_write_y4m_frame(rgba, 2, 2, append, &b), 0);
    assert_true(b.size == 6 + 12 && memcmp(b.data, "FRAME\n", 6) == 0);
    for (int i = 0; i < 12; i++)
        assert_true(abs(b.data[6 + i] - planes[i]) <= 1);
    b.size = 0;
    assert_int_equal(play_write_rgba(rgba, 2, 2, append, &b), 0);
    assert_memory_equal(b.data, rgba, sizeof rgba);
    b.size = 0;
    assert_int_equal(play_write_png(rgba, 2, 2, 0, append, &b), 0);
    assert_memory_equal(b.data, "\x89PNG\r\n\x1a\n", 8);
    assert_int_equal(play_write_png(rgba, 2, 2, 1, refuse, NULL), -1);
}

static void test_punctuality(void **state) {
    play_clock c = play_clock_make(2.0, 0.1);
    play_punctuality p = play_punctuality_make();
    (void)state;
    play_clock_play(&c, 0.0);
    play_punctuality_jump(&p, 0.0);
    play_punctuality_shown(&p, &c, 0.0, 0.07);
    close_to(p.slowest_jump, 0.07);
    play_punctuality_shown(&p, &c, 0.1, 0.102);
    close_to(p.worst, 0.002);
    play_punctuality_shown(&p, &c, 1.99, 2.09); /* the last frame is held */
    close_to(p.worst, 0.01);
    play_punctuality_shown(&p, &c, 0.2, 2.35);
    close_to(p.worst, 0.05);
    assert_true(p.shown == 4 && p.judged == 3);
}

/* ---- Comparing ------------------------------------------------------------------------------------------- */

static void test_obj_meshes(void **state) {
    static const char text[] = "# a square, a triangle\r\nv 0 0 0\r\nv 1 0 0 1 1 1\n  v 1 1 0\nv 0 1 0\n"
                               "vn 9 9 9\nvt 0 0\n\nf 1/1 2/1/5 3//2 4\nv 0 0 2e0\nf -1 -5\t-4 \r\nusemtl f";
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3, 4, 0, 1};
    play_obj_mesh m = {.vertex_count = 0};
    unsigned long line = 0;
    (void)state;
    for (int again = 0; again < 2; again++) {
        assert_null(play_obj_parse(&m, text, &line));
        const nsdf_mesh_view v = play_obj_view(&m);
        assert_true(v.vertex_count == 5 && v.triangle_count == 3 && line == 13);
        assert_memory_equal(v.indices, indices, sizeof indices);
        assert_true(v.positions[3] == 1.0f && v.positions[4] == 0.0f && v.positions[14] == 2.0f);
        assert_true(v.normals[3 * 2 + 2] == 1.0f && v.normals[3 * 4 + 1] == -1.0f);
    }
    play_obj_free(&m);
}

static void test_obj_faults_name_their_line(void **state) {
    static const struct {
        const char *text;
        unsigned long line;
    } bad[] = {{"v 0 0 0\nv 0 0\n1\n", 2},
               {"v 0 0 nan", 1},
               {"v 0 0 1e39", 1},
               {"v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf 1 2 4", 5},
               {"v 0 0 0\nv 1 0 0\nf 1 2\n3", 3},
               {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 0 2", 4},
               {"v 0 0 0\nf -1 -2 -1", 2},
               {"v 0 0 0\nf 1 x 1", 2},
               {"v 0 0 0\n", 2},
               {"", 1}};
    play_obj_mesh m = {.vertex_count = 0};
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        unsigned long line = 0;
        assert_non_null(play_obj_parse(&m, bad[i].text, &line));
        assert_int_equal(line, bad[i].line);
    }
    play_obj_free(&m);
}

static void test_numbers_in_names_count(void **state) {
    static const char *const ordered[] = {"a", "a1.obj", "a02.obj", "a2b.obj", "a10.obj", "a10b2", "a10b11", "b0"};
    (void)state;
    for (int i = 0; i < 8; i++)
        for (int j = 0; j < 8; j++) {
            const int order = play_reference_order(ordered[i], ordered[j]);
            assert_true(i < j ? order < 0 : i > j ? order > 0 : order == 0);
        }
}

static void test_frames_that_are_shown(void **state) {
    const nsdf_info info = {.rate_num = 30000, .rate_den = 1001, .frame_count = 100};
    (void)state;
    for (uint32_t i = 0; i < 100; i++) {
        assert_int_equal(play_frame_at(&info, i * 1001.0 / 30000.0), i);
        assert_int_equal(play_frame_at(&info, (i + 0.9) * 1001.0 / 30000.0), i);
    }
    assert_int_equal(play_frame_at(&info, 1000.0), 99);
}

/* Points off the surface by a known distance along its normals. */
static void test_heat_is_distance(void **state) {
    nsdf_decoder *decoder = NULL;
    nsdf_mesh *mesh = NULL;
    nsdf_mesh_view view;
    nsdf_info info;
    (void)state;
    assert_int_equal(nsdf_open_file(&decoder, NSDF_SAMPLE, NULL, NULL), NSDF_OK);
    assert_int_equal(nsdf_get_info(decoder, &info), NSDF_OK);
    assert_int_equal(nsdf_extract_mesh(decoder, 0.4, NULL, &mesh), NSDF_OK);
    assert_int_equal(nsdf_mesh_get_view(mesh, &view), NSDF_OK);
    const size_t count = view.vertex_count;
    float *points = malloc(count * 3 * sizeof *points), *share = malloc(count * sizeof *share);
    for (int step = 0; step < 3; step++) { /* 0, a half and three times what is shown at most */
        const double top = 1e-3 * info.diagonal, off = (step == 0 ? 0.0 : step == 1 ? 0.5 : 3.0) * top;
        double sum = 0.0;
        for (size_t i = 0; i < 3 * count; i++)
            points[i] = view.positions[i] + (float)off * view.normals[i];
        assert_int_equal(play_heat_measure(decoder, 0.4, points, count, top, share), NSDF_OK);
        for (size_t i = 0; i < count; i++) {
            assert_true(share[i] >= 0.0f && share[i] <= 1.0f);
            sum += (double)share[i];
        }
        assert_true(fabs(sum / (double)count - fmin(off / top, 1.0)) < 0.05);
    }
    free(points);
    free(share);
    nsdf_mesh_free(&mesh);
    nsdf_close(&decoder);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_obj_meshes),
        cmocka_unit_test(test_obj_faults_name_their_line),
        cmocka_unit_test(test_numbers_in_names_count),
        cmocka_unit_test(test_frames_that_are_shown),
        cmocka_unit_test(test_heat_is_distance),
        cmocka_unit_test(test_the_box_just_fits),
        cmocka_unit_test(test_up_is_up_and_the_front_is_in_front),
        cmocka_unit_test(test_matrix_and_projection_agree),
        cmocka_unit_test(test_panning_moves_by_parts_of_the_picture),
        cmocka_unit_test(test_words_for_up),
        cmocka_unit_test(test_the_clock_goes_at_its_speed),
        cmocka_unit_test(test_loops_hold_the_last_frame),
        cmocka_unit_test(test_without_a_loop_it_stops_and_begins_again),
        cmocka_unit_test(test_the_pace_settles_where_frames_are_in_time),
        cmocka_unit_test(test_frames_are_those_of_the_clock),
        cmocka_unit_test(test_a_standing_clock_gets_one_good_frame),
        cmocka_unit_test(test_plans_may_change_at_any_moment),
        cmocka_unit_test(test_places_on_the_time_bar),
        cmocka_unit_test(test_texts_stay_within_the_picture),
        cmocka_unit_test(test_frames_of_films),
        cmocka_unit_test(test_punctuality),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
