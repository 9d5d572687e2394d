/* seeded_run.h - a run of the fault campaign (fault_campaign.h): the run itself (seeded_run.c), and its watch (seeded_run_watch.c). */
#ifndef TUMBLE_WORLD_SEEDED_RUN_H
#define TUMBLE_WORLD_SEEDED_RUN_H

#include "navcomp/commands.h"
#include "procedure/states.h"
#include "world/fault_campaign.h"
#include "world/world_parts.h"

#include <stdbool.h>
#include <stdint.h>

/* What is watched. */

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

/* The run. */

#define SEEDED_RUN_QUEUE 64U

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

typedef struct bench_life {
    const campaign_plan_t *plan;
    const campaign_event_t *events;
    size_t event_count;
    campaign_found_t *found;
    world_t *own;
    const bench_config_t *config; /* these three are its own */
    bench_world_t *world;
    memory_t *memory;
    bench_watcher_t watcher;
    uint64_t due_us[CAMPAIGN_MOST_EVENTS]; /* SIM_NEVER: over, or waits for its state */
    bool waits[CAMPAIGN_MOST_EVENTS];
    bool waited[CAMPAIGN_MOST_EVENTS];
    uint64_t next_us; /* the earliest of them */
    uint32_t waiting_for_writing;
    bench_follower_t queue[SEEDED_RUN_QUEUE];
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
} seeded_run_t;

/* Is this record still as the flips have left it? False: it has been written anew. */
bool seeded_run_is_flipped(const seeded_run_t *run, const bench_flipped_t *flipped);

/* The watch at work (seeded_run_watch.c): the run tells it what happens. */

void bench_watch_init(seeded_run_t *run);

/* After every event of the world: the table, the computer's counts and the sets. */
void bench_watch_check(seeded_run_t *run);

/* The procedure has moved on. */
void bench_watch_change(seeded_run_t *run, const tumble_progress_t *progress);

/* A frame has gone over the bus; a sample went into a mean. */
void bench_watch_frame(seeded_run_t *run, uint8_t sender, const tumble_can_frame_t *frame);
void bench_watch_sample(seeded_run_t *run, tumble_taken_t taken, const tumble_block_sample_t *sample);

/* Something that may move the table has been commanded; a run has ended or ABORT was taken. */
void bench_watch_commanded(seeded_run_t *run);
void bench_watch_ended(seeded_run_t *run);

/* Somebody has given a command about the proposal, or it was refused. For some seconds the proposal may go, or not. */
void bench_watch_decide(seeded_run_t *run, tumble_command_t command, bool refused);

/* Power is back. */
void bench_watch_power_on(seeded_run_t *run);

/* Every readable object of the computer must be finite. */
void bench_watch_read_all(seeded_run_t *run);

void bench_watch_excuse(seeded_run_t *run, campaign_excuse_t excuse);
void bench_watch_break(seeded_run_t *run, campaign_violation_t kind, double value, uint32_t what);

#endif
