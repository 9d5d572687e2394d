/* config.h - everything that one run of the bench is made of, but for the seed: the simulated world and the firmware's
 * configuration.
 *
 * A configuration begins with its defaults, is changed by the lines of a scenario file (config_file.h), and is then
 * completed: what was left open follows from the rest. After that it is constant.
 */
#ifndef TUMBLE_WORLD_CONFIG_H
#define TUMBLE_WORLD_CONFIG_H

#include "navcomp/keeper.h"
#include "navcomp/uncertainty.h"
#include "simulation/frame_bits.h"
#include "simulation/scenario.h"
#include "stand/drive402/drive402.h"
#include "stand/operator/operator.h"
#include "tumble/core.h"
#include "tumble/navcomp.h"

#include <stdbool.h>
#include <stdint.h>

#define BENCH_MAX_WRITES 16

/* What a scenario says of the keeper, for a firmware that has non-volatile memory. */

/* A configuration to be read from lines; `flags` within the settings are made of the three switches. */
typedef struct {
    char serial[TUMBLE_SET_SERIAL_BYTES + 1U]; /* of the block; empty: not told */
    bool commits;                              /* good sets by themselves */
    bool first;                                /* the first one, too */
    bool starts;                               /* runs that are due */
    tumble_sets_settings_t settings;
} bench_keeping_t;

/* Who takes part from inside the process; others may be outside. */
typedef struct {
    bool navcomp;
    bool drive;
    bool block;
} bench_present_t;

/* What turns the table: a drive, or a person at a dividing head. Of each its word in scenarios, its kind in the firmware
 * and the type of its object there, the member of bench_config_t that is its profile, its node on the bus (0: none). */
#define BENCH_STAND_LIST(X)                                                                                            \
    X(DRIVE, "drive", tumble_drive402_kind, tumble_drive402_t, profile, 2)                                             \
    X(OPERATOR, "operator", tumble_operator_kind, tumble_operator_t, operator, 0)

typedef enum {
#define BENCH_STAND_ENUM(name, word, kind, type, profile, node) BENCH_STAND_##name,
    BENCH_STAND_LIST(BENCH_STAND_ENUM)
#undef BENCH_STAND_ENUM
} bench_stand_t;

/* What the drive profile points to. */
typedef struct {
    tumble_drive_pdo_t receive[TUMBLE_MAX_RECEIVE_PDOS];
    tumble_drive_pdo_t transmit[TUMBLE_MAX_TRANSMIT_PDOS];
    tumble_object_write_t writes[BENCH_MAX_WRITES];
} bench_profile_lists_t;

typedef struct {
    sim_scenario_t scenario;
    bench_present_t present;
    bench_stand_t stand;

    tumble_averaging_config_t averaging;
    tumble_procedure_config_t procedure;
    tumble_optimal_source_t gains;     /* of the estimator `optimal`; record null: none */
    tumble_optimal_t optimal;          /* its working memory */
    tumble_inclined_source_t inclined; /* of the estimator `inclined`, */
    double weights[TUMBLE_CHANNELS];   /* what it weighs channels by that differ, */
    tumble_inclinations_t seen;        /* and its memory */
    tumble_lent_t lent[2];             /* both of them, as the firmware has them */
    tumble_stand_record_t record;      /* what the firmware is told of the stand */
    tumble_declared_t declared;
    tumble_run_noise_t noise; /* working memory of what it is told */
    tumble_drive_profile_t profile;
    bench_profile_lists_t lists;
    tumble_operator_config_t operator;
    bench_keeping_t keeping; /* of a firmware that has non-volatile memory */
    uint16_t heartbeat_ms;
    uint16_t heartbeat_timeout_ms;
    bool starts;      /* begins a calibration at power-on, or waits for commands of guests */
    uint32_t loop_us; /* the firmware's main loop looks for frames at multiples of this; 0: at once */

    sim_wire_t wire;
    double virtual_limit_s; /* a run that lasts longer is a fault of the bench */
} bench_config_t;

/* The paper's stand and schedule, the `refined` estimator on 50 samples a position. */
void bench_config_defaults(bench_config_t *config);

/* Fill in what follows from the rest (0 where a default says so), and set all pointers within `config`, which must not
 * be moved afterwards. Null, or a sentence that tells what does not fit together. */
const char *bench_config_complete(bench_config_t *config);

/* What the firmware, if it takes part, would refuse of a complete configuration as soon as it starts; null: nothing. */
const char *bench_config_refused(const bench_config_t *config);

#endif
