/* Pictures that nsdf-play draws without a display: silhouettes against the projected mesh, and stored pictures. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <setjmp.h>
#include <cmocka.h>
#include <png.h>
#include <string.h>

#include "view_setup.h"

enum { WIDTH = 240, HEIGHT = 180, FRAMES = 48 };

typedef struct picture {
    unsigned char rgba[4 * WIDTH * HEIGHT];
} picture;

/* What the program writes with these options. */
static void draw(const char *options, picture *p) {
    char command[1024];
    snprintf(command, sizeof command, "'%s' '%s' --offscreen - --format rgba --size %dx%d -q %s", NSDF_PLAY,
             NSDF_SAMPLE, WIDTH, HEIGHT, options);
    FILE *out = popen(command, "r");
    assert_non_null(out);
    assert_int_equal(fread(p->rgba, 1, sizeof p->rgba, out), sizeof p->rgba);
    assert_int_equal(fgetc(out), EOF);
    assert_int_equal(pclose(out), 0);
}

/* ---- Silhouettes ----------------------------------------------------------------------------------------- */

/* Pixels whose middles the triangle covers. */
static void fill_triangle(unsigned char *mask, const double p[3][2]) {
    const double area = (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
    double low[2] = {1e9, 1e9}, high[2] = {-1e9, -1e9};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 2; k++) {
            low[k] = fmin(low[k], p[i][k]);
            high[k] = fmax(high[k], p[i][k]);
        }
    for (int y = (int)fmax(low[1], 0.0); y <= (int)fmin(high[1], HEIGHT - 1); y++)
        for (int x = (int)fmax(low[0], 0.0); x <= (int)fmin(high[0], WIDTH - 1); x++) {
            int inside = area != 0.0;
            for (int i = 0; i < 3; i++) {
                const double *a = p[i], *b = p[(i + 1) % 3];
                const double side = (b[0] - a[0]) * (y + 0.5 - a[1]) - (b[1] - a[1]) * (x + 0.5 - a[0]);
                inside &= side * area >= 0.0;
            }
            mask[y * WIDTH + x] |= (unsigned char)inside;
        }
}

/* Where a point of the world is in the picture, or where its shadow on the ground is. */
static void place(const play_scene *scene, const float *v, int shadow, double at[2]) {
    const play_eye eye = play_camera_eye(&scene->camera, (double)WIDTH / HEIGHT);
    play_vec3 axes[3], p = {(double)v[0], (double)v[1], (double)v[2]};
    if (shadow) { /* y is up */
        play_up_axes(scene->camera.up, axes);
        const play_vec3 key = play_key_light(&eye, axes[1]);
        p = play_subtract(p, play_scale(key, (p.y - scene->box.low[1]) / key.y));
    }
    const double point[3] = {p.x, p.y, p.z};
    play_eye_project(&eye, point, &at[0], &at[1]);
    at[0] *= WIDTH;
    at[1] *= HEIGHT;
}

/* The mesh of a time, or its shadow, projected by the player's own camera. */
static void project(double seconds, const play_options *options, int shadow, unsigned char *mask) {
    nsdf_decoder *decoder = NULL;
    nsdf_mesh *mesh = NULL;
    nsdf_mesh_view view;
    nsdf_info info;
    memset(mask, 0, WIDTH * HEIGHT);
    assert_int_equal(nsdf_open_file(&decoder, NSDF_SAMPLE, NULL, NULL), NSDF_OK);
    assert_int_equal(nsdf_get_info(decoder, &info), NSDF_OK);
    assert_int_equal(nsdf_extract_mesh(decoder, seconds, NULL, &mesh), NSDF_OK);
    assert_int_equal(nsdf_mesh_get_view(mesh, &view), NSDF_OK);
    const play_scene scene = play_scene_make(options, &info);
    for (uint32_t t = 0; t < view.triangle_count; t++) {
        double p[3][2];
        for (uint32_t i = 0; i < 3; i++)
            place(&scene, view.positions + 3 * (size_t)view.indices[3 * t + i], shadow, p[i]);
        fill_triangle(mask, (const double(*)[2])p);
    }
    nsdf_mesh_free(&mesh);
    nsdf_close(&decoder);
}

typedef struct shape {
    double area, x, y; /* pixels; the middle */
} shape;

static shape measure(const unsigned char *mask) {
    shape s = {0.0, 0.0, 0.0};
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        if (mask[i]) {
            s.area += 1.0;
            s.x += i % WIDTH;
            s.y += i / WIDTH;
        }
    s.x /= s.area;
    s.y /= s.area;
    return s;
}

