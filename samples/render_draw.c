#include "render_draw.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SUPERSAMPLE = 3, SHADOW_SIZE = 256, OCCLUSION_SAMPLES = 20 };

static const double degree = 0.017453292519943295;

/* Eye space: x right, y up, z towards the eye; the eye is at (0, 0, eye), the scene's ball of radius 1 at the origin.
 */
typedef struct camera {
    double rotation[3][3], centre[3], scale; /* eye space = rotation * (world - centre) * scale */
    double eye, zoom;                        /* picture plane: x * zoom / (eye - z), in -1 .. 1 */
    double ground;                           /* height of the floor, world units */
    double light[3];                         /* direction to the shadow's light, world space */
} camera;

typedef struct fragment {
    float depth; /* z in eye space; larger is nearer; -INFINITY where there is no surface */
    float normal[3];
} fragment;

typedef struct canvas {
    uint32_t size;       /* pixels along a side, supersampled */
    fragment *fragments; /* [size][size] */
    float *shadow;       /* [SHADOW_SIZE][SHADOW_SIZE]: 1 = dark; covers the floor within 2.5 radii */
} canvas;

typedef struct corner {
    double x, y, w; /* pixels; w is what is interpolated along with the position */
    double attribute[4];
} corner;

typedef void (*plot_fn)(canvas *c, uint32_t x, uint32_t y, const double attribute[4]);

static camera make_camera(const nsdf_render_view *view) {
    camera c = {.eye = 4.6, .zoom = 4.25, .ground = view->box_min[1], .light = {0.35, 1.0, 0.30}};
    double radius = 0, turn = view->turn * degree, rise = view->rise * degree;
    for (int i = 0; i < 3; i++) {
        double half = (view->box_max[i] - view->box_min[i]) / 2;
        c.centre[i] = view->box_min[i] + half;
        radius += half * half;
    }
    c.scale = radius > 0 ? 1 / sqrt(radius) : 1;
    const double rotation[3][3] = {{cos(turn), 0, -sin(turn)},
                                   {-sin(rise) * sin(turn), cos(rise), -sin(rise) * cos(turn)},
                                   {cos(rise) * sin(turn), sin(rise), cos(rise) * cos(turn)}};
    memcpy(c.rotation, rotation, sizeof rotation);
    return c;
}

static void rotate(const camera *c, const double v[3], double out[3]) {
    for (int i = 0; i < 3; i++)
        out[i] = c->rotation[i][0] * v[0] + c->rotation[i][1] * v[1] + c->rotation[i][2] * v[2];
}

static void rotate_back(const camera *c, const double v[3], double out[3]) {
    for (int i = 0; i < 3; i++)
        out[i] = c->rotation[0][i] * v[0] + c->rotation[1][i] * v[1] + c->rotation[2][i] * v[2];
}

/* Calls plot for every pixel centre in the triangle, with the attributes interpolated linearly on the picture. */
static void fill_triangle(canvas *c, uint32_t size, const corner v[3], plot_fn plot) {
    double area = (v[1].x - v[0].x) * (v[2].y - v[0].y) - (v[1].y - v[0].y) * (v[2].x - v[0].x);
    double low_x = fmin(v[0].x, fmin(v[1].x, v[2].x)), high_x = fmax(v[0].x, fmax(v[1].x, v[2].x));
    double low_y = fmin(v[0].y, fmin(v[1].y, v[2].y)), high_y = fmax(v[0].y, fmax(v[1].y, v[2].y));
    if (area == 0 || !(high_x >= 0 && high_y >= 0 && low_x < size && low_y < size))
        return;
    uint32_t x0 = (uint32_t)fmax(low_x, 0), x1 = (uint32_t)fmin(high_x, size - 1);
    uint32_t y0 = (uint32_t)fmax(low_y, 0), y1 = (uint32_t)fmin(high_y, size - 1);
    for (uint32_t y = y0; y <= y1; y++)
        for (uint32_t x = x0; x <= x1; x++) {
            double px = x + 0.5, py = y + 0.5, weight[3], attribute[4] = {0};
            for (int i = 0; i < 3; i++) {
                const corner *a = &v[(i + 1) % 3], *b = &v[(i + 2) % 3];
                weight[i] = ((b->x - a->x) * (py - a->y) - (b->y - a->y) * (px - a->x)) / area;
            }
            if (weight[0] < 0 || weight[1] < 0 || weight[2] < 0)
                continue;
            for (int i = 0; i < 3; i++)
                for (int k = 0; k < 4; k++)
                    attribute[k] += weight[i] * v[i].attribute[k];
            plot(c, x, y, attribute);
        }
}

static void plot_surface(canvas *c, uint32_t x, uint32_t y, const double attribute[4]) {
    fragment *f = &c->fragments[(size_t)y * c->size + x];
    if ((float)attribute[3] <= f->depth)
        return;
    f->depth = (float)attribute[3];
    for (int i = 0; i < 3; i++)
        f->normal[i] = (float)attribute[i];
}

static void plot_shadow(canvas *c, uint32_t x, uint32_t y, const double attribute[4]) {
    (void)attribute;
    c->shadow[y * SHADOW_SIZE + x] = 1;
}

