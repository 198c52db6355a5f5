#include "rotation.h"

#include <math.h>
#include <string.h>

/* Turns r by the rotation vector w. */
static void turn(double r[9], const double w[3], double angle) {
    const double x = w[0] / angle, y = w[1] / angle, z = w[2] / angle, c = cos(angle), s = sin(angle), k = 1.0 - c;
    const double q[9] = {c + x * x * k,     x * y * k - z * s, x * z * k + y * s, y * x * k + z * s, c + y * y * k,
                         y * z * k - x * s, z * x * k - y * s, z * y * k + x * s, c + z * z * k};
    double turned[9];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            turned[3 * i + j] = q[3 * i] * r[j] + q[3 * i + 1] * r[3 + j] + q[3 * i + 2] * r[6 + j];
    memcpy(r, turned, sizeof turned);
}

void nsdf_extract_rotation(const double a[9], double r[9]) {
    for (int step = 0; step < 20; step++) {
        double w[3] = {0.0, 0.0, 0.0}, along = 0.0;
        for (int c = 0; c < 3; c++) {
            w[0] += r[3 + c] * a[6 + c] - r[6 + c] * a[3 + c];
            w[1] += r[6 + c] * a[c] - r[c] * a[6 + c];
            w[2] += r[c] * a[3 + c] - r[3 + c] * a[c];
            along += r[c] * a[c] + r[3 + c] * a[3 + c] + r[6 + c] * a[6 + c];
        }
        const double scale = 1.0 / (fabs(along) + 1e-30);
        const double angle = scale * sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
        if (!(angle > 1e-9))
            return;
        for (int i = 0; i < 3; i++)
            w[i] *= scale;
        turn(r, w, angle);
    }
}
