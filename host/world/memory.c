#include "world/memory.h"

#include "navcomp/uncertainty.h"

tumble_status_t bench_memory_add(bench_memory_t *memory, bench_world_t *world)
{
    const bench_keeping_t *const keeping = &world->config->keeping;
    sim_nv_init(&memory->nv, &world->clock);
    memory->keeper_config = (tumble_keeper_config_t){
        .sets = {.serial = keeping->serial,
                 .settings = &keeping->settings,
                 .whole_step = tumble_whole_step,
                 .whole_work = &memory->whole_work},
        .uncertainty = tumble_navcomp_uncertainty,
        .norm = tumble_navcomp_norm,
        .stand_view = tumble_stand_view,
        .stand_memory = &memory->stand_memory,
    };
    memory->keeper.config = &memory->keeper_config;
    world->port.nv = &memory->nv.nv;
    world->navcomp_config.keeping = &tumble_keeper_calls;
    world->navcomp_config.keeper = &memory->keeper;
    return tumble_navcomp_init(&world->navcomp, &world->navcomp_config);
}
