/* Power of the computer, and commands to it. */
#include "world/hostile_invariants.h"

#include <string.h>

tumble_status_t bench_life_command(bench_life_t *life, tumble_command_t command, uint8_t argument)
{
    if (life->world.off) {
        return TUMBLE_E_STATE;
    }
    if (command != TUMBLE_COMMAND_ABORT) {
        bench_watch_commanded(life);
    }
    const tumble_status_t status = tumble_navcomp_command(&life->world.navcomp, command, argument);
    if (status == TUMBLE_OK) {
        bench_watch_decide(life, command, false);
    }
    if (command == TUMBLE_COMMAND_ABORT) {
        bench_watch_ended(life);
    }
    sim_clock_set(&life->world.clock, SIM_ACTOR_NAVCOMP, life->world.clock.now_us);
    return status;
}

void bench_life_boot(bench_life_t *life)
{
    bench_world_t *const world = &life->world;
    memset(&life->keeper, 0x5A, sizeof life->keeper);
    life->keeper.config = &life->keeper_config;
    if (tumble_navcomp_init(&world->navcomp, &world->navcomp_config) != TUMBLE_OK) {
        bench_watch_break(life, BENCH_BROKEN_BENCH, 0.0, 0);
        return;
    }
    if (life->plan->utc_s != 0U) {
        (void)tumble_sets_set_utc(&life->keeper.sets, life->plan->utc_s + world->clock.now_us / 1000000U);
    }
    world->mark = BENCH_LOOK_AGAIN;
    sim_clock_set(&world->clock, SIM_ACTOR_NAVCOMP, world->clock.now_us);
}

void bench_life_cut(bench_life_t *life, const bench_event_t *event)
{
    sim_random_t stream;
    bench_world_t *const world = &life->world;
    if (world->off) {
        return;
    }
    sim_random_open(&stream, life->plan->seed, SIM_CAUSE_LIFE, BENCH_STREAM_EVENT + event->number);
    const tumble_state_t state = world->progress.state;
    life->run_was_on = state != TUMBLE_STATE_IDLE && state != TUMBLE_STATE_DONE && state != TUMBLE_STATE_ABORT;
    life->counts.held += tumble_sets_counters(&life->keeper.sets)->held;
    world->off = true;
    sim_bus_set_down(&world->bus, BENCH_BUS_NAVCOMP, true);
    sim_clock_set(&world->clock, SIM_ACTOR_NAVCOMP, SIM_NEVER);
    bench_life_tear_memory(life, &stream);
    life->nv.size = 0;
    if (event->count > 0U) {
        bench_watch_excuse(life, BENCH_EXCUSE_FLIPPED);
        bench_life_flip_bits(life, &stream, event->count);
    }
    bench_watch_ended(life);
    life->watch.decided_us = (life->watch.decided_us >= world->clock.now_us) ? SIM_NEVER : 0U;
    life->attend_us = SIM_NEVER;
    life->power_us = world->clock.now_us + event->off_us;
}

void bench_life_power_on(bench_life_t *life)
{
    bench_world_t *const world = &life->world;
    life->power_us = SIM_NEVER;
    world->off = false;
    sim_bus_set_down(&world->bus, BENCH_BUS_NAVCOMP, true); /* what had come for nobody */
    sim_bus_set_down(&world->bus, BENCH_BUS_NAVCOMP, false);
    bench_watch_power_on(life);
    bench_life_boot(life);
    life->attend_us = life->run_was_on ? world->clock.now_us + 1500000U : SIM_NEVER;
}
