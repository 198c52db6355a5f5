#include <math.h>

#include "network_write.h"

float nsdf_dequantise(int32_t q, float step, float offset) {
    return (float)((double)offset + (double)step * (double)q);
}

int nsdf_quantise(const float *values, size_t count, float step, float offset, int32_t *q) {
    for (size_t i = 0; i < count; i++) {
        double difference = (double)values[i] - (double)offset;
        double level = step > 0.0f ? rint(difference / (double)step) : 0.0;
        if (!isfinite(difference) || !(fabs(level) < (double)NSDF_MAX_QUANTISED))
            return -1;
        q[i] = (int32_t)level;
    }
    return 0;
}

void nsdf_minmax_quantiser(const float *values, size_t count, int bits, float *step, float *offset) {
    float low = count ? values[0] : 0.0f, high = low;
    for (size_t i = 1; i < count; i++) {
        low = values[i] < low ? values[i] : low;
        high = values[i] > high ? values[i] : high;
    }
    uint32_t steps = (UINT32_C(1) << bits) - 1, middle = (steps + 1) / 2;
    double exact = ((double)high - (double)low) / (double)steps;
    *step = (float)exact;
    *offset = *step > 0.0f ? (float)((double)low + exact * (double)middle) : low;
}
