/* scene.h - all that a run consists of, in one struct without heap: firmware, drive, block, bus, operator and faults, in
 * one virtual time; and what anybody may do to it.
 */
#ifndef TUMBLE_WORLD_SCENE_H
#define TUMBLE_WORLD_SCENE_H

#include "simulation/angle_error.h"
#include "simulation/block.h"
#include "simulation/bus.h"
#include "simulation/clock.h"
#include "simulation/drive.h"
#include "simulation/truth.h"
#include "tumble/navcomp.h"
#include "world/config.h"

#include <stdbool.h>
#include <stdint.h>

/* Numbers of the nodes on the simulated bus (not of CANopen). */
enum { BENCH_BUS_NAVCOMP = 0, BENCH_BUS_DRIVE, BENCH_BUS_BLOCK, BENCH_BUS_GUEST };

/* A mark that no procedure has. */
#define BENCH_LOOK_AGAIN UINT32_MAX

/* The operator (person.h). */

typedef enum {
    BENCH_QUESTION_NONE = 0,
    BENCH_QUESTION_MOUNTING, /* put the block on the table as `mounting` says */
    BENCH_QUESTION_ANGLE,    /* turn the dividing head to `angle_deg` */
    BENCH_QUESTION_FAULT     /* mend it and go on, or give up */
} bench_question_kind_t;

typedef struct {
    bench_question_kind_t kind;
    uint8_t mounting;
    double angle_deg;
    tumble_reason_t reason;
} bench_question_t;

typedef enum {
    BENCH_ANSWER_DONE = 0, /* mounted, turned, or mended: go on */
    BENCH_ANSWER_ABORT,
    BENCH_ANSWER_REPEAT_POSITION, /* argument: index in the schedule */
    BENCH_ANSWER_REPEAT_MOUNTING, /* argument: number of the mounting */
    BENCH_ANSWER_LEAVE            /* do nothing: the run ends where it is */
} bench_answer_t;

typedef struct {
    bench_question_t question;              /* open at the moment */
    uint64_t act_us;                        /* when the simulated operator answers; SIM_NEVER: never */
    bool outside;                           /* somebody outside has been asked, and has not answered */
    uint32_t mended;                        /* faults mended so far */
    bool erred;                             /* the wrong mounting has been made */
    uint32_t mounted[TUMBLE_MAX_MOUNTINGS]; /* how often each was put on the table */
} bench_person_t;

/* The faults of the scenario (fault_script.h). */

typedef struct {
    uint64_t begin_us; /* SIM_NEVER: not due */
    uint64_t end_us;
    uint32_t times; /* how often it has begun */
    bool in_force;
} bench_fault_state_t;

typedef struct {
    bench_fault_state_t states[SIM_MAX_FAULTS];
} bench_fault_script_t;

/* How a run ended. */
typedef enum {
    BENCH_RUNNING = 0,
    BENCH_DONE,        /* the procedure is DONE */
    BENCH_FAULT,       /* FAULT or ABORT, and nobody mends it */
    BENCH_INTERRUPTED, /* told to stop from outside */
    BENCH_TOO_LONG,    /* limit of virtual time */
    BENCH_LEFT         /* whoever held it has left */
} bench_end_t;

/* Who looks on. Each may be null. */
typedef struct {
    void *context;
    /* The procedure has moved on: another state, position or attempt. */
    void (*on_change)(void *context, const tumble_progress_t *progress);
    /* A sample went into a mean (as the firmware's hook). */
    void (*on_sample)(void *context, tumble_taken_t taken, const tumble_block_sample_t *sample);
    /* A frame went over the bus. */
    sim_bus_tap_t on_frame;
    /* A person is needed; true: answered by way of person.h; false: the simulated one acts. */
    bool (*on_question)(void *context, const bench_question_t *question);
    /* There is still something to do before the run may end. */
    bool (*is_busy)(void *context);
} bench_watcher_t;

/* The firmware's memory of its stand, whichever it is. */
typedef union {
    tumble_drive402_t drive;
    tumble_operator_t person;
} bench_stand_memory_t;

typedef struct bench_world {
    const bench_config_t *config;
    const bench_watcher_t *watcher;
    uint64_t seed;
    sim_clock_t clock;
    sim_bus_t bus;
    sim_truth_t truth;
    sim_sensor_config_t sensor; /* with the true K and U0 */
    sim_angle_error_t angle_error;
    sim_drive_t drive;
    sim_axis_t *axis; /* the table's: of the drive, or turned by hand */
    sim_axis_t hand;
    sim_block_t block;
    bench_fault_script_t script;
    bench_person_t person;
    sim_bus_end_t firmware; /* its end of the bus */
    tumble_port_t port;
    tumble_navcomp_hooks_t hooks;
    tumble_navcomp_config_t navcomp_config;
    tumble_navcomp_t navcomp;
    bench_stand_memory_t stand;
    tumble_second_client_t second_client;
    tumble_progress_t progress; /* as last seen */
    uint32_t mark;              /* of the procedure at that time */
    bool started;               /* the procedure has left IDLE */
    bool off;                   /* the navigation computer has no power: hostile_life.h */
    uint64_t steps;             /* of the firmware */
    uint64_t limit_us;
    uint64_t ending_us; /* since when it waits for the table to rest; SIM_NEVER: not yet */
    bench_end_t end;
    bench_end_t wanted_end;
} bench_world_t;

/* Stop the table and give up, as the firmware's command. */
void bench_world_abort(bench_world_t *world);

/* Let time pass without an event, up to the next one at most. */
void bench_world_pass(bench_world_t *world, uint64_t now_us);

/* Turn the table, which no drive of this process turns. */
void bench_world_turn(bench_world_t *world, double angle_deg, double speed_deg_s);

/* Is the table at rest? */
bool bench_world_is_at_rest(const bench_world_t *world);

/* The block is put on the table in mounting `index` of the schedule: a new yaw, unless it is there for the first time.
 */
void bench_world_mount(bench_world_t *world, uint8_t index);

#endif
