#include "simulation/angle_error.h"

#include <math.h> /* floor, fabs: exact */
#include <stdbool.h>

void sim_angle_error_init(sim_angle_error_t *error, uint64_t seed, const tumble_schedule_t *schedule, sim_law_t law,
                          double limit_rad)
{
    error->schedule = schedule;
    error->law = law;
    error->limit_rad = limit_rad;
    error->position = 0;
    for (uint32_t i = 0; i < schedule->position_count; i++) {
        sim_random_open(&error->at_position[i], seed, SIM_CAUSE_ANGLE, i);
    }
    sim_random_open(&error->between, seed, SIM_CAUSE_ANGLE_BETWEEN, 0);
}

double sim_angle_error_draw(sim_angle_error_t *error, double angle_deg, double resolution_deg)
{
    const double off = angle_deg - error->schedule->positions[error->position].angle.deg;
    const double off_turn = off - 360.0 * floor(off / 360.0 + 0.5);
    const bool arrived = fabs(off_turn) <= resolution_deg;
    return sim_law_draw(error->law, error->limit_rad, arrived ? &error->at_position[error->position] : &error->between);
}
