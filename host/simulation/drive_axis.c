/* The axis as the drive sees it: its own units, and what sets it in motion or stops it. */
#include "simulation/drive_internal.h"

#include <math.h> /* floor, fabs: exact */

double sim_drive_counts_per_deg(const sim_drive_t *drive)
{
    return (double)drive->config->sign * (double)drive->config->counts_per_turn / 360.0;
}

/* Positions count modulo this: as the drive is set, or as 32-bit numbers overflow. */
static double wrap(const sim_drive_t *drive)
{
    return (drive->config->wrap_counts != 0U) ? (double)drive->config->wrap_counts : 4294967296.0;
}

static double modulo(double x, double period)
{
    return x - period * floor(x / period);
}

static int32_t wrapped(const sim_drive_t *drive, double counts)
{
    const double within = modulo(counts, wrap(drive));
    return (int32_t)((within >= 2147483648.0) ? within - 4294967296.0 : within);
}

static double whole_counts(const sim_drive_t *drive, double angle_deg)
{
    return floor((angle_deg - drive->zero_deg) * sim_drive_counts_per_deg(drive) + 0.5);
}

int32_t sim_drive_counts(const sim_drive_t *drive, double angle_deg)
{
    return wrapped(drive, whole_counts(drive, angle_deg));
}

int32_t sim_drive_reported_counts(const sim_drive_t *drive, double angle_deg)
{
    const sim_fault_effect_t *const scale = &drive->faults[SIM_FAULT_POSITION_SCALE];
    if (drive->faults[SIM_FAULT_FROZEN_POSITION].on) {
        return drive->objects.position_actual_value;
    }
    const double counts = whole_counts(drive, angle_deg);
    return wrapped(drive, scale->on ? floor(counts * scale->value + 0.5) : counts);
}

/* Table angle of a target. Where positions wrap, it is reached by the shorter way. */
double sim_drive_target_deg(const sim_drive_t *drive, int32_t target)
{
    double counts = (double)target;
    if (drive->config->wrap_counts != 0U) {
        const double here = whole_counts(drive, drive->axis.motion.end_position);
        const double way = modulo(counts - here, wrap(drive));
        counts = here + ((way > 0.5 * wrap(drive)) ? way - wrap(drive) : way);
    }
    return drive->zero_deg + counts / sim_drive_counts_per_deg(drive);
}

static double limited(double units, double per_unit, double most)
{
    const double wanted = units / per_unit;
    return (wanted > 0.0 && wanted < most) ? wanted : most;
}

double sim_drive_acceleration(const sim_drive_t *drive, uint32_t units)
{
    return limited((double)units, drive->config->acceleration_per_deg_s2, drive->config->acceleration_deg_s2);
}

static double speed(const sim_drive_t *drive, uint32_t units)
{
    return limited((double)units, drive->config->velocity_per_deg_s, drive->config->speed_deg_s);
}

sim_axis_dynamics_t sim_drive_dynamics(const sim_drive_t *drive)
{
    return (sim_axis_dynamics_t){speed(drive, drive->objects.profile_velocity),
                                 sim_drive_acceleration(drive, drive->objects.profile_acceleration),
                                 sim_drive_acceleration(drive, drive->objects.profile_deceleration)};
}

sim_axis_dynamics_t sim_drive_homing_dynamics(const sim_drive_t *drive, uint32_t speed_units)
{
    const double acceleration = sim_drive_acceleration(drive, drive->objects.homing_acceleration);
    return (sim_axis_dynamics_t){speed(drive, speed_units), acceleration, acceleration};
}

double sim_drive_position_window_deg(const sim_drive_t *drive)
{
    return fabs((double)drive->objects.position_window / sim_drive_counts_per_deg(drive));
}

/* Look at the axis from now on, until there is nothing more to be seen. */
static void follow_motion(sim_drive_t *drive)
{
    const double half_count = 0.5 * drive->config->axis.resolution_deg;
    drive->settled_us = sim_axis_end_us(&drive->axis);
    if (drive->objects.position_window != NOT_WATCHED) {
        drive->settled_us = sim_axis_quiet_us(&drive->axis, sim_drive_position_window_deg(drive)) +
                            (uint64_t)drive->objects.position_window_time * 1000U;
    }
    drive->quiet_us = sim_axis_quiet_us(&drive->axis, half_count);
    drive->cycle_us = drive->clock->now_us + drive->config->report_us;
}

/* The axis sets out. */
void sim_drive_set_out(sim_drive_t *drive, double target_deg, const sim_axis_dynamics_t *dynamics)
{
    sim_axis_move(&drive->axis, drive->clock->now_us, target_deg, dynamics);
    drive->reached = false;
    follow_motion(drive);
}

void sim_drive_stop_axis(sim_drive_t *drive, double deceleration_deg_s2)
{
    drive->buffered = false;
    if (drive->homing == SIM_HOMING_SEARCH || drive->homing == SIM_HOMING_APPROACH) {
        drive->homing = SIM_HOMING_NONE;
    }
    sim_axis_stop(&drive->axis, drive->clock->now_us, deceleration_deg_s2);
    drive->target_deg = drive->axis.motion.end_position;
    follow_motion(drive);
}
