/* hostile.h - hostile lives (lives.h): what may happen in one, how it is drawn, what is watched, and the life itself.
 *
 * A plan is drawn from a seed: every part has a stream of random numbers of its own (SIM_CAUSE_LIFE), so that one draw
 * more in one shifts nothing in the others. The navigation computer with its memory lives through it on the simulated
 * bus, and may lose its power: then its memory alone outlives, what was being erased or programmed is left with any
 * bytes, bits elsewhere may flip, and the firmware begins anew on what is there, while the rest of the world goes on.
 * What must hold is judged by the simulation's truth and not by what the firmware says; docs/campaign.md says of each
 * word what must hold, and of each excuse what it excuses and for how long.
 */
#ifndef TUMBLE_WORLD_HOSTILE_H
#define TUMBLE_WORLD_HOSTILE_H

#include "navcomp/commands.h"
#include "navcomp/keeper.h"
#include "procedure/states.h"
#include "simulation/drive.h"
#include "simulation/nv.h"
#include "simulation/random.h"
#include "simulation/scenario.h"
#include "tumble/core.h"
#include "tumble/port.h"
#include "world/config.h"
#include "world/world.h"

#include <stdbool.h>
#include <stdint.h>

/* What may happen: faults, commands, frames of a stranger, power cuts. */

/* The word is the name in the summary. */
#define BENCH_HOSTILE_LIST(X)                                                                                          \
    X(BENCH_HOSTILE_FAULT, "fault")                                                                                    \
    X(BENCH_HOSTILE_COMMAND, "command")                                                                                \
    X(BENCH_HOSTILE_CUT, "power_cut")                                                                                  \
    X(BENCH_HOSTILE_SDO_NAVCOMP, "sdo_navcomp")                                                                        \
    X(BENCH_HOSTILE_SDO_DRIVE, "sdo_drive")                                                                            \
    X(BENCH_HOSTILE_SDO_ANSWER, "sdo_answer")                                                                          \
    X(BENCH_HOSTILE_SET_POINT, "set_point")                                                                            \
    X(BENCH_HOSTILE_SDO_SET_POINT, "sdo_set_point")                                                                    \
    X(BENCH_HOSTILE_POSITION, "position")                                                                              \
    X(BENCH_HOSTILE_NEAR_POSITION, "near_position")                                                                    \
    X(BENCH_HOSTILE_SAMPLE, "sample")                                                                                  \
    X(BENCH_HOSTILE_SPOILT_SAMPLE, "spoilt_sample")                                                                    \
    X(BENCH_HOSTILE_NMT, "nmt")                                                                                        \
    X(BENCH_HOSTILE_HEARTBEAT, "heartbeat")                                                                            \
    X(BENCH_HOSTILE_EMERGENCY, "emergency")                                                                            \
    X(BENCH_HOSTILE_SYNC, "sync")                                                                                      \
    X(BENCH_HOSTILE_LSS, "lss")                                                                                        \
    X(BENCH_HOSTILE_ANY_FRAME, "any_frame")

typedef enum {
#define BENCH_HOSTILE_ENUM(name, word) name,
    BENCH_HOSTILE_LIST(BENCH_HOSTILE_ENUM)
#undef BENCH_HOSTILE_ENUM
        BENCH_HOSTILE_KINDS
} bench_hostile_t;

/* A moment: a time, or the first one from that time on at which the firmware is in one of these states or the memory
 * is at work, and then some more. */
typedef struct {
    uint64_t at_us;
    uint32_t states; /* bit per tumble_state_t; 0: any */
    bool writing;    /* the memory is erasing or programming */
    uint32_t delay_us;
} bench_moment_t;

typedef struct {
    bench_hostile_t kind;
    uint32_t number; /* in the list as drawn: names its stream of random numbers */
    bench_moment_t moment;
    sim_fault_t fault; /* of BENCH_HOSTILE_FAULT, which has its moment in here */
    tumble_command_t command;
    uint8_t argument;
    double angle_deg; /* of a turn; of a set-point: where to; of positions: how far each is off the one before */
    bool relative;    /* of a set-point: so far off the drive's present target */
    bool by_host;     /* the command comes from the board itself, not over CAN */
    tumble_can_frame_t frame; /* as it is sent, where neither position, set-point nor sample is forged */
    uint32_t count;           /* forged positions; flipped bits */
    int32_t counts;           /* added to a forged sample */
    uint32_t off_us;          /* without power */
} bench_event_t;

