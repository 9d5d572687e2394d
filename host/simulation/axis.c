#include "simulation/axis.h"

#include "simulation/maths.h"

#include <math.h> /* ceil, fmin, fmax: exact */

#define ENVELOPE_PER_SETTLING 6.907755278982137 /* ln 1000 */
#define SETTLINGS_UNTIL_STILL 4.0

static double seconds(uint64_t from_us, uint64_t to_us)
{
    return (double)(to_us - from_us) * 1e-6;
}

static uint64_t microseconds_up(double time_s)
{
    return (uint64_t)ceil(time_s * 1e6);
}

void sim_axis_init(sim_axis_t *axis, const sim_axis_config_t *config, sim_angle_error_t *error, double angle_deg)
{
    *axis = (sim_axis_t){
        .config = config, .error = error, .from_deg = angle_deg, .lowest_deg = angle_deg, .highest_deg = angle_deg};
    sim_motion_rest(&axis->motion, angle_deg);
}

double sim_axis_commanded_deg(const sim_axis_t *axis, uint64_t now_us, double *velocity_deg_s)
{
    double position;
    sim_motion_at(&axis->motion, seconds(axis->start_us, now_us), &position, velocity_deg_s);
    return position;
}

/* The angle error now: on the way between two stops it passes from the one's to the other's. A jam may hold the table off
 * that way, where it has the error of the nearer stop. */
static double error_deg(const sim_axis_t *axis, double commanded_deg)
{
    const double way = axis->motion.end_position - axis->from_deg;
    if (way == 0.0 || commanded_deg == axis->motion.end_position) {
        return axis->to_error_deg;
    }
    const double share = fmin(fmax((commanded_deg - axis->from_deg) / way, 0.0), 1.0);
    return axis->from_error_deg + share * (axis->to_error_deg - axis->from_error_deg);
}

/* The motor moves within the play, and beyond it takes the table along. */
static double play_after(double play_deg, double way_deg, double backlash_deg)
{
    const double left = play_deg - way_deg;
    const double least = (left > 0.0) ? left : 0.0;
    return (least < backlash_deg) ? least : backlash_deg;
}

/* Where the table is above the motor, which turns back only where a piece of its motion begins. */
static double play_deg(const sim_axis_t *axis, uint64_t now_us, double commanded_deg)
{
    const double elapsed_s = seconds(axis->start_us, now_us);
    const double backlash_deg = axis->config->backlash_deg;
    double play = axis->from_play_deg;
    double at_deg = axis->from_deg;
    for (uint32_t i = 0; i < axis->motion.count && axis->motion.pieces[i].start_s <= elapsed_s; i++) {
        play = play_after(play, axis->motion.pieces[i].position - at_deg, backlash_deg);
        at_deg = axis->motion.pieces[i].position;
    }
    return play_after(play, commanded_deg - at_deg, backlash_deg);
}

static void widen_extent(sim_axis_t *axis, double deg)
{
    axis->lowest_deg = (deg < axis->lowest_deg) ? deg : axis->lowest_deg;
    axis->highest_deg = (deg > axis->highest_deg) ? deg : axis->highest_deg;
}

/* A motion turns back only where one of its pieces begins. */
static void note_extent(sim_axis_t *axis, uint64_t now_us)
{
    if (axis->jammed) {
        return; /* noted when the jam began */
    }
    const double elapsed_s = seconds(axis->start_us, now_us);
    const double jammed_s = (axis->free_us > axis->start_us) ? seconds(axis->start_us, axis->free_us) : 0.0;
    for (uint32_t i = 0; i < axis->motion.count && axis->motion.pieces[i].start_s <= elapsed_s; i++) {
        if (axis->motion.pieces[i].start_s >= jammed_s) {
            widen_extent(axis, axis->motion.pieces[i].position);
        }
    }
    double velocity;
    widen_extent(axis, sim_axis_commanded_deg(axis, now_us, &velocity));
}

void sim_axis_extent(const sim_axis_t *axis, uint64_t now_us, double *lowest_deg, double *highest_deg)
{
    sim_axis_t until_now = *axis;
    note_extent(&until_now, now_us);
    *lowest_deg = until_now.lowest_deg;
    *highest_deg = until_now.highest_deg;
}

/* A new motion begins where the axis is now, with the error it has now. */
static double begin_motion(sim_axis_t *axis, uint64_t now_us, double *velocity_deg_s)
{
    const double position = sim_axis_commanded_deg(axis, now_us, velocity_deg_s);
    note_extent(axis, now_us);
    axis->from_error_deg = error_deg(axis, position);
    axis->from_play_deg = play_deg(axis, now_us, position);
    axis->from_deg = position;
    axis->start_us = now_us;
    return position;
}

static void swing_at_end(sim_axis_t *axis)
{
    axis->swings = true;
    axis->swing_us = sim_axis_end_us(axis);
}

