/* world.h - all that a run consists of, in one struct without heap: firmware, drive, block, bus, operator and faults, in
 * one virtual time; what anybody may do to it; and its course, from power-on to the table at rest. A seed and a
 * configuration determine it to the last bit.
 *
 *     bench_world_init(&world, &config, seed, &watcher);
 *     bench_world_run(&world);   or, to do something in between,   while (bench_world_advance(&world)) { }
 */
#ifndef TUMBLE_WORLD_WORLD_H
#define TUMBLE_WORLD_WORLD_H

#include "simulation/angle_error.h"
#include "simulation/block.h"
#include "simulation/bus.h"
#include "simulation/clock.h"
#include "simulation/drive.h"
#include "simulation/truth.h"
#include "tumble/navcomp.h"
#include "world/border.h"
#include "world/config.h"

#include <stdbool.h>
#include <stdint.h>

/* Numbers of the nodes on the simulated bus (not of CANopen). */
enum { BENCH_BUS_NAVCOMP = 0, BENCH_BUS_DRIVE, BENCH_BUS_BLOCK, BENCH_BUS_GUEST };

/* A mark that no procedure has. */
#define BENCH_LOOK_AGAIN UINT32_MAX

/* The operator (simulated_operator.c). */

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

typedef struct {
    bench_question_t question;              /* open at the moment */
    uint64_t act_us;                        /* when the simulated operator answers; SIM_NEVER: never */
    bool outside;                           /* somebody outside has been asked, and has not answered */
    uint32_t mended;                        /* faults mended so far */
    bool erred;                             /* the wrong mounting has been made */
    uint32_t mounted[TUMBLE_MAX_MOUNTINGS]; /* how often each was put on the table */
    uint8_t on_table;                       /* the last of these, by its index */
    bool inclined;                          /* the block was bolted on before, and only the stand inclined */
} bench_operator_t;

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

/* Who looks on. Each may be null. */
typedef struct {
    void *context;
    /* The procedure has moved on: another state, position or attempt. */
    void (*on_change)(void *context, const tumble_progress_t *progress);
    /* A sample went into a mean (as the firmware's hook). */
    void (*on_sample)(void *context, tumble_taken_t taken, const tumble_block_sample_t *sample);
    /* A frame went over the bus. */
    sim_bus_tap_t on_frame;
    /* A person is needed; true: answered by way of simulated_operator.c; false: the simulated one acts. */
    bool (*on_question)(void *context, const bench_question_t *question);
    /* There is still something to do before the run may end. */
    bool (*is_busy)(void *context);
} bench_watcher_t;

/* The firmware's memory of its stand, whichever it is. */
typedef union {
#define BENCH_STAND_OBJECT(name, word, kind, type, profile, node) type profile;
    BENCH_STAND_LIST(BENCH_STAND_OBJECT)
#undef BENCH_STAND_OBJECT
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
    bench_operator_t operator;
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
    bool off;                   /* the navigation computer has no power: seeded_run.h */
    uint64_t steps;             /* of the firmware */
    uint64_t limit_us;
    uint64_t ending_us; /* since when it waits for the table to rest; SIM_NEVER: not yet */
    world_end_t end;
    world_end_t wanted_end;
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
 * Where it stays bolted on, the stand is inclined: with new errors, unless it is there for the first time. */
void bench_world_mount(bench_world_t *world, uint8_t index);

/* Is the block bolted on for mounting `index` already, so that only the stand is inclined? */
bool bench_world_inclines(const bench_world_t *world, uint8_t index);

/* Its course. */

/* How the firmware is told what `config` says; all that is pointed at must outlive what it is told. */
tumble_navcomp_config_t bench_navcomp_config(const bench_config_t *config, const tumble_port_t *port,
                                             const tumble_navcomp_hooks_t *hooks, bench_stand_memory_t *memory);

/* Power everything on and command the start. Returns TUMBLE_OK or what tumble_navcomp_init says. All that is handed in
 * must outlive the world, which must not be moved. */
tumble_status_t bench_world_init(bench_world_t *world, const bench_config_t *config, uint64_t seed,
                                 const bench_watcher_t *watcher);

/* Go on to the next event. False: the run has ended (world->end), with the table at rest. */
bool bench_world_advance(bench_world_t *world);

/* Has the table come to rest since the end was decided? */
bool bench_world_has_ended(bench_world_t *world);

/* Go on to the end. */
void bench_world_run(bench_world_t *world);

/* When the next event is. */
uint64_t bench_world_next_us(const bench_world_t *world);

/* Stop the table and give up, and end the run as soon as the table rests, whatever becomes of the command. */
void bench_world_end(bench_world_t *world, world_end_t end);

/* The operator (simulated_operator.c): mounts the block, turns a dividing head, mends faults, and tells the firmware. A question is
 * put when the firmware begins to wait for a person. Either somebody outside answers it, or the simulated operator does,
 * after the time that the scenario gives him. */

void bench_operator_init(bench_world_t *world);

/* What the state of a run asks of a person: to mount the block, to mend a fault, or nothing. */
bench_question_t bench_operator_question(const tumble_progress_t *progress);

/* Is this fault mended by mounting the block anew? */
bool bench_operator_must_mount(tumble_reason_t reason);

/* Do what was asked, once the firmware goes on and somebody else has told it to: mount the block, mend the fault, while
 * the scenario lets him. `asked`: the question before; world->progress: what has become of it. */
void bench_operator_follow(bench_world_t *world, const bench_question_t *asked);

/* Mount the block as asked, or, the first time, as the scenario has the operator err. */
void bench_operator_mount(bench_world_t *world, uint8_t asked);

/* The firmware may have begun to wait, or ended it: after every step. */
void bench_operator_update(bench_world_t *world);

/* The simulated operator's time has come. */
void bench_operator_on_alarm(bench_world_t *world);

/* Answer the open question: do it, and tell the firmware. */
tumble_status_t bench_operator_answer(bench_world_t *world, world_answer_t answer, uint8_t argument);

/* Will anybody act on the open question? */
bool bench_operator_is_awaited(const bench_world_t *world);

/* The faults of a scenario (fault_script.c) begin and end at their moments. */

/* Faults that begin at a time are set; the others wait for their position. */
void bench_fault_script_init(bench_world_t *world);

/* The procedure has come to another state, position or attempt. */
void bench_fault_script_update(bench_world_t *world, const tumble_progress_t *progress);

/* Somebody mends what is broken: all faults in force that would last for good are over. */
void bench_fault_script_mend(bench_world_t *world);

/* A fault begins or ends. */
void bench_fault_script_on_alarm(bench_world_t *world);

#endif