/* The plan of a life (hostile_plan.c). */

#define BENCH_PLAN_EVENTS 300U

/* Who mounts the block, mends faults and switches the power on again. */
typedef struct {
    double mount_s;
    double mend_s;
    uint32_t mends; /* faults that he mends; then the run stays where it is */
    bool resumes;   /* after a loss of power, else he starts anew */
    bool errs;      /* mounts the block wrongly, once */
} bench_attendant_t;

typedef struct {
    uint64_t seed;
    bench_config_t config; /* complete; its faults are those of `events` */
    bench_attendant_t attendant;
    uint64_t lasts_us;
    uint32_t erase_us;
    uint32_t program_us;
    uint64_t utc_s; /* told at power-on; 0: not */
    bool has_set;   /* the memory holds an active set from the beginning */
    uint32_t count;
    bench_event_t events[BENCH_PLAN_EVENTS]; /* in the order of their times */
} bench_plan_t;

#define BENCH_STREAM_EVENT 1000U /* and its number: the stream of an event, an index of SIM_CAUSE_LIFE */

/* A whole number from 0 to count - 1; true with this probability. */
uint32_t bench_pick(sim_random_t *stream, uint32_t count);
bool bench_chance(sim_random_t *stream, double probability);

/* An SDO write of up to four bytes to the server of `node`. */
void bench_frame_write(tumble_can_frame_t *frame, uint8_t node, uint16_t index, uint8_t subindex, uint8_t size,
                       uint32_t value);

/* Draw the whole of it. What the configuration does not allow is a mistake of the drawing: null, or the sentence. The
 * plan must not be moved. */
const char *bench_plan_draw(bench_plan_t *plan, uint64_t seed);

/* What must hold, and what excuses it. */

/* Word, and what a person reads. */
#define BENCH_VIOLATION_LIST(X)                                                                                        \
    X(BENCH_HOLDS, "none", "nothing is violated")                                                                      \
    X(BENCH_BROKEN_REST, "rest", "the table still turns 6 s after the end")                                            \
    X(BENCH_BROKEN_STAYS, "stays", "the table at rest moves without a command")                                        \
    X(BENCH_BROKEN_CABLE, "cable", "the table goes beyond the cable's limits")                                         \
    X(BENCH_BROKEN_HOMING, "homing", "homing goes farther than the cable's span and a turn")                           \
    X(BENCH_BROKEN_SPEED, "speed", "the table turns for 1 s faster than it was told to")                               \
    X(BENCH_BROKEN_FOREIGN, "foreign", "a stranger's motion is not stopped within 1 s")                                \
    X(BENCH_BROKEN_REASON, "reason", "FAULT or ABORT without a reason")                                                \
    X(BENCH_BROKEN_FINITE, "finite", "a readable object is not a finite number")                                       \
    X(BENCH_BROKEN_TRUTH, "truth", "a set that became active by itself is off by more than 6 u")                       \
    X(BENCH_BROKEN_LOST, "lost", "the active set is lost")                                                             \
    X(BENCH_BROKEN_COUNTER, "counter", "the calibration counter went back, and nothing was told")                      \
    X(BENCH_BROKEN_PROPOSAL, "proposal", "a proposal is lost that nobody has decided about")                           \
    X(BENCH_BROKEN_DECAYED, "decayed", "a record or mark with a flipped bit counts as valid")                          \
    X(BENCH_BROKEN_MEAN, "mean", "a mean is not of its own samples, as many as are configured")                        \
    X(BENCH_BROKEN_LEVEL, "level", "the service level is open, or was not asked for, without its key")                 \
    X(BENCH_BROKEN_RUN, "run", "the run number does not count the runs")                                               \
    X(BENCH_BROKEN_BENCH, "bench", "the bench cannot go on")

