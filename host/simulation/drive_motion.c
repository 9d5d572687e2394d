#include "simulation/drive_internal.h"

#include <math.h> /* floor, fabs: exact */

#define HOME_OVERSHOOT_DEG 2.0 /* the search passes the mark downwards by this much, then comes up to it */
#define LOST_SEARCH_DEG 400.0  /* without a mark the search ends after a turn and a bit */
#define ENDLESS_DEG 1e6
#define HOMING_ON_THE_SPOT_MAX 37 /* methods 35 and 37: where the axis stands is home */
#define HOMING_ON_THE_SPOT_MIN 35

/* How far a motion to `end_deg` runs on, in its own direction. */
static double beyond_deg(const sim_drive_t *drive, double end_deg)
{
    const sim_fault_effect_t *const fault = &drive->faults[SIM_FAULT_RUNAWAY];
    double velocity;
    const double here = sim_axis_commanded_deg(&drive->axis, drive->clock->now_us, &velocity);
    const double way_deg = fault->on ? ((fault->value > 0.0) ? fault->value : ENDLESS_DEG) : 0.0;
    return (end_deg < here) ? -way_deg : way_deg;
}

/* Profile position mode */

static void go_to_target(sim_drive_t *drive)
{
    const sim_axis_dynamics_t dynamics = sim_drive_dynamics(drive);
    double end_deg = drive->target_deg;
    const double short_by_deg = drive->faults[SIM_FAULT_NEVER_REACHED].value;
    if (short_by_deg != 0.0) {
        double velocity;
        const double here = sim_axis_commanded_deg(&drive->axis, drive->clock->now_us, &velocity);
        end_deg += (end_deg > here) ? -short_by_deg : short_by_deg;
    }
    end_deg += beyond_deg(drive, end_deg);
    sim_drive_set_out(drive, end_deg, &dynamics);
}

/* 607Dh: once it is homed, and where positions do not wrap. */
static int32_t within_limits(const sim_drive_t *drive, int32_t target)
{
    const int32_t low = drive->objects.software_position_limit_min_position_limit;
    const int32_t high = drive->objects.software_position_limit_max_position_limit;
    if (drive->homing != SIM_HOMING_ATTAINED || drive->config->wrap_counts != 0U || low >= high) {
        return target;
    }
    return (target < low) ? low : (target > high) ? high : target;
}

static void start_set_point(sim_drive_t *drive, int32_t target, bool relative)
{
    const int32_t wanted = relative ? (int32_t)((uint32_t)drive->last_target + (uint32_t)target) : target;
    drive->last_target = within_limits(drive, wanted);
    drive->limited = drive->last_target != wanted;
    drive->target_deg = sim_drive_target_deg(drive, drive->last_target);
    if (!drive->halted) {
        go_to_target(drive);
    }
}

static void take_set_point(sim_drive_t *drive, int32_t target)
{
    const uint16_t controlword = drive->objects.controlword;
    const bool relative = (controlword & TUMBLE_402_CONTROL_RELATIVE) != 0U;
    const bool at_once = (controlword & TUMBLE_402_CONTROL_CHANGE_AT_ONCE) != 0U;
    drive->acknowledged = true;
    if (drive->reached || at_once) {
        drive->buffered = false;
        start_set_point(drive, target, relative);
    } else {
        drive->buffered = true;
        drive->next_target = target;
        drive->next_relative = relative;
    }
}

static void obey_profile_position(sim_drive_t *drive, uint16_t risen, int32_t target_before)
{
    if ((risen & TUMBLE_402_CONTROL_NEW_SET_POINT) != 0U && !drive->acknowledged) {
        take_set_point(drive, drive->config->latches_stale_target ? target_before : drive->objects.target_position);
    }
    if ((drive->objects.controlword & TUMBLE_402_CONTROL_NEW_SET_POINT) == 0U && !drive->buffered) {
        drive->acknowledged = false;
    }
}

/* Homing mode */

static bool homes_on_the_spot(const sim_drive_t *drive)
{
    return drive->objects.homing_method >= HOMING_ON_THE_SPOT_MIN &&
           drive->objects.homing_method <= HOMING_ON_THE_SPOT_MAX;
}

