/* memory.h - non-volatile memory for the firmware of a run with guests, and the keeper of coefficients on it, as
 * tumble-node has them. It is empty at first and gone in the end; no calendar time is told.
 */
#ifndef TUMBLE_WORLD_MEMORY_H
#define TUMBLE_WORLD_MEMORY_H

#include "navcomp/keeper.h"
#include "navcomp/stand_view.h"
#include "simulation/nv.h"
#include "world/world.h"

typedef struct {
    sim_nv_t nv;
    tumble_keeper_t keeper;
    tumble_keeper_config_t keeper_config;
    tumble_stand_memory_t stand_memory;
    tumble_whole_work_t whole_work;
} bench_memory_t;

/* Give it to the firmware of a world that has just been powered on, which begins anew. Returns as tumble_navcomp_init. */
tumble_status_t bench_memory_add(bench_memory_t *memory, bench_world_t *world);

#endif
