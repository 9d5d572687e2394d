/* hostile_state.h - the state of a hostile life, and what its files do with it. */
#ifndef TUMBLE_WORLD_HOSTILE_STATE_H
#define TUMBLE_WORLD_HOSTILE_STATE_H

#include "navcomp/keeper.h"
#include "navcomp/stand_view.h"
#include "simulation/nv.h"
#include "world/hostile_draw.h"
#include "world/hostile_watch.h"
#include "world/world.h"

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

/* The attendant (hostile_attendant.c): he sees that the procedure has moved on; his time has come. */
void bench_life_attend_to(bench_life_t *life, const tumble_progress_t *progress);
void bench_life_attend(bench_life_t *life);

/* Carry out an event (hostile_act.c). */
void bench_life_act(bench_life_t *life, const bench_event_t *event);

/* A fault is in force: note what it excuses. */
void bench_life_excuse_fault(bench_life_t *life, const sim_fault_t *fault);

/* A frame of the stranger, now or later. */
void bench_life_send(bench_life_t *life, const tumble_can_frame_t *frame, uint32_t after_us);

/* The memory (hostile_memory.c): with an active set or without, at the beginning; torn and flipped, without power. */
void bench_life_prepare_memory(bench_life_t *life);
void bench_life_tear_memory(bench_life_t *life, sim_random_t *stream);
void bench_life_flip_bits(bench_life_t *life, sim_random_t *stream, uint32_t count);

/* Is this record still as the flips have left it? False: it has been written anew. */
bool bench_life_is_flipped(const bench_life_t *life, const bench_flipped_t *flipped);

/* Power of the computer (hostile_power.c): what is in its memory is there; it is lost; it comes back. */
void bench_life_boot(bench_life_t *life);
void bench_life_cut(bench_life_t *life, const bench_event_t *event);
void bench_life_power_on(bench_life_t *life);

/* The computer of the board itself is told; SIM_ACTOR_NAVCOMP is woken. */
tumble_status_t bench_life_command(bench_life_t *life, tumble_command_t command, uint8_t argument);

#endif
