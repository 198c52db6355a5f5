#include "optimiser.h"

#include <math.h>
#include <stdlib.h>

int nsdf_adam_create(nsdf_adam *adam, size_t count) {
    const size_t room = count > 0 ? count : 1;
    nsdf_adam a = {calloc(room, sizeof(float)), calloc(room, sizeof(float)), count, 0.9f, 0.99f, 1e-8f, 0};
    *adam = a;
    if (a.mean && a.square)
        return 0;
    nsdf_adam_free(adam);
    return -1;
}

void nsdf_adam_free(nsdf_adam *adam) {
    free(adam->mean);
    free(adam->square);
    adam->mean = adam->square = NULL;
}

void nsdf_adam_step(nsdf_adam *adam, float *parameters, const float *gradient, double rate) {
    adam->step++;
    double unbias1 = 1.0 - pow((double)adam->beta1, (double)adam->step);
    double unbias2 = 1.0 - pow((double)adam->beta2, (double)adam->step);
    float r = (float)(rate * sqrt(unbias2) / unbias1), epsilon = (float)((double)adam->epsilon * sqrt(unbias2));
    float b1 = adam->beta1, b2 = adam->beta2;
    float *restrict mean = adam->mean, *restrict square = adam->square;
    for (size_t i = 0; i < adam->count; i++) {
        float g = gradient[i];
        mean[i] = b1 * mean[i] + (1.0f - b1) * g;
        square[i] = b2 * square[i] + (1.0f - b2) * g * g;
        parameters[i] -= r * mean[i] / (sqrtf(square[i]) + epsilon);
    }
}

double nsdf_rate_schedule(uint64_t step, uint64_t steps, double peak) {
    double warm = 0.01 * (double)steps, at = (double)step + 1.0;
    if (at < warm)
        return peak * at / warm;
    double f = (at - warm) / ((double)steps - warm + 1.0);
    return peak * (0.01 + 0.99 * 0.5 * (1.0 + cos(3.14159265358979 * (f < 1.0 ? f : 1.0))));
}