/* The mark is at 0 degrees of the table. */
static void finish_homing(sim_drive_t *drive)
{
    const double here = drive->axis.motion.end_position;
    drive->zero_deg = here - (double)drive->objects.home_offset / sim_drive_counts_per_deg(drive);
    drive->last_target = drive->objects.home_offset;
    drive->target_deg = here;
    drive->homing = SIM_HOMING_ATTAINED;
    drive->looked = true; /* its position counts from another zero */
}

static void start_homing(sim_drive_t *drive)
{
    if (homes_on_the_spot(drive)) {
        sim_motion_rest(&drive->axis.motion, drive->axis.motion.end_position);
        finish_homing(drive);
        return;
    }
    const sim_axis_dynamics_t dynamics =
        sim_drive_homing_dynamics(drive, drive->objects.homing_speeds_speed_during_search_for_switch);
    double end_deg = -HOME_OVERSHOOT_DEG;
    if (drive->faults[SIM_FAULT_HOMING_ENDLESS].on) {
        end_deg = -ENDLESS_DEG;
    } else if (drive->faults[SIM_FAULT_HOMING_FAILS].on) {
        end_deg = drive->axis.motion.end_position - LOST_SEARCH_DEG;
    }
    end_deg += beyond_deg(drive, end_deg);
    drive->homing = SIM_HOMING_SEARCH;
    sim_drive_set_out(drive, end_deg, &dynamics);
}

static void go_on_homing(sim_drive_t *drive)
{
    if (drive->homing == SIM_HOMING_APPROACH) {
        finish_homing(drive);
    } else if (drive->homing == SIM_HOMING_SEARCH) {
        if (drive->faults[SIM_FAULT_HOMING_FAILS].on) {
            drive->homing = SIM_HOMING_ERROR;
            return;
        }
        const sim_axis_dynamics_t dynamics =
            sim_drive_homing_dynamics(drive, drive->objects.homing_speeds_speed_during_search_for_zero);
        drive->homing = SIM_HOMING_APPROACH;
        sim_drive_set_out(drive, 0.0, &dynamics);
    }
}

static void obey_homing(sim_drive_t *drive, uint16_t risen, uint16_t fallen)
{
    const bool under_way = drive->homing == SIM_HOMING_SEARCH || drive->homing == SIM_HOMING_APPROACH;
    if ((risen & TUMBLE_402_CONTROL_START_HOMING) != 0U && !under_way && !drive->halted) {
        start_homing(drive);
    } else if ((fallen & TUMBLE_402_CONTROL_START_HOMING) != 0U && under_way) {
        sim_drive_stop_axis(drive, sim_drive_homing_dynamics(drive, 0).deceleration_deg_s2);
    }
}

void sim_drive_run_away(sim_drive_t *drive)
{
    const bool turns =
        drive->power == SIM_POWER_OPERATION_ENABLED && drive->clock->now_us < sim_axis_end_us(&drive->axis);
    if (turns && drive->mode == TUMBLE_402_MODE_PROFILE_POSITION && !drive->halted) {
        go_to_target(drive);
    } else if (turns && drive->homing == SIM_HOMING_SEARCH) {
        start_homing(drive);
    }
}

/* Both */

static void obey_halt(sim_drive_t *drive)
{
    const bool halt = (drive->objects.controlword & TUMBLE_402_CONTROL_HALT) != 0U;
    if (halt == drive->halted) {
        return;
    }
    drive->halted = halt;
    if (halt) {
        const double target_deg = drive->target_deg;
        sim_drive_stop_axis(drive, sim_drive_dynamics(drive).deceleration_deg_s2);
        drive->target_deg = target_deg; /* released, the axis goes on to where it was going */
    } else if (drive->mode == TUMBLE_402_MODE_PROFILE_POSITION) {
        go_to_target(drive);
    }
}

