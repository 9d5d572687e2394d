/* drive_internal.h - what the files of the drive share. */
#ifndef TUMBLE_SIMULATION_DRIVE_INTERNAL_H
#define TUMBLE_SIMULATION_DRIVE_INTERNAL_H

#include "canopen/cia402.h"
#include "simulation/drive.h"

/* The drive's own position at this table angle. */
int32_t sim_drive_counts(const sim_drive_t *drive, double angle_deg);

/* What it reports there: the same, unless a fault has spoilt its reports. */
int32_t sim_drive_reported_counts(const sim_drive_t *drive, double angle_deg);

double sim_drive_counts_per_deg(const sim_drive_t *drive);

/* Table angle of a target. Where positions wrap, it is reached by the shorter way. */
double sim_drive_target_deg(const sim_drive_t *drive, int32_t target);

/* 6067h, in degrees; NOT_WATCHED there, and in 6065h, means that nobody looks. */
#define NOT_WATCHED UINT32_MAX
double sim_drive_position_window_deg(const sim_drive_t *drive);

/* The axis sets out. */
void sim_drive_set_out(sim_drive_t *drive, double target_deg, const sim_axis_dynamics_t *dynamics);

/* Speed and accelerations from the drive's units, within what it can do; 0 means as much as it can do. */
double sim_drive_acceleration(const sim_drive_t *drive, uint32_t units);
sim_axis_dynamics_t sim_drive_dynamics(const sim_drive_t *drive);
sim_axis_dynamics_t sim_drive_homing_dynamics(const sim_drive_t *drive, uint32_t speed_units);

/* Act on the controlword and target that a frame left behind. */
void sim_drive_obey(sim_drive_t *drive);

/* Enter a power state, with what that means for the axis. */
void sim_drive_enter(sim_drive_t *drive, sim_power_t power);

/* Leave Quick stop active and Fault reaction once the axis rests. */
void sim_drive_finish_stop(sim_drive_t *drive);

/* Look at axis and modes: motions that have ended, following error. */
void sim_drive_advance(sim_drive_t *drive);

/* When `advance` next has something to see; SIM_NEVER at rest. */
uint64_t sim_drive_next_motion_us(const sim_drive_t *drive);

/* Forget set-points and homing under way; the axis brakes. */
void sim_drive_stop_axis(sim_drive_t *drive, double deceleration_deg_s2);

/* The statusword as it should be now. */
uint16_t sim_drive_status(const sim_drive_t *drive);

#endif
