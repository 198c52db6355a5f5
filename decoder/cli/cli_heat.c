#include "cli_heat.h"

#include <math.h>

const uint8_t nsdf_cli_heat_ramp[NSDF_CLI_HEAT_COLOURS][3] = {{68, 1, 84},    {71, 45, 123},  {59, 82, 139},
                                                              {44, 114, 142}, {33, 144, 140}, {39, 173, 129},
                                                              {93, 200, 99},  {170, 220, 50}, {253, 231, 37}};

void nsdf_cli_heat_colour(double share, uint8_t rgb[3]) {
    enum { STEPS = NSDF_CLI_HEAT_COLOURS - 1 };
    const double at = STEPS * (share < 0.0 ? 0.0 : share > 1.0 ? 1.0 : share);
    const int step = at >= STEPS ? STEPS - 1 : (int)at;
    const uint8_t *low = nsdf_cli_heat_ramp[step], *high = nsdf_cli_heat_ramp[step + 1];
    for (int k = 0; k < 3; k++)
        rgb[k] = (uint8_t)lround(low[k] + (at - step) * (high[k] - low[k]));
}
