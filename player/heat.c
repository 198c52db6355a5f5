#include "heat.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* viridis (van der Walt and Smith 2015, CC0), as in the heat maps of nsdf-cmp. */
const float play_heat_ramp[PLAY_HEAT_COLOURS][3] = {
    {0.267f, 0.004f, 0.329f}, {0.278f, 0.176f, 0.482f}, {0.231f, 0.322f, 0.545f},
    {0.173f, 0.447f, 0.557f}, {0.129f, 0.565f, 0.549f}, {0.153f, 0.678f, 0.506f},
    {0.365f, 0.784f, 0.388f}, {0.667f, 0.863f, 0.196f}, {0.992f, 0.906f, 0.145f}};

nsdf_status play_heat_measure(nsdf_decoder *decoder, double t, const float *points, size_t count, double top,
                              float *share) {
    float *gradient = malloc(count * 3 * sizeof *gradient + 1);
    if (!gradient)
        return NSDF_NO_MEMORY;
    const nsdf_status status = nsdf_evaluate(decoder, t, points, count, share, gradient);
    for (size_t i = 0; status == NSDF_OK && i < count; i++) {
        const float *g = gradient + 3 * i;
        const double slope = sqrt((double)g[0] * g[0] + (double)g[1] * g[1] + (double)g[2] * g[2]);
        share[i] = (float)fmin(fabs((double)share[i]) / fmax(slope, 0.25) / top, 1.0);
    }
    free(gradient);
    return status;
}

static play_colour colour_at(double share) {
    const double at = share * (PLAY_HEAT_COLOURS - 1);
    const int step = at >= PLAY_HEAT_COLOURS - 2 ? PLAY_HEAT_COLOURS - 2 : (int)at;
    play_colour colour = 0;
    for (int k = 0; k < 3; k++) {
        const double low = (double)play_heat_ramp[step][k], high = (double)play_heat_ramp[step + 1][k];
        colour = colour << 8 | (play_colour)lround(255.0 * (low + (at - step) * (high - low)));
    }
    return colour << 8 | 0xff;
}

void play_heat_legend(play_overlay *o, double top_of_diagonal, int width, int height) {
    enum { STEPS = 64 };
    static const play_colour ink = 0x20242cff;
    const float scale = height >= 480 ? 2.0f : 1.0f, margin = 12.0f * scale, step = scale;
    const float top = (float)height - 2.0f * margin;
    char text[64];
    snprintf(text, sizeof text, "%.3g of the diagonal", top_of_diagonal);
    const float right = (float)width - margin - play_overlay_text_width(text, scale);
    const float left = right - 6.0f * scale - STEPS * step;
    for (int i = 0; i < STEPS; i++)
        play_overlay_box(o, left + step * (float)i, top, step, 7.0f * scale, colour_at((i + 0.5) / STEPS));
    play_overlay_text(o, left - 10.0f * scale, top, scale, ink, "0");
    play_overlay_text(o, right, top, scale, ink, text);
}
