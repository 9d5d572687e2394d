#include "simulation/clock.h"

void sim_clock_init(sim_clock_t *clock)
{
    clock->now_us = 0;
    for (int i = 0; i < SIM_ACTORS; i++) {
        sim_clock_set(clock, (sim_actor_t)i, SIM_NEVER);
    }
}

static uint64_t earlier(uint64_t one, uint64_t other)
{
    return (one < other) ? one : other;
}

/* In pairs, side by side: one after the other each comparison would wait for the last. */
static uint64_t earliest(const sim_clock_t *clock)
{
    static_assert(SIM_ACTORS == 7, "all alarms are looked at");
    const uint64_t *const alarm = clock->alarm;
    const uint64_t first = earlier(earlier(alarm[0], alarm[1]), earlier(alarm[2], alarm[3]));
    return earlier(first, earlier(earlier(alarm[4], alarm[5]), alarm[6]));
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
