/* harmonic.h - the circles of the closed forms (private to the core). */
#ifndef TUMBLE_CORE_HARMONIC_H
#define TUMBLE_CORE_HARMONIC_H

#include "tumble/core.h"

#include <stdbool.h>

#define TUMBLE_STEPS 9U /* 0, 45, ... 360 degrees: steps 1 to 9 */
#define TUMBLE_NOWHERE UINT8_MAX

/* What one mounting offers to the closed forms. */
typedef struct {
    uint8_t index[TUMBLE_STEPS + 2U]; /* by step: of the position in the schedule, or TUMBLE_NOWHERE; ends private */
    uint8_t over; /* its harmonics are over this: 8 for all nine steps, 4 for the diagonals alone; 0: it is no circle */
    uint8_t normal; /* the block axis along the stand's axis, normal to the circle */
} tumble_circle_t;

/* The circle of the mounting at index `m`. Of several positions at one step the first that is measured counts; if none
 * is, the circle holds one of them. */
void tumble_circle_find(const tumble_schedule_t *schedule, const bool *measured, uint8_t m, tumble_circle_t *circle);

/* How many circles K_ij is the mean of; 0 when the one with this normal is not among them. A circle tells K_ij if it
 * holds the axis j. `refined`: where circles hold both axes i and j, they alone count. */
uint8_t tumble_circle_share(const tumble_harmonic_map_t *map, bool refined, int i, int j, int normal);

/* Of all mountings: U0 is the mean of so many. */
uint8_t tumble_circle_count(const tumble_harmonic_map_t *map);

#endif
