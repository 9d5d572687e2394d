/* world_parts.h - what a world consists of, for the files of this folder alone. */
#ifndef TUMBLE_WORLD_PARTS_H
#define TUMBLE_WORLD_PARTS_H

#include "navcomp/keeper.h"
#include "replay/replay.h"
#include "simulation/nv.h"
#include "world/border.h"
#include "world/config_file.h"
#include "world/world.h"

/* What grows: `count` elements of `size` bytes, in memory for `room`. */
typedef struct {
    void *memory;
    size_t count;
    size_t room;
} array_t;

/* Non-volatile memory for the firmware, and the keeper of coefficients on it. It is empty at first and gone in the end;
 * no calendar time is told. */
typedef struct {
    sim_nv_t nv;
    tumble_keeper_t keeper;
    tumble_keeper_config_t keeper_config;
    tumble_stand_memory_t stand_memory;
    tumble_inclinations_memory_t inclinations_memory;
    tumble_whole_work_t whole_work;
} memory_t;

struct world {
    bench_config_t config;
    bench_seen_t seen;
    bench_mistake_t mistake;
    void *gains;
    world_operator_t operator;
    bool has_memory;
    bool records_nothing;
    bool no_memory; /* something could not be recorded */
    unsigned happened;
    array_t frames;
    array_t taken[TUMBLE_MAX_POSITIONS]; /* samples of its mean, or of the one under way */
    array_t samples;                     /* what world_samples gave last */
    uint64_t block_ms;                   /* the block's clock, unwrapped, of its last sample, ... */
    uint64_t heard_us;                   /* ... and when that came; SIM_NEVER: none has */
    bench_watcher_t watcher;
    memory_t memory;
    bench_world_t world;
    replay_t replay; /* instead of the simulated bus; see replay.h */
    tumble_navcomp_hooks_t replay_hooks;
    uint8_t *recording;
    char text[65536]; /* what was told last: the largest document has half of it */
};

/* Give a world that has been powered on an empty memory, and a keeper of coefficients on it; then boot it. */
void world_add_memory(world_t *world);

/* Without power the navigation computer's memory alone lasts. */
void world_set_off(world_t *world, bool off);

/* The firmware begins anew. */
tumble_status_t world_boot(world_t *world);

#endif
