/* axis.h - the mechanics of the table: it follows its motor, swings when it stops, and stops a little off.
 *
 * Three angles, all in degrees of the table, 0 at the home mark:
 *   commanded  where the motor is told to be: the closed form of motion.h
 *   encoder    where the encoder sees the table: commanded, plus the decaying oscillation, less what a jam holds back
 *   actual     where the table is: encoder plus the angle error alpha4 (which turns from one stop's draw to the next's
 *              over the way between them) plus slip plus play
 *
 * The play of the gear is behind the encoder, which sits on the motor: the table stops at the commanded angle when it
 * came from below, and by the play above it when it came from above.
 *
 * The oscillation after a stop is A exp(-t/tau) sin(2 pi f t), its envelope a thousandth of A after the settling time
 * and nothing at all after four of them. The next motion ends it.
 */
#ifndef TUMBLE_SIMULATION_AXIS_H
#define TUMBLE_SIMULATION_AXIS_H

#include "simulation/angle_error.h"
#include "simulation/motion.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    double swing_deg;      /* amplitude of the oscillation after a stop */
    double swing_hz;       /* its frequency */
    double settling_s;     /* until it has fallen to a thousandth */
    double resolution_deg; /* of the encoder: one count */
    double backlash_deg;   /* play between motor and table */
} sim_axis_config_t;

typedef struct {
    const sim_axis_config_t *config;
    sim_angle_error_t *error;
    sim_motion_t motion;
    uint64_t start_us; /* of the motion */
    uint64_t swing_us; /* when the table last came to a stop: start of the oscillation */
    double from_deg;   /* where the motion started ... */
    double from_error_deg;
    double from_play_deg;    /* how far the table was above the motor then, 0 to the backlash */
    double to_error_deg;     /* angle error at its end */
    double error_rad;        /* the same, as drawn */
    double slip_deg;         /* table against encoder, so far */
    double encoder_slip_deg; /* of slip that the encoder sees */
    double jammed_deg;       /* where a jam holds the table */
    bool jammed;
    uint64_t free_us; /* since when it is not jammed (any more) */
    bool swings;
    double lowest_deg; /* of the motions before the present one: see sim_axis_extent */
    double highest_deg;
} sim_axis_t;

/* At rest at `angle_deg`, nothing swinging. `config` and `error` must outlive the axis. */
void sim_axis_init(sim_axis_t *axis, const sim_axis_config_t *config, sim_angle_error_t *error, double angle_deg);

typedef struct {
    double speed_deg_s;
    double acceleration_deg_s2;
    double deceleration_deg_s2;
} sim_axis_dynamics_t;

/* Turn to `target_deg` from wherever the axis is now; the angle error of the target is drawn here. */
void sim_axis_move(sim_axis_t *axis, uint64_t now_us, double target_deg, const sim_axis_dynamics_t *dynamics);

/* Come to rest as soon as `deceleration_deg_s2` allows. */
void sim_axis_stop(sim_axis_t *axis, uint64_t now_us, double deceleration_deg_s2);

/* When the present motion ends (which may be in the past). */
uint64_t sim_axis_end_us(const sim_axis_t *axis);

/* When the encoder stays within `window_deg` of the end of the motion for good, jams apart. */
uint64_t sim_axis_quiet_us(const sim_axis_t *axis, double window_deg);

double sim_axis_commanded_deg(const sim_axis_t *axis, uint64_t now_us, double *velocity_deg_s);
double sim_axis_encoder_deg(const sim_axis_t *axis, uint64_t now_us);
double sim_axis_actual_deg(const sim_axis_t *axis, uint64_t now_us);

/* The lowest and the highest commanded angle that the table has passed or stood at so far: not where a motion would
 * have led that was stopped or replaced on its way, nor what the motor did alone while the table was jammed. */
void sim_axis_extent(const sim_axis_t *axis, uint64_t now_us, double *lowest_deg, double *highest_deg);

/* The angle error (alpha4, rad) with which the axis stands, or will stand at the end of its motion. */
double sim_axis_error_rad(const sim_axis_t *axis);

/* True when the actual angle will not change any more by itself: no motion, no oscillation. */
bool sim_axis_is_still(const sim_axis_t *axis, uint64_t now_us);

/* The table jams where it is, or comes free (and is then where the motor is). */
void sim_axis_jam(sim_axis_t *axis, uint64_t now_us, bool jammed);

/* The table slips on its shaft; the encoder sees it or not. */
void sim_axis_slip(sim_axis_t *axis, double by_deg, bool seen_by_encoder);

#endif