typedef enum {
#define BENCH_VIOLATION_ENUM(name, word, sentence) name,
    BENCH_VIOLATION_LIST(BENCH_VIOLATION_ENUM)
#undef BENCH_VIOLATION_ENUM
        BENCH_VIOLATION_KINDS
} bench_broken_t;

#define BENCH_EXCUSE_LIST(X)                                                                                           \
    X(BENCH_EXCUSE_COMMANDED, "commanded")                                                                             \
    X(BENCH_EXCUSE_REWRITTEN, "rewritten")                                                                             \
    X(BENCH_EXCUSE_STEP, "step")   /* fault `step`: a bias changes within a run */                                     \
    X(BENCH_EXCUSE_SLIP, "slip")   /* fault `slip`, below what closure and position tolerance see */                   \
    X(BENCH_EXCUSE_SHORT, "short") /* fault `never_reached`, by less than the position tolerance */                    \
    X(BENCH_EXCUSE_CHANNEL,                                                                                            \
      "channel")                     /* faults `swapped`, `inverted`: for a while, where outputs are alike or small */ \
    X(BENCH_EXCUSE_SAMPLE, "sample") /* a forged sample with a good checksum */                                        \
    X(BENCH_EXCUSE_RULES, "rules")   /* an accepted write to 2050h or 2122h to 2126h */                                \
    X(BENCH_EXCUSE_FLIPPED, "flipped")

typedef enum {
#define BENCH_EXCUSE_ENUM(name, word) name,
    BENCH_EXCUSE_LIST(BENCH_EXCUSE_ENUM)
#undef BENCH_EXCUSE_ENUM
        BENCH_EXCUSES
} bench_excuse_t;

typedef struct {
    bench_broken_t kind;
    uint64_t at_us;
    double value;  /* degrees, uncertainties, or a number of that kind */
    uint32_t what; /* object, coefficient, state: by kind */
} bench_violation_t;

/* The samples of the position that is being averaged, as they came; the frames of the block that came last. */
#define BENCH_RECENT 32U
#define BENCH_COUNTERS 64U

typedef struct {
    tumble_can_frame_t frames[BENCH_RECENT];
    uint32_t next;
    uint8_t index;
    uint32_t count;
    uint16_t counters[BENCH_COUNTERS];
    int64_t sum[TUMBLE_CHANNELS];
} bench_collected_t;

/* Means of a position that were found to be right. */
#define BENCH_KNOWN 4U

typedef struct {
    tumble_average_t means[BENCH_KNOWN];
    uint32_t next;
} bench_known_t;

typedef struct {
    bench_violation_t violation;
    uint32_t excuses;      /* bit per bench_excuse_t */
    uint64_t rest_us;      /* the table must rest by then; SIM_NEVER: no end is pending */
    bool peace;            /* it rests, and nobody has commanded anything */
    uint64_t still_us;     /* since when it stands; SIM_NEVER: it moves */
    uint64_t commanded_us; /* when a stranger commanded the drive last */
    uint64_t fast_us;      /* since when the table turns too fast; SIM_NEVER: it does not */
    double last_deg;
    sim_homing_t homing; /* as last seen */
    bool searches;       /* from the start of a homing until the table rests */
    double from_deg;     /* where that began */
    bool has_set;
    uint32_t counter;
    uint64_t told_by_us; /* a decay must be told by then; SIM_NEVER: none */
    bool told;
    uint32_t proposal;       /* its name; 0: there is none */
    uint64_t decided_us;     /* until then a command about it, or another result, may take it away; SIM_NEVER: power was
                          * lost before that */
    uint64_t level_until_us; /* the service level may be open; */
    uint64_t open_us;        /* since when it is although it may not; SIM_NEVER: it is not */
    bool locked;             /* when the last write was asked for it could not be open */
    uint32_t runs;           /* the run number, when the state changed last */
    bench_collected_t collected;
    bench_known_t known[TUMBLE_MAX_POSITIONS];
    tumble_state_t state;
} bench_watch_t;

