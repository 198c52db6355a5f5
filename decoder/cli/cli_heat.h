/* Colours of heat maps. */
#ifndef NSDF_CLI_HEAT_H
#define NSDF_CLI_HEAT_H

#include <stdint.h>

enum { NSDF_CLI_HEAT_COLOURS = 9 };

/* Evenly spaced colours of viridis (van der Walt and Smith 2015, CC0), from dark violet over green to yellow: equal
 * steps of distance look like equal steps of colour, and keep their order in grey. */
extern const uint8_t nsdf_cli_heat_ramp[NSDF_CLI_HEAT_COLOURS][3];

/* The colour at a share, clamped to 0..1. */
void nsdf_cli_heat_colour(double share, uint8_t rgb[3]);

#endif