void sim_axis_move(sim_axis_t *axis, uint64_t now_us, double target_deg, const sim_axis_dynamics_t *dynamics)
{
    double velocity;
    const double position = begin_motion(axis, now_us, &velocity);
    sim_motion_move(&axis->motion, position, velocity, target_deg, dynamics->speed_deg_s, dynamics->acceleration_deg_s2,
                    dynamics->deceleration_deg_s2);
    if (axis->motion.count == 0U) {
        axis->to_error_deg = axis->from_error_deg; /* it stands there already */
        return;
    }
    axis->error_rad = sim_angle_error_draw(axis->error, target_deg, 0.5 * axis->config->resolution_deg);
    axis->to_error_deg = axis->error_rad * SIM_DEG_PER_RAD;
    swing_at_end(axis);
}

void sim_axis_stop(sim_axis_t *axis, uint64_t now_us, double deceleration_deg_s2)
{
    double velocity;
    const double position = begin_motion(axis, now_us, &velocity);
    sim_motion_stop(&axis->motion, position, velocity, deceleration_deg_s2);
    axis->to_error_deg = axis->from_error_deg;
    axis->error_rad = axis->to_error_deg / SIM_DEG_PER_RAD;
    if (axis->motion.count > 0U) {
        swing_at_end(axis);
    }
}

double sim_axis_error_rad(const sim_axis_t *axis)
{
    return axis->error_rad;
}

uint64_t sim_axis_end_us(const sim_axis_t *axis)
{
    return axis->start_us + microseconds_up(axis->motion.end_s);
}

static double time_constant_s(const sim_axis_t *axis)
{
    return axis->config->settling_s / ENVELOPE_PER_SETTLING;
}

uint64_t sim_axis_quiet_us(const sim_axis_t *axis, double window_deg)
{
    const sim_axis_config_t *const config = axis->config;
    const uint64_t end_us = sim_axis_end_us(axis);
    if (!axis->swings || axis->swing_us != end_us || config->swing_deg <= window_deg || config->settling_s <= 0.0) {
        return end_us;
    }
    const double least = config->swing_deg * 1e-12; /* it counts as still by then */
    const double ratio = config->swing_deg / ((window_deg > least) ? window_deg : least);
    return end_us + microseconds_up(time_constant_s(axis) * sim_log(ratio));
}

bool sim_axis_is_still(const sim_axis_t *axis, uint64_t now_us)
{
    if (now_us < axis->start_us || (double)(now_us - axis->start_us) < axis->motion.end_s * 1e6) {
        return false; /* as now_us < sim_axis_end_us(axis), without its rounding up: asked for every sample */
    }
    return !axis->swings || seconds(axis->swing_us, now_us) >= SETTLINGS_UNTIL_STILL * axis->config->settling_s;
}

static double swing_deg(const sim_axis_t *axis, uint64_t now_us)
{
    const sim_axis_config_t *const config = axis->config;
    if (!axis->swings || now_us <= axis->swing_us) {
        return 0.0;
    }
    const double t = seconds(axis->swing_us, now_us);
    if (t >= SETTLINGS_UNTIL_STILL * config->settling_s) {
        return 0.0;
    }
    double sine;
    double cosine;
    const double turns = t * config->swing_hz;
    sim_sincos_deg(360.0 * (turns - (double)(int64_t)turns), &sine, &cosine);
    return config->swing_deg * sim_exp(-t / time_constant_s(axis)) * sine;
}

double sim_axis_encoder_deg(const sim_axis_t *axis, uint64_t now_us)
{
    double velocity;
    if (axis->jammed) {
        return axis->jammed_deg;
    }
    return sim_axis_commanded_deg(axis, now_us, &velocity) + swing_deg(axis, now_us) + axis->encoder_slip_deg;
}

double sim_axis_actual_deg(const sim_axis_t *axis, uint64_t now_us)
{
    double velocity;
    const double commanded = axis->jammed ? axis->jammed_deg : sim_axis_commanded_deg(axis, now_us, &velocity);
    const double swing = axis->jammed ? 0.0 : swing_deg(axis, now_us);
    return commanded + swing + error_deg(axis, commanded) + axis->slip_deg + play_deg(axis, now_us, commanded);
}

void sim_axis_jam(sim_axis_t *axis, uint64_t now_us, bool jammed)
{
    if (jammed && !axis->jammed) {
        double velocity;
        note_extent(axis, now_us);
        axis->jammed_deg = sim_axis_commanded_deg(axis, now_us, &velocity);
    }
    axis->free_us = (axis->jammed && !jammed) ? now_us : axis->free_us;
    axis->jammed = jammed;
}

void sim_axis_slip(sim_axis_t *axis, double by_deg, bool seen_by_encoder)
{
    axis->slip_deg += by_deg;
    if (seen_by_encoder) {
        axis->encoder_slip_deg += by_deg;
    }
}