static int agree(const unsigned char *drawn, const unsigned char *expected) {
    const shape a = measure(drawn), b = measure(expected);
    double differing = 0.0;
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        differing += drawn[i] != expected[i];
    return b.area > 500.0 && fabs(a.area - b.area) < 0.01 * b.area && fabs(a.x - b.x) < 0.2 && fabs(a.y - b.y) < 0.2 &&
           differing < 0.01 * b.area;
}

static void test_silhouettes_are_those_of_the_mesh(void **state) {
    static const struct {
        const char *options;
        double azimuth, elevation, zoom;
        play_up up;
        double seconds;
    } views[] = {{"--times 0", 25.0, 12.0, 1.0, PLAY_UP_Y, 0.0},
                 {"--times 0.7 --camera 200,-30", 200.0, -30.0, 1.0, PLAY_UP_Y, 0.7},
                 {"--times 1.3 --camera 90,60,0.8", 90.0, 60.0, 0.8, PLAY_UP_Y, 1.3},
                 {"--times 0.31 --camera 10,5 --up -z --mode normals", 10.0, 5.0, 1.0, PLAY_UP_NEGATIVE_Z, 0.31},
                 {"--times 0.31 --mode flat", 25.0, 12.0, 1.0, PLAY_UP_Y, 0.31}};
    static unsigned char drawn[WIDTH * HEIGHT], expected[WIDTH * HEIGHT], first[WIDTH * HEIGHT];
    static picture p;
    (void)state;
    for (size_t i = 0; i < sizeof views / sizeof *views; i++) {
        char options[256];
        play_options o = {.width = WIDTH,
                          .height = HEIGHT,
                          .up = views[i].up,
                          .azimuth = views[i].azimuth,
                          .elevation = views[i].elevation,
                          .zoom = views[i].zoom};
        snprintf(options, sizeof options, "--transparent --no-ground --samples 1 %s", views[i].options);
        draw(options, &p);
        for (int k = 0; k < WIDTH * HEIGHT; k++)
            drawn[k] = p.rgba[4 * k + 3] > 127;
        project(views[i].seconds, &o, 0, expected);
        assert_true(agree(drawn, expected));
        if (i == 0)
            memcpy(first, expected, sizeof first);
        else
            assert_false(agree(drawn, first)); /* another time or view does not pass */
    }
}

/* What the ground makes darker by more than contact does, beside the surface itself, is the whole of its shadow. */
static void test_the_whole_surface_throws_its_shadow(void **state) {
    static picture with, without;
    static unsigned char body[WIDTH * HEIGHT], shadow[WIDTH * HEIGHT];
    const play_options o = {
        .width = WIDTH, .height = HEIGHT, .up = PLAY_UP_Y, .azimuth = 25, .elevation = 30, .zoom = 0.6};
    int expected = 0, found = 0, stray = 0;
    (void)state;
    draw("--times 0.7 --camera 25,30,0.6", &with);
    draw("--times 0.7 --camera 25,30,0.6 --no-ground", &without);
    project(0.7, &o, 0, body);
    project(0.7, &o, 1, shadow);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const int darker = without.rgba[4 * i + 1] - with.rgba[4 * i + 1] > 35;
        expected += shadow[i] && !body[i];
        found += shadow[i] && !body[i] && darker;
        stray += !shadow[i] && !body[i] && darker;
    }
    assert_true(expected > 200);
    assert_true(found > 0.9 * expected);
    assert_true(stray < 0.15 * expected);
}

/* ---- Stored pictures ------------------------------------------------------------------------------------- */

static void read_stored(const char *name, picture *p) {
    char path[1024];
    png_image image = {.version = PNG_IMAGE_VERSION};
    snprintf(path, sizeof path, "%s/%s.png", NSDF_PICTURES, name);
    assert_true(png_image_begin_read_from_file(&image, path));
    assert_true(image.width == WIDTH && image.height == HEIGHT);
    image.format = PNG_FORMAT_RGBA;
    assert_true(png_image_finish_read(&image, NULL, p->rgba, 0, NULL));
}

/* Drivers round and filter each in their way, at edges above all: the mean difference is to be below 1.5 of 255, and
 * no more than 1 % of the pixels may be off by more than 40. */
static int alike(const picture *a, const picture *b) {
    double sum = 0.0;
    int off = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        int most = 0;
        for (int k = 0; k < 4; k++) {
            const int d = abs(a->rgba[4 * i + k] - b->rgba[4 * i + k]);
            most = d > most ? d : most;
            sum += d;
        }
        off += most > 40;
    }
    return sum < 1.5 * 4.0 * WIDTH * HEIGHT && off < WIDTH * HEIGHT / 100;
}

