/* drive.h - the turntable's drive: a CANopen node of profile CiA 402 that turns the axis of axis.h.
 *
 * Profile position and homing modes, with the habits that users of real drives were hit by:
 *   - a set-point is taken at the rising edge of controlword bit 4 while statusword bit 12 is 0, and never otherwise;
 *   - what is taken is the target as it was before the frame with the edge came (if latches_stale_target);
 *   - the statusword follows a command only after a reaction time, so "target reached" may still be the last one's;
 *   - a change of mode is refused while Halt is set;
 *   - silence of the master (1016h), or leaving the NMT state Operational, stops the axis and is a fault;
 *   - when it is told to switch its voltage off while the axis moves, the axis coasts;
 *   - units, sign and counts per turn are its own; positions may wrap;
 *   - it keeps to software position limits (607Dh) once it is homed, if it has them.
 *
 * drive.c is the node, drive_motion.c the two modes, drive_power.c the states, drive_axis.c the axis and its units.
 * Object values live in drive_objects.h, which is generated from the same table as the EDS file.
 */
#ifndef TUMBLE_SIMULATION_DRIVE_H
#define TUMBLE_SIMULATION_DRIVE_H

#include "canopen/node.h"
#include "simulation/axis.h"
#include "simulation/bus.h"
#include "simulation/clock.h"
#include "simulation/drive_objects.h"
#include "simulation/power402.h"
#include "simulation/scenario.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum {
    SIM_HOMING_NONE = 0, /* not homed, not homing */
    SIM_HOMING_SEARCH,   /* on the way past the mark */
    SIM_HOMING_APPROACH, /* slowly upwards to the mark */
    SIM_HOMING_ATTAINED,
    SIM_HOMING_ERROR
} sim_homing_t;

typedef struct {
    const sim_drive_config_t *config;
    sim_clock_t *clock;
    sim_bus_end_t bus;
    tumble_port_t port;
    tumble_node_t node;
    tumble_drive_objects_t objects;
    sim_axis_t axis;

    sim_power_t power;
    uint16_t seen_controlword; /* as of the frame before */
    int32_t seen_target;
    int8_t mode;         /* in force */
    uint16_t status;     /* what the statusword will be once the reaction time is over */
    uint64_t publish_us; /* when that is; SIM_NEVER: it is */

    bool powered;
    bool acknowledged; /* bit 12: a set-point was taken, bit 4 has not fallen since, or the buffer is full */
    bool buffered;     /* one more set-point waits */
    bool halted;
    bool limited;        /* the target was beyond the software limits (607Dh) and has been cut to them */
    bool reached;        /* the last target, to the end of the window time */
    double target_deg;   /* of the motion under way, in degrees of the table */
    int32_t next_target; /* of the buffered set-point */
    bool next_relative;
    int32_t last_target; /* counts; what relative set-points start from */
    sim_homing_t homing;
    double zero_deg;            /* table angle at position 0 */
    uint64_t settled_us;        /* when the motion under way will have been within its window for the window time */
    uint64_t quiet_us;          /* and when nothing is left to be seen of it */
    uint64_t follow_us;         /* since when the following error is too large; SIM_NEVER: it is not */
    uint64_t cycle_us;          /* next look at the axis while it moves; SIM_NEVER: it rests */
    bool looked;                /* it has been looked at, and what is there is to be shown */
    bool broken;                /* with an error that a reset cannot clear yet */
    sim_fault_effects_t faults; /* in force */
} sim_drive_t;

/* Power on, at `angle_deg` of the table. Everything handed in must outlive the drive. */
void sim_drive_init(sim_drive_t *drive, const sim_drive_config_t *config, sim_clock_t *clock, sim_bus_t *bus,
                    uint8_t bus_node, sim_angle_error_t *error, double angle_deg);

/* Frames have come, or the drive's own time. */
void sim_drive_on_alarm(sim_drive_t *drive);

/* Lose power (the axis brakes, the position is forgotten) or get it back. */
void sim_drive_set_power(sim_drive_t *drive, bool on);

/* Report an error: stop, Fault, EMCY. `lasting`: a fault reset does nothing until sim_drive_mend. */
void sim_drive_fail(sim_drive_t *drive, uint16_t code, bool lasting);
void sim_drive_mend(sim_drive_t *drive);

/* SIM_FAULT_RUNAWAY has begun or ended: a motion under way takes another end. */
void sim_drive_run_away(sim_drive_t *drive);

/* The axis has moved in a way that was not commanded (slip, jam): the control cycle looks at it. */
void sim_drive_disturb(sim_drive_t *drive);

#endif
