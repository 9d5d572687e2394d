#include "simulation/clock.h"

void sim_clock_init(sim_clock_t *clock)
{
    clock->now_us = 0;
    for (int i = 0; i < SIM_ACTORS; i++) {
        sim_clock_set(clock, (sim_actor_t)i, SIM_NEVER);
    }
}

static uint64_t earliest(const sim_clock_t *clock)
{
    uint64_t first = clock->alarm[0];
    for (int i = 1; i < SIM_ACTORS; i++) {
        first = (clock->alarm[i] < first) ? clock->alarm[i] : first;
    }
    return first;
}

uint64_t sim_clock_next_us(const sim_clock_t *clock)
{
    return earliest(clock) >> SIM_ACTOR_BITS;
}

bool sim_clock_next(sim_clock_t *clock, uint64_t limit_us, sim_actor_t *actor)
{
    const uint64_t first = earliest(clock);
    const uint64_t due_us = first >> SIM_ACTOR_BITS;
    if (due_us == SIM_NEVER || due_us > limit_us) {
        return false;
    }
    *actor = (sim_actor_t)(first & ((1U << SIM_ACTOR_BITS) - 1U));
    clock->now_us = due_us;
    clock->alarm[*actor] |= SIM_NEVER << SIM_ACTOR_BITS;
    return true;
}