/* The life. */

#define BENCH_LIFE_QUEUE 64U

/* A frame that follows another one, a little later. */
typedef struct {
    uint64_t due_us;
    tumble_can_frame_t frame;
} bench_follower_t;

/* A record in the memory, with its mark, in which bits have flipped: what it looks like since. */
#define BENCH_FLIPPED 32U

typedef struct {
    uint32_t offset;
    uint32_t size;
    uint64_t hash;
    uint64_t sound; /* before the first flip */
} bench_flipped_t;

/* Counted for the summary. */
typedef struct {
    uint32_t faults[SIM_FAULT_KINDS];
    uint32_t events[BENCH_HOSTILE_KINDS];
    uint32_t ends[TUMBLE_STATE_COUNT][TUMBLE_REASON_COUNT]; /* DONE, FAULT and ABORT, by reason */
    uint32_t flips;
    uint32_t committed; /* sets that became active by themselves */
    uint32_t judged;    /* of those, without a cause that excuses them */
    uint32_t held;      /* results that became the proposal */
    uint32_t homings;
} bench_life_counts_t;

typedef struct bench_life {
    const bench_plan_t *plan;
    bench_world_t world;
    bench_watcher_t watcher;
    sim_nv_t nv;
    tumble_keeper_t keeper;
    tumble_keeper_config_t keeper_config;
    tumble_stand_memory_t stand_memory;
    tumble_inclinations_memory_t inclinations_memory;
    uint64_t due_us[BENCH_PLAN_EVENTS]; /* SIM_NEVER: over, or waits for its state */
    bool waits[BENCH_PLAN_EVENTS];
    bool waited[BENCH_PLAN_EVENTS];
    uint64_t next_us; /* the earliest of them */
    uint32_t waiting_for_writing;
    bench_follower_t queue[BENCH_LIFE_QUEUE];
    uint32_t queued;
    uint64_t attend_us; /* when the attendant acts */
    uint64_t power_us;  /* when power comes back */
    uint8_t lies;       /* number of the mounting in which the block is on the table */
    uint32_t mended;
    bool erred;
    bool run_was_on; /* when power was cut */
    bool abort_asked;
    tumble_command_t command_asked; /* the last one over CAN */
    bench_flipped_t flipped[BENCH_FLIPPED];
    uint32_t flipped_count;
    bench_watch_t watch;
    bench_life_counts_t counts;
} bench_life_t;

/* Is this record still as the flips have left it? False: it has been written anew. */
bool bench_life_is_flipped(const bench_life_t *life, const bench_flipped_t *flipped);

/* From power-on to the end of the plan, or to the first violation: life->watch.violation. */
void bench_life_run(bench_life_t *life, bench_plan_t *plan);

/* The watch at work (hostile_watch.c): the life tells it what happens. */

void bench_watch_init(bench_life_t *life);

/* After every event of the world: the table, the computer's counts and the sets. */
void bench_watch_look(bench_life_t *life);

/* The procedure has moved on. */
void bench_watch_change(bench_life_t *life, const tumble_progress_t *progress);

/* A frame has gone over the bus; a sample went into a mean. */
void bench_watch_frame(bench_life_t *life, uint8_t sender, const tumble_can_frame_t *frame);
void bench_watch_sample(bench_life_t *life, tumble_taken_t taken, const tumble_block_sample_t *sample);

/* Something that may move the table has been commanded; a run has ended or ABORT was taken. */
void bench_watch_commanded(bench_life_t *life);
void bench_watch_ended(bench_life_t *life);

/* Somebody has given a command about the proposal, or it was refused. For some seconds the proposal may go, or not. */
void bench_watch_decide(bench_life_t *life, tumble_command_t command, bool refused);

/* Power is back. */
void bench_watch_power_on(bench_life_t *life);

/* Every readable object of the computer must be finite. */
void bench_watch_read_all(bench_life_t *life);

void bench_watch_excuse(bench_life_t *life, bench_excuse_t excuse);
void bench_watch_break(bench_life_t *life, bench_broken_t kind, double value, uint32_t what);

#endif
