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

/* Read these lines; the keeper as it usually is. */
static inline void kept_world_prepare(const char *lines)
{
    const char *const wrong = read_lines(lines);
    TEST_ASSERT_NULL_MESSAGE(wrong, wrong);
    settings = usual_settings();
    keeper_config = (tumble_keeper_config_t){.sets = {.serial = "TB-0001", .settings = &settings},
                                             .uncertainty = tumble_navcomp_uncertainty};
}

static inline void world_settle(void)
{
    for (int i = 0; (i < 500) || ((i < 5000) && tumble_keeper_has_work(&keeper)); i++) {
        world.clock.now_us += 1000U;
        tumble_navcomp_step(&world.navcomp);
    }
}

static inline void kept_world_start(uint64_t seed, uint64_t utc_s)
{
    kept_world_power_on(seed, utc_s);
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_command(&world.navcomp, TUMBLE_COMMAND_START, 0));
}

/* A whole run, and what the memory does after it. */
static inline tumble_sets_state_t kept_world_run(uint64_t seed, uint64_t utc_s)
{
    tumble_sets_state_t state;
    kept_world_start(seed, utc_s);
    bench_world_run(&world);
    world_settle();
    tumble_keeper_state(&keeper, &state);
    return state;
}

#endif