static void test_pictures_look_as_they_did(void **state) {
    static const char *const options[] = {"--times 0.5", "--times 0.5 --mode flat --camera -40,20",
                                          "--times 0.5 --mode normals --camera 130,10,1.5",
                                          "--times 0.51 --mode wire --ghost --overlay --resolution 32"};
    static const char *const names[] = {"shaded", "flat", "normals", "wire"};
    static picture drawn, stored, shaded;
    (void)state;
    for (int i = 0; i < 4; i++) {
        draw(options[i], &drawn);
        read_stored(names[i], &stored);
        assert_true(alike(&drawn, &stored));
        if (i == 0)
            shaded = drawn;
        else
            assert_false(alike(&shaded, &stored));
    }
}

static void test_a_turn_ends_where_it_began(void **state) {
    static picture p[3];
    (void)state;
    draw("--times 0 --camera 25,12", &p[0]);
    draw("--times 0 --camera 385,12", &p[1]);
    draw("--times 0 --camera 205,12", &p[2]);
    assert_true(alike(&p[0], &p[1]));
    assert_false(alike(&p[0], &p[2]));
}

/* ---- Comparing ------------------------------------------------------------------------------------------- */

/* Meshes of the sample as OBJ, all frames or FRAMES times the one at 1 s. */
static void make_reference(const char *folder, int all) {
    char command[2048], times[16 * FRAMES] = "";
    for (int i = 0; i < FRAMES && !all; i++)
        strcat(times, i ? ",1" : "--times 1");
    snprintf(command, sizeof command, "mkdir -p '%s' && '%s' -q '%s' -o '%s/%%d.obj' --resolution 64 %s", folder,
             NSDF_DEC, NSDF_SAMPLE, folder, times);
    assert_int_equal(system(command), 0);
}

/* The left half of a picture, or its right half, in a picture of its own. */
static void take_half(const picture *from, int right, picture *half) {
    memset(half, 0, sizeof *half);
    for (int y = 0; y < HEIGHT; y++)
        memcpy(half->rgba + (size_t)4 * WIDTH * (size_t)y,
               from->rgba + (size_t)4 * WIDTH * (size_t)y + (right ? 2 * WIDTH : 0), (size_t)2 * WIDTH);
}

static void test_input_and_decoded_are_side_by_side(void **state) {
    static picture both, halves[3];
    (void)state;
    make_reference(NSDF_WORK "/all", 1);
    draw("--times 0.52 --mode flat --resolution 64 --no-overlay --compare '" NSDF_WORK "/all'", &both);
    take_half(&both, 0, &halves[0]);
    take_half(&both, 1, &halves[1]);
    draw("--times 1 --mode flat --resolution 64 --no-overlay --compare '" NSDF_WORK "/all'", &both);
    take_half(&both, 0, &halves[2]);
    assert_true(alike(&halves[0], &halves[1]));
    assert_false(alike(&halves[0], &halves[2]));
}

/* Pixels of the colours' lower and upper ends: violet and yellow. */
static void count_heat(const picture *p, int *cold, int *hot) {
    *cold = *hot = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const unsigned char *c = p->rgba + 4 * i;
        *cold += c[2] > c[1] + 25 && c[0] > c[1] + 10;
        *hot += c[0] > c[2] + 60 && c[1] > c[2] + 60;
    }
}

static void test_heat_is_where_the_surfaces_differ(void **state) {
    static picture p;
    int cold, hot;
    (void)state;
    make_reference(NSDF_WORK "/one", 0);
    draw("--times 1 --heatmap --no-overlay --compare '" NSDF_WORK "/one'", &p);
    count_heat(&p, &cold, &hot);
    assert_true(cold > 1000 && hot == 0);
    draw("--times 0.5 --heatmap --no-overlay --compare '" NSDF_WORK "/one'", &p);
    count_heat(&p, &cold, &hot);
    assert_true(hot > 300);
    draw("--times 0.5 --heatmap --compare '" NSDF_WORK "/all'", &p); /* with its legend, which has both */
    count_heat(&p, &cold, &hot);
    assert_true(cold > 1000 && hot > 20 && hot < 300);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_silhouettes_are_those_of_the_mesh),
        cmocka_unit_test(test_the_whole_surface_throws_its_shadow),
        cmocka_unit_test(test_pictures_look_as_they_did),
        cmocka_unit_test(test_a_turn_ends_where_it_began),
        cmocka_unit_test(test_input_and_decoded_are_side_by_side),
        cmocka_unit_test(test_heat_is_where_the_surfaces_differ),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
