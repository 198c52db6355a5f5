#include "camera.h"

#include <stddef.h>

static const double margin = 1.08; /* around the box */

static double radians(double degrees) {
    return degrees * PLAY_PI / 180.0;
}

static double clamp(double x, double low, double high) {
    return x < low ? low : x > high ? high : x;
}

void play_up_axes(play_up up, play_vec3 axes[3]) {
    static const play_vec3 all[3][3] = {{{0, 1, 0}, {1, 0, 0}, {0, 0, -1}},  /* x is up */
                                        {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},   /* y */
                                        {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}}; /* z */
    const int negative = up >= PLAY_UP_NEGATIVE_X;
    memcpy(axes, all[up % 3], sizeof all[0]);
    if (negative) { /* half a turn around the axis towards the viewer */
        axes[0] = play_scale(axes[0], -1.0);
        axes[1] = play_scale(axes[1], -1.0);
    }
}

int play_up_parse(const char *text, play_up *up) {
    const int negative = text[0] == '-';
    const char *axis = text + (negative || text[0] == '+');
    if (axis[0] < 'x' || axis[0] > 'z' || axis[1] != '\0')
        return -1;
    *up = (play_up)(axis[0] - 'x' + (negative ? 3 : 0));
    return 0;
}

/* ---- Fitting --------------------------------------------------------------------------------------------- */

static void find_axes(const play_camera *c, play_vec3 *right, play_vec3 *up, play_vec3 *back) {
    play_vec3 axes[3];
    play_up_axes(c->up, axes);
    const double a = radians(c->azimuth), e = radians(c->elevation);
    const play_vec3 level = play_add(play_scale(axes[0], sin(a)), play_scale(axes[2], cos(a)));
    *right = play_add(play_scale(axes[0], cos(a)), play_scale(axes[2], -sin(a)));
    *back = play_add(play_scale(level, cos(e)), play_scale(axes[1], sin(e)));
    *up = play_cross(*back, *right);
}

static void tangents(const play_camera *c, double aspect, double *x, double *y) {
    const double shorter = tan(radians(0.5 * c->angle));
    *x = aspect >= 1.0 ? shorter * aspect : shorter;
    *y = aspect >= 1.0 ? shorter : shorter / aspect;
}

static play_vec3 corner(const play_box *box, int which) {
    return (play_vec3){which & 1 ? box->high[0] : box->low[0], which & 2 ? box->high[1] : box->low[1],
                       which & 4 ? box->high[2] : box->low[2]};
}

void play_camera_fit(play_camera *c, const play_box *box, double aspect) {
    play_vec3 right, up, back;
    double tangent_x, tangent_y, distance = 0.0;
    find_axes(c, &right, &up, &back);
    tangents(c, aspect, &tangent_x, &tangent_y);
    c->middle = play_scale(play_add(corner(box, 0), corner(box, 7)), 0.5);
    c->target = c->middle;
    const play_vec3 half = play_subtract(corner(box, 7), c->middle);
    c->reach = 2.0 * sqrt(play_dot(half, half)) + 1e-12;
    for (int i = 0; i < 8; i++) {
        const play_vec3 p = play_subtract(corner(box, i), c->target);
        const double x = fabs(play_dot(p, right)) / tangent_x, y = fabs(play_dot(p, up)) / tangent_y;
        distance = fmax(distance, margin * fmax(x, y) + play_dot(p, back));
    }
    c->distance = fmax(distance, 1e-9);
    c->zoom = 1.0;
}

play_camera play_camera_make(const play_box *box, play_up up, double aspect) {
    play_camera c = {.up = up, .azimuth = 25.0, .elevation = 12.0, .zoom = 1.0, .angle = 28.0};
    play_camera_fit(&c, box, aspect);
    return c;
}

/* ---- Moving ---------------------------------------------------------------------------------------------- */

void play_camera_orbit(play_camera *c, double azimuth, double elevation) {
    c->azimuth = fmod(c->azimuth + azimuth, 360.0);
    c->elevation = clamp(c->elevation + elevation, -89.0, 89.0);
}

void play_camera_pan(play_camera *c, double right, double up) {
    play_vec3 axis_right, axis_up, back;
    find_axes(c, &axis_right, &axis_up, &back);
    const double size = 2.0 * tan(radians(0.5 * c->angle)) * c->distance / c->zoom;
    c->target = play_add(c->target, play_add(play_scale(axis_right, -right * size), play_scale(axis_up, -up * size)));
}

void play_camera_zoom(play_camera *c, double factor) {
    c->zoom = clamp(c->zoom * factor, 0.05, 50.0);
}

play_eye play_camera_eye(const play_camera *c, double aspect) {
    play_eye eye;
    find_axes(c, &eye.right, &eye.up, &eye.back);
    tangents(c, aspect, &eye.tangent_x, &eye.tangent_y);
    eye.position = play_add(c->target, play_scale(eye.back, c->distance / c->zoom));
    const double away = play_dot(play_subtract(eye.position, c->middle), eye.back);
    eye.far = fmax(away + c->reach, 0.02 * c->reach);
    eye.near = fmax(away - c->reach, 0.001 * eye.far);
    const play_mat4 view = play_view(eye.position, eye.right, eye.up, eye.back);
    const play_mat4 projection = play_perspective(eye.tangent_x, eye.tangent_y, eye.near, eye.far);
    eye.clip_of_world = play_multiply(&projection, &view);
    return eye;
}

play_vec3 play_key_light(const play_eye *eye, play_vec3 up) {
    const play_vec3 front = play_unit(play_cross(eye->right, up));
    return play_unit(play_add(play_add(play_scale(eye->right, -0.55), play_scale(front, 0.75)), up));
}

void play_eye_project(const play_eye *eye, const double point[3], double *x, double *y) {
    const play_vec3 p = play_subtract((play_vec3){point[0], point[1], point[2]}, eye->position);
    const double away = -play_dot(p, eye->back);
    *x = 0.5 + 0.5 * play_dot(p, eye->right) / (away * eye->tangent_x);
    *y = 0.5 - 0.5 * play_dot(p, eye->up) / (away * eye->tangent_y);
}
