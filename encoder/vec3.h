/* Three doubles as a vector. */
#ifndef NSDF_VEC3_H
#define NSDF_VEC3_H

#include <math.h>

typedef struct nsdf_vec3 {
    double x, y, z;
} nsdf_vec3;

static inline nsdf_vec3 nsdf_vec3_load(const float xyz[3]) {
    return (nsdf_vec3){(double)xyz[0], (double)xyz[1], (double)xyz[2]};
}

static inline nsdf_vec3 nsdf_vec3_add(nsdf_vec3 a, nsdf_vec3 b) {
    return (nsdf_vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline nsdf_vec3 nsdf_vec3_sub(nsdf_vec3 a, nsdf_vec3 b) {
    return (nsdf_vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}

/* a + s b */
static inline nsdf_vec3 nsdf_vec3_mad(nsdf_vec3 a, double s, nsdf_vec3 b) {
    return (nsdf_vec3){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}

static inline nsdf_vec3 nsdf_vec3_scale(double s, nsdf_vec3 a) {
    return (nsdf_vec3){s * a.x, s * a.y, s * a.z};
}

static inline double nsdf_vec3_dot(nsdf_vec3 a, nsdf_vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline nsdf_vec3 nsdf_vec3_cross(nsdf_vec3 a, nsdf_vec3 b) {
    return (nsdf_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline double nsdf_vec3_length(nsdf_vec3 a) {
    return sqrt(nsdf_vec3_dot(a, a));
}

#endif