static corner project(const camera *c, uint32_t size, const double position[3], const double normal[3]) {
    double world[3], eye[3];
    corner out;
    for (int i = 0; i < 3; i++)
        world[i] = (position[i] - c->centre[i]) * c->scale;
    rotate(c, world, eye);
    double away = fmax(c->eye - eye[2], 0.1);
    out.x = (1 + eye[0] * c->zoom / away) * size / 2;
    out.y = (1 - eye[1] * c->zoom / away) * size / 2;
    rotate(c, normal, out.attribute);
    double length = sqrt(out.attribute[0] * out.attribute[0] + out.attribute[1] * out.attribute[1] +
                         out.attribute[2] * out.attribute[2]);
    for (int i = 0; i < 3; i++)
        out.attribute[i] = length > 0 ? out.attribute[i] / length : 0;
    out.attribute[3] = eye[2];
    out.w = 1;
    return out;
}

/* Where a point's shadow falls on the floor, in pixels of the shadow map. */
static corner cast_shadow(const camera *c, const double position[3]) {
    double height = position[1] - c->ground;
    corner out = {.w = 1};
    out.x = (position[0] - c->light[0] / c->light[1] * height - c->centre[0]) * c->scale;
    out.y = (position[2] - c->light[2] / c->light[1] * height - c->centre[2]) * c->scale;
    out.x = (out.x / 5 + 0.5) * SHADOW_SIZE;
    out.y = (out.y / 5 + 0.5) * SHADOW_SIZE;
    return out;
}

static void draw_triangles(canvas *c, const camera *cam, const nsdf_render_mesh *mesh) {
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        corner surface[3], shadow[3];
        for (int k = 0; k < 3; k++) {
            size_t vertex = mesh->triangles[3 * i + (size_t)k];
            surface[k] = project(cam, c->size, mesh->positions + 3 * vertex, mesh->normals + 3 * vertex);
            shadow[k] = cast_shadow(cam, mesh->positions + 3 * vertex);
        }
        fill_triangle(c, c->size, surface, plot_surface);
        fill_triangle(c, SHADOW_SIZE, shadow, plot_shadow);
    }
}

/* One box blur of a row or column of the shadow map. */
static void blur_line(float *line, size_t step, int radius) {
    float sum = 0, copy[SHADOW_SIZE];
    for (int i = 0; i < SHADOW_SIZE; i++)
        copy[i] = line[(size_t)i * step];
    for (int i = -radius; i < SHADOW_SIZE; i++) {
        if (i + radius < SHADOW_SIZE)
            sum += copy[i + radius];
        if (i - radius - 1 >= 0)
            sum -= copy[i - radius - 1];
        if (i >= 0)
            line[(size_t)i * step] = sum / (float)(2 * radius + 1);
    }
}

/* Three box blurs come close to a Gaussian. */
static void blur_shadow(canvas *c) {
    for (int pass = 0; pass < 3; pass++)
        for (size_t i = 0; i < SHADOW_SIZE; i++) {
            blur_line(c->shadow + i * SHADOW_SIZE, 1, 3);
            blur_line(c->shadow + i, SHADOW_SIZE, 3);
        }
}

static double shadow_at(const canvas *c, double x, double y) {
    if (!(x >= 0 && y >= 0 && x < SHADOW_SIZE - 1 && y < SHADOW_SIZE - 1))
        return 0;
    size_t i = (size_t)x, j = (size_t)y;
    double u = x - (double)i, v = y - (double)j;
    const float *s = c->shadow + j * SHADOW_SIZE + i;
    return (1 - v) * ((1 - u) * s[0] + u * s[1]) + v * ((1 - u) * s[SHADOW_SIZE] + u * s[SHADOW_SIZE + 1]);
}

/* The floor behind a pixel: white that fades to light grey upwards, darker in the shadow. */
static void shade_background(const canvas *c, const camera *cam, double x, double y, double out[3]) {
    double ray[3] = {(2 * x / c->size - 1) / cam->zoom, (1 - 2 * y / c->size) / cam->zoom, -1},
           eye[3] = {0, 0, cam->eye};
    double direction[3], origin[3], dark = 0;
    rotate_back(cam, ray, direction);
    rotate_back(cam, eye, origin);
    double floor_height = (cam->ground - cam->centre[1]) * cam->scale;
    if (direction[1] < 0) {
        double t = (floor_height - origin[1]) / direction[1];
        double fx = origin[0] + t * direction[0], fz = origin[2] + t * direction[2];
        dark = shadow_at(c, (fx / 5 + 0.5) * SHADOW_SIZE - 0.5, (fz / 5 + 0.5) * SHADOW_SIZE - 0.5);
    }
    double base = 0.80 + 0.16 * y / c->size;
    out[0] = base * (1 - 0.60 * dark);
    out[1] = base * (1 - 0.59 * dark);
    out[2] = base * (1 - 0.56 * dark);
}

