#include "rate_term.h"

void nsdf_add_rate_term(const float *values, size_t count, size_t apart, float step, float scale, float *slope) {
    const float square = step * step;
    for (size_t i = apart; i < count; i++) {
        const float r = values[i] - (apart > 0 ? values[i - apart] : 0.0f), d = scale * r / (r * r + square);
        slope[i] += d;
        if (apart > 0)
            slope[i - apart] -= d;
    }
}
