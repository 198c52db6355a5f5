/* Vectors of 3 and matrices of 4 x 4 in columns, as OpenGL takes them. */
#ifndef PLAY_MATRIX_H
#define PLAY_MATRIX_H

#include <math.h>
#include <string.h>

#define PLAY_PI 3.14159265358979323846

typedef struct play_vec3 {
    double x, y, z;
} play_vec3;

typedef struct play_mat4 {
    float m[16];
} play_mat4;

static inline play_vec3 play_add(play_vec3 a, play_vec3 b) {
    return (play_vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline play_vec3 play_scale(play_vec3 a, double s) {
    return (play_vec3){a.x * s, a.y * s, a.z * s};
}

static inline play_vec3 play_subtract(play_vec3 a, play_vec3 b) {
    return play_add(a, play_scale(b, -1.0));
}

static inline double play_dot(play_vec3 a, play_vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline play_vec3 play_cross(play_vec3 a, play_vec3 b) {
    return (play_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline play_vec3 play_unit(play_vec3 a) {
    return play_scale(a, 1.0 / sqrt(play_dot(a, a)));
}

static inline play_mat4 play_multiply(const play_mat4 *a, const play_mat4 *b) {
    play_mat4 c;
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 4; row++) {
            float sum = 0.0f;
            for (int k = 0; k < 4; k++)
                sum += a->m[4 * k + row] * b->m[4 * column + k];
            c.m[4 * column + row] = sum;
        }
    return c;
}

/* From the world to a viewer at `eye` who looks along -z: right, up and back are unit vectors at right angles. */
static inline play_mat4 play_view(play_vec3 eye, play_vec3 right, play_vec3 up, play_vec3 back) {
    const play_vec3 axis[3] = {right, up, back};
    play_mat4 v = {{0.0f}};
    for (int row = 0; row < 3; row++) {
        v.m[row] = (float)axis[row].x;
        v.m[4 + row] = (float)axis[row].y;
        v.m[8 + row] = (float)axis[row].z;
        v.m[12 + row] = (float)-play_dot(axis[row], eye);
    }
    v.m[15] = 1.0f;
    return v;
}

/* tangent: of half the angle of view, along x and y. */
static inline play_mat4 play_perspective(double tangent_x, double tangent_y, double near, double far) {
    play_mat4 p = {{0.0f}};
    p.m[0] = (float)(1.0 / tangent_x);
    p.m[5] = (float)(1.0 / tangent_y);
    p.m[10] = (float)(-(far + near) / (far - near));
    p.m[11] = -1.0f;
    p.m[14] = (float)(-2.0 * far * near / (far - near));
    return p;
}

/* A box of half sizes x and y, from `near` to `far` in front of the viewer. */
static inline play_mat4 play_orthographic(double x, double y, double near, double far) {
    play_mat4 p = {{0.0f}};
    p.m[0] = (float)(1.0 / x);
    p.m[5] = (float)(1.0 / y);
    p.m[10] = (float)(-2.0 / (far - near));
    p.m[14] = (float)(-(far + near) / (far - near));
    p.m[15] = 1.0f;
    return p;
}

#endif
