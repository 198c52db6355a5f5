#include "heat.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "cli_heat.h"

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
    uint8_t rgb[3];
    nsdf_cli_heat_colour(share, rgb);
    return (play_colour)rgb[0] << 24 | (play_colour)rgb[1] << 16 | (play_colour)rgb[2] << 8 | 0xff;
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
