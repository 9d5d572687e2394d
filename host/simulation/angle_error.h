/* angle_error.h - alpha4: how far a set table angle is from where the table really stops.
 *
 * One draw for every time that an angle is reached. Each position of the schedule has a stream of its own, so that
 * measuring one again, or passing through other angles, shifts no other draw.
 */
#ifndef TUMBLE_SIMULATION_ANGLE_ERROR_H
#define TUMBLE_SIMULATION_ANGLE_ERROR_H

#include "simulation/random.h"
#include "tumble/core.h"

#include <stdint.h>

typedef struct {
    const tumble_schedule_t *schedule;
    sim_law_t law;
    double limit_rad;
    uint8_t position; /* index in the schedule of the position under way: kept up to date by its owner */
    sim_random_t at_position[TUMBLE_MAX_POSITIONS];
    sim_random_t between;
} sim_angle_error_t;

void sim_angle_error_init(sim_angle_error_t *error, uint64_t seed, const tumble_schedule_t *schedule, sim_law_t law,
                          double limit_rad);

/* The error (rad) with which the table stops at `angle_deg`: a draw of the position under way when that is its angle,
 * but for whole turns and within `resolution_deg`, else a draw for angles in between. */
double sim_angle_error_draw(sim_angle_error_t *error, double angle_deg, double resolution_deg);

#endif