/* How open the surroundings are, 1 = fully: the share of nearby points on a spiral that do not lie in front. */
static double openness(const canvas *c, uint32_t x, uint32_t y) {
    const fragment *here = &c->fragments[(size_t)y * c->size + x];
    const double reach = 0.16; /* eye units */
    double blocked = 0, start = 2.399963 * (double)((x * 7u + y * 13u) % 16u);
    for (int i = 0; i < OCCLUSION_SAMPLES; i++) {
        double r = reach * sqrt((i + 0.5) / OCCLUSION_SAMPLES), angle = start + 2.399963 * i; /* golden angle */
        double sx = x + r * cos(angle) * c->size / 2, sy = y + r * sin(angle) * c->size / 2;
        if (!(sx >= 0 && sy >= 0 && sx < c->size && sy < c->size))
            continue;
        double dx = r * cos(angle), dy = -r * sin(angle);
        double dz = (double)c->fragments[(size_t)sy * c->size + (size_t)sx].depth - (double)here->depth;
        double along = dx * (double)here->normal[0] + dy * (double)here->normal[1] + dz * (double)here->normal[2];
        if (along > 0.004 && dz < 2 * reach)
            blocked += along / sqrt(dx * dx + dy * dy + dz * dz);
    }
    return 1 - fmin(1, 1.5 * blocked / OCCLUSION_SAMPLES);
}

static double lambert(const float n[3], double x, double y, double z) {
    double length = sqrt(x * x + y * y + z * z);
    return ((double)n[0] * x + (double)n[1] * y + (double)n[2] * z) / length;
}

/* A warm key light from the upper left, a cool fill from the right, light from the sky and the floor. */
static void shade_surface(const canvas *c, const double colour[3], uint32_t x, uint32_t y, double out[3]) {
    fragment f = c->fragments[(size_t)y * c->size + x];
    double length = sqrt((double)(f.normal[0] * f.normal[0] + f.normal[1] * f.normal[1] + f.normal[2] * f.normal[2]));
    for (int i = 0; i < 3 && length > 0; i++)
        f.normal[i] /= (float)length;
    double open = openness(c, x, y);
    double key = fmax(lambert(f.normal, -0.55, 0.75, 0.75), 0), fill = fmax(lambert(f.normal, 0.9, 0.15, 0.5), 0);
    double sky = 0.5 + 0.5 * (double)f.normal[1], glint = pow(fmax(lambert(f.normal, -0.32, 0.42, 1.4), 0), 40);
    double rim = pow(1 - fmin(1, fmax((double)f.normal[2], 0)), 3);
    const double warm[3] = {1.00, 0.96, 0.90}, cool[3] = {0.80, 0.90, 1.00};
    for (int i = 0; i < 3; i++) {
        double light = 0.78 * key * warm[i] * (0.4 + 0.6 * open) + 0.22 * fill * cool[i] * open;
        light += (0.16 + 0.20 * sky) * open * cool[i];
        out[i] = colour[i] * light + 0.07 * glint * open + 0.10 * rim * sky * open;
    }
}

static uint8_t encode(double linear) {
    double v = linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055; /* sRGB */
    return (uint8_t)(255 * fmin(fmax(v, 0), 1) + 0.5);
}

/* One pixel of the picture: the mean of its supersamples. */
static void resolve_pixel(const canvas *c, const camera *cam, const double colour[3], uint32_t x, uint32_t y,
                          uint8_t *rgb) {
    double sum[3] = {0};
    for (uint32_t j = 0; j < SUPERSAMPLE; j++)
        for (uint32_t i = 0; i < SUPERSAMPLE; i++) {
            uint32_t sx = x * SUPERSAMPLE + i, sy = y * SUPERSAMPLE + j;
            double sample[3];
            if (c->fragments[(size_t)sy * c->size + sx].depth > -INFINITY)
                shade_surface(c, colour, sx, sy, sample);
            else
                shade_background(c, cam, sx + 0.5, sy + 0.5, sample);
            for (int k = 0; k < 3; k++)
                sum[k] += sample[k] / (SUPERSAMPLE * SUPERSAMPLE);
        }
    for (int k = 0; k < 3; k++)
        rgb[k] = encode(sum[k]);
}

int nsdf_render_draw(const nsdf_render_mesh *mesh, const nsdf_render_view *view, uint32_t size, uint8_t *rgb,
                     size_t stride) {
    canvas c = {.size = size * SUPERSAMPLE};
    size_t count = (size_t)c.size * c.size;
    c.fragments = malloc(count * sizeof *c.fragments);
    c.shadow = calloc(SHADOW_SIZE * SHADOW_SIZE, sizeof *c.shadow);
    int status = c.fragments && c.shadow ? 0 : -1;
    if (status == 0) {
        camera cam = make_camera(view);
        for (size_t i = 0; i < count; i++)
            c.fragments[i] = (fragment){.depth = -INFINITY};
        draw_triangles(&c, &cam, mesh);
        blur_shadow(&c);
        for (uint32_t y = 0; y < size; y++)
            for (uint32_t x = 0; x < size; x++)
                resolve_pixel(&c, &cam, view->colour, x, y, rgb + y * stride + (size_t)x * 3);
    }
    free(c.fragments);
    free(c.shadow);
    return status;
}
