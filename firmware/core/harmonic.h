/* harmonic.h - the circles of the closed forms (private to the core). */
#ifndef TUMBLE_CORE_HARMONIC_H
#define TUMBLE_CORE_HARMONIC_H

#include "tumble/core.h"

#include <stdbool.h>

/* How many circles K_ij is the mean of; 0 when the one with this normal is not among them. A circle tells K_ij if it
 * holds the axis j. `refined`: where circles hold both axes i and j, they alone count. */
uint8_t tumble_circle_share(const tumble_harmonic_map_t *map, bool refined, int i, int j, int normal);

#endif
