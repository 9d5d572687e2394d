/* keeper_world.h - a keeper on a memory of the test's own, in the simulated world of sim_bench.h. */
#ifndef TUMBLE_TESTS_KEEPER_WORLD_H
#define TUMBLE_TESTS_KEEPER_WORLD_H

#include "keeper_memory.h"
#include "navcomp/uncertainty.h"
#include "sim_bench.h"

/* The bench itself powers on without a keeper, and sends nothing before its first step: so it is powered on again. */
static inline void kept_world_power_on(uint64_t seed, uint64_t utc_s)
{
    static const bench_watcher_t NOBODY = {0};
    ASSERT_STATUS(TUMBLE_OK, bench_world_init(&world, &config, seed, &NOBODY));
    world.port.nv = &memory.nv;
    keeper.config = &keeper_config;
    world.navcomp_config.keeping = &tumble_keeper_calls;
    world.navcomp_config.keeper = &keeper;
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_init(&world.navcomp, &world.navcomp_config));
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, utc_s));
}

static inline void world_settle(void)
{
    for (int i = 0; (i < 500) || ((i < 5000) && tumble_keeper_has_work(&keeper)); i++) {
        world.clock.now_us += 1000U;
        tumble_navcomp_step(&world.navcomp);
    }
}

#endif
