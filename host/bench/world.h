/* world.h - one run: firmware, drive, block, bus and operator in one virtual time.
 *
 * Everything of a run is in one struct without heap; a seed and a configuration determine its course to the last bit.
 *
 *     bench_world_init(&world, &config, seed, &watcher);
 *     bench_world_run(&world);   or, to do something in between,   while (bench_world_advance(&world)) { }
 */
#ifndef TUMBLE_BENCH_WORLD_H
#define TUMBLE_BENCH_WORLD_H

#include "bench/config.h"
#include "bench/fault_script.h"
#include "bench/person.h"
#include "tumble/navcomp.h"
#include "simulation/angle_error.h"
#include "simulation/block.h"
#include "simulation/bus.h"
#include "simulation/clock.h"
#include "simulation/drive.h"
#include "simulation/truth.h"

#include <stdbool.h>
#include <stdint.h>

/* Numbers of the nodes on the simulated bus (not of CANopen). */
enum { BENCH_BUS_NAVCOMP = 0, BENCH_BUS_DRIVE, BENCH_BUS_BLOCK, BENCH_BUS_GUEST };

#define BENCH_MAX_GUESTS (SIM_BUS_NODES - BENCH_BUS_GUEST)

/* A mark that no procedure has. */
#define BENCH_LOOK_AGAIN UINT32_MAX

/* How a run ended. */
typedef enum {
    BENCH_RUNNING = 0,
    BENCH_DONE,        /* the procedure is DONE */
    BENCH_FAULT,       /* FAULT or ABORT, and nobody mends it */
    BENCH_INTERRUPTED, /* told to stop from outside */
    BENCH_TOO_LONG,    /* limit of virtual time */
    BENCH_LEFT         /* the last guest has left */
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

/* How the firmware is told what `config` says; all that is pointed at must outlive what it is told. */
tumble_navcomp_config_t bench_navcomp_config(const bench_config_t *config, const tumble_port_t *port,
                                             const tumble_navcomp_hooks_t *hooks, bench_stand_memory_t *memory);

/* Power everything on and command the start. Returns TUMBLE_OK or what tumble_navcomp_init says. All that is handed in
 * must outlive the world, which must not be moved. */
tumble_status_t bench_world_init(bench_world_t *world, const bench_config_t *config, uint64_t seed,
                                 const bench_watcher_t *watcher);

/* Go on to the next event. False: the run has ended (world->end), with the table at rest. */
bool bench_world_advance(bench_world_t *world);

/* Go on to the end. */
void bench_world_run(bench_world_t *world);

/* When the next event is. */
uint64_t bench_world_next_us(const bench_world_t *world);

/* Stop the table and give up, as the firmware's command. */
void bench_world_abort(bench_world_t *world);

/* The same, and end the run as soon as the table rests, whatever becomes of the command. */
void bench_world_end(bench_world_t *world, bench_end_t end);

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
