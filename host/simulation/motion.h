/* motion.h - trapezoidal motion in closed form: where an axis is at any moment of a move.
 *
 * A plan is a handful of pieces of constant acceleration, so that position and velocity at a time are one short formula
 * and nothing is integrated step by step. Unit of length: any (degrees here); time in seconds from the start of the
 * plan. Pure functions; the caller owns the plan.
 */
#ifndef TUMBLE_SIMULATION_MOTION_H
#define TUMBLE_SIMULATION_MOTION_H

#include <stdint.h>

#define SIM_MOTION_PIECES 4 /* brake, speed up, cruise, slow down */

typedef struct {
    double start_s;
    double position;
    double velocity;
    double acceleration;
} sim_motion_piece_t;

typedef struct {
    sim_motion_piece_t pieces[SIM_MOTION_PIECES];
    uint32_t count;
    double end_s;        /* at rest from here on ... */
    double end_position; /* ... at this position, exactly */
} sim_motion_t;

/* At rest at `position`. */
void sim_motion_rest(sim_motion_t *motion, double position);

/* From `position` with `velocity` to rest at `target`: never faster than `speed` (unless it already is), speeding up
 * and slowing down by `acceleration` and `deceleration`, all three above 0. An axis too fast to stop before the target,
 * or moving away from it, brakes to rest first and comes back. */
void sim_motion_move(sim_motion_t *motion, double position, double velocity, double target, double speed,
                     double acceleration, double deceleration);

/* From `position` with `velocity` to rest as soon as `deceleration` allows. */
void sim_motion_stop(sim_motion_t *motion, double position, double velocity, double deceleration);

/* Where the axis is `time_s` after the start, and how fast. */
void sim_motion_at(const sim_motion_t *motion, double time_s, double *position, double *velocity);

#endif
