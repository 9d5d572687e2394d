/* scenario.h - everything that a simulated run is made of, but for the seed: plain structs, no behaviour.
 *
 * The stand and the block are described by the limits of their errors, out of which a seed draws one real stand, one
 * real block and one course of events (truth.h).
 */
#ifndef TUMBLE_SIMULATION_SCENARIO_H
#define TUMBLE_SIMULATION_SCENARIO_H

#include "simulation/axis.h"
#include "simulation/fault.h"
#include "simulation/random.h"
#include "simulation/sensor.h"
#include "tumble/core.h"

#include <stdbool.h>
#include <stdint.h>

/* Does every mounting draw its own yaw, or is there one for all? */
typedef enum { SIM_REMOUNT_INDEPENDENT = 0, SIM_REMOUNT_COMMON } sim_remount_t;

/* Limits of the stand's errors, read by `law`. */
typedef struct {
    double axis_tilt_rad;            /* alpha1 */
    double level_rad;                /* alpha2 */
    double remount_rad;              /* alpha3 */
    double angle_rad;                /* alpha4 */
    double seat_rad;                 /* theta_h and theta_n of a mounting */
    double platform_rad;             /* theta_h of them all */
    double encoder_rad;              /* each number of the encoder's errors */
    double drift_v[TUMBLE_CHANNELS]; /* from the first fit position to the last */
    double inclination_rad;          /* beta and tau of setting an inclination */
    /* No errors of the stand that are drawn, but as they are: how far the block sags against the axis for each g ... */
    double sag_across_rad_per_g; /* ... across it: its near end droops, as the end of a beam does, ... */
    double sag_along_rad_per_g;  /* ... and along it: it leans about h, as theta_h does */
    sim_law_t law;
    sim_remount_t remount;
} sim_stand_t;

/* The block. Either its K and U0 are given (sensor.k_v_per_g, sensor.u0_v), or they are drawn: scale factors within
 * scale_spread of the nominal, cross terms within misalignment_rad of it, biases within bias_v, all uniform. */
typedef struct {
    sim_sensor_config_t sensor;
    bool given;
    double scale_v_per_g[TUMBLE_CHANNELS]; /* nominal, signed */
    double scale_spread;                   /* relative */
    double misalignment_rad;
    double bias_v[TUMBLE_CHANNELS];
    uint32_t sample_period_us;
    uint32_t first_sample_us; /* from the moment it becomes Operational */
    uint16_t first_counter;
    uint16_t first_timestamp_ms;
} sim_block_config_t;

#define SIM_MAX_LACKS 16

/* The drive's own habits, which its master must cope with. */
typedef struct {
    sim_axis_config_t axis;
    uint32_t counts_per_turn;
    int32_t sign;              /* 1, or -1: its counts fall when the table turns upwards */
    uint32_t wrap_counts;      /* positions count modulo this and moves take the shorter way; 0: they do not wrap */
    double velocity_per_deg_s; /* its unit of velocity, counted along the table's degrees */
    double acceleration_per_deg_s2;
    double speed_deg_s; /* the most it can do, whatever it is told */
    double acceleration_deg_s2;
    double power_on_deg;        /* it wakes up at most this far from the home mark, either way */
    uint32_t reaction_us;       /* from a command to the statusword that shows it */
    uint32_t report_us;         /* its control cycle while it moves */
    bool software_limits;       /* it has 607Dh */
    bool latches_stale_target;  /* at the rising edge of bit 4 it takes the target it had before that frame */
    bool instant_homing;        /* an axis at its mark is home at once */
    bool fixed_pdos;            /* its PDOs cannot be written; they are those of the standard profile */
    bool acknowledges_enabling; /* bit 12 is set from Operation enabled on, and its first set-point clears it */
    uint8_t lack_count;
    uint16_t lacks[SIM_MAX_LACKS]; /* objects that it does not have */
} sim_drive_config_t;

/* When a fault begins: at a time, or when a position gets to a phase, plus a delay. */
typedef enum { SIM_PHASE_MOUNT = 0, SIM_PHASE_HOME, SIM_PHASE_MOVE, SIM_PHASE_SETTLE, SIM_PHASE_AVERAGE } sim_phase_t;

typedef struct {
    sim_fault_kind_t kind;
    bool at_time;
    double time_s;    /* since power-on */
    uint8_t mounting; /* else: numbers of the position ... */
    uint8_t position;
    sim_phase_t phase; /* ... and what is being done there */
    double delay_s;
    double duration_s; /* 0: for good */
    uint32_t times;    /* how often: 1 the first time only, 2 again when the position is repeated, ... */
    uint8_t channels;  /* one bit per channel */
    double value;
    uint32_t count; /* UINT32_MAX: without end */
    double probability;
    uint16_t id;
    uint16_t mask;
} sim_fault_t;

#define SIM_MAX_FAULTS 16

/* The person at the stand. */
typedef struct {
    double mount_s;          /* needed to mount the block and confirm; below 0: never confirms */
    double incline_s;        /* needed to incline the stand, the block bolted on, and confirm; below 0: never */
    double turn_s;           /* needed to turn a dividing head and confirm */
    uint8_t wrong_mounting;  /* 0: none; else when this mounting is asked for, ... */
    uint8_t mounted_instead; /* ... this one is put on the table the first time */
    double mend_s;           /* needed to mend a fault and tell the firmware to go on; below 0: does not */
    uint32_t mends;          /* how many faults it will mend */
} sim_operator_config_t;

typedef struct {
    sim_stand_t stand;
    sim_block_config_t block;
    sim_drive_config_t drive;
    sim_operator_config_t operator;
    uint32_t bits_per_second;
    uint32_t of_seed; /* what stays from run to run (truth.h) is that of this seed; 0: of the run's own */
    sim_fault_t faults[SIM_MAX_FAULTS];
    uint32_t fault_count;
    tumble_schedule_t schedule; /* points to the two below, or to constant data */
    tumble_mounting_t mountings[TUMBLE_MAX_MOUNTINGS];
    tumble_position_t positions[TUMBLE_MAX_POSITIONS];
} sim_scenario_t;

/* The paper's stand and schedule, an unknown block of -2 V/g, the default motion, no faults, a quick operator. */
void sim_scenario_defaults(sim_scenario_t *scenario);

#endif