/* Bits 4 and 8 of the controlword, in the mode in force. `risen` and `fallen` are bits against the frame before. */
static void obey_mode(sim_drive_t *drive, uint16_t risen, uint16_t fallen, int32_t target_before)
{
    if (drive->power != SIM_POWER_OPERATION_ENABLED) {
        return;
    }
    obey_halt(drive);
    if (drive->mode == TUMBLE_402_MODE_PROFILE_POSITION) {
        obey_profile_position(drive, risen, target_before);
    } else if (drive->mode == TUMBLE_402_MODE_HOMING) {
        obey_homing(drive, risen, fallen);
    }
}

static bool is_within_window(const sim_drive_t *drive)
{
    if (drive->objects.position_window == NOT_WATCHED) {
        return true;
    }
    const double off = sim_axis_encoder_deg(&drive->axis, drive->clock->now_us) - drive->target_deg;
    return fabs(off) <= sim_drive_position_window_deg(drive);
}

static void watch_following(sim_drive_t *drive)
{
    const uint64_t now_us = drive->clock->now_us;
    double velocity;
    const double commanded = sim_axis_commanded_deg(&drive->axis, now_us, &velocity);
    const double error = fabs(commanded - sim_axis_encoder_deg(&drive->axis, now_us));
    const double window = fabs((double)drive->objects.following_error_window / sim_drive_counts_per_deg(drive));
    if (drive->objects.following_error_window == NOT_WATCHED || error <= window) {
        drive->follow_us = SIM_NEVER;
    } else if (drive->follow_us == SIM_NEVER) {
        drive->follow_us = now_us;
    } else if (now_us - drive->follow_us >= (uint64_t)drive->objects.following_error_time_out * 1000U) {
        drive->follow_us = SIM_NEVER;
        sim_drive_fail(drive, TUMBLE_402_ERROR_FOLLOWING, false);
    }
}

static void end_motion(sim_drive_t *drive)
{
    if (drive->mode == TUMBLE_402_MODE_HOMING) {
        go_on_homing(drive);
        return;
    }
    if (!drive->reached && !drive->halted && is_within_window(drive)) {
        drive->reached = true;
        drive->looked = true; /* position and target reached are shown together */
    }
    if (drive->reached && drive->buffered) {
        drive->buffered = false;
        start_set_point(drive, drive->next_target, drive->next_relative);
    }
}

/* Nothing more to see: at rest to less than half a count, and where it should be. */
static bool is_quiet(const sim_drive_t *drive)
{
    return drive->clock->now_us >= drive->quiet_us && drive->follow_us == SIM_NEVER;
}

void sim_drive_advance(sim_drive_t *drive)
{
    const uint64_t now_us = drive->clock->now_us;
    const bool enabled = drive->power == SIM_POWER_OPERATION_ENABLED;
    if (enabled && now_us >= drive->settled_us) {
        end_motion(drive);
    }
    sim_drive_finish_stop(drive);
    if (now_us >= drive->cycle_us) {
        if (enabled) {
            watch_following(drive);
        }
        drive->cycle_us = is_quiet(drive) ? SIM_NEVER : now_us + drive->config->report_us;
        drive->looked = true;
    }
}

uint64_t sim_drive_next_motion_us(const sim_drive_t *drive)
{
    const bool waits = drive->power == SIM_POWER_OPERATION_ENABLED && drive->settled_us > drive->clock->now_us;
    return (waits && drive->settled_us < drive->cycle_us) ? drive->settled_us : drive->cycle_us;
}

static void obey_mode_selection(sim_drive_t *drive)
{
    if (drive->objects.modes_of_operation == drive->mode || drive->halted) {
        return;
    }
    drive->mode = drive->objects.modes_of_operation;
    drive->acknowledged = false;
    drive->buffered = false;
}

void sim_drive_obey(sim_drive_t *drive)
{
    const uint16_t controlword = drive->objects.controlword;
    const uint16_t before = drive->seen_controlword;
    const int32_t target_before = drive->seen_target;
    const bool cause_gone = !drive->broken && !tumble_nmt_any_lost(&drive->node.nmt);
    drive->seen_controlword = controlword;
    drive->seen_target = drive->objects.target_position;
    sim_drive_enter(drive, sim_power_next(drive->power, controlword, before, cause_gone));
    obey_mode_selection(drive);
    obey_mode(drive, (uint16_t)(controlword & ~before), (uint16_t)(before & ~controlword), target_before);
}
