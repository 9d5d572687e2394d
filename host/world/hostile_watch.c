/* What is noted for all invariants. */
#include "world/hostile_invariants.h"

void bench_watch_break(bench_life_t *life, bench_broken_t kind, double value, uint32_t what)
{
    if (life->watch.violation.kind == BENCH_HOLDS) {
        life->watch.violation = (bench_violation_t){kind, life->world.clock.now_us, value, what};
    }
}

void bench_watch_init(bench_life_t *life)
{
    life->watch = (bench_watch_t){.rest_us = SIM_NEVER,
                                  .peace = true,
                                  .still_us = SIM_NEVER,
                                  .told_by_us = SIM_NEVER,
                                  .open_us = SIM_NEVER,
                                  .fast_us = SIM_NEVER,
                                  .state = TUMBLE_STATE_IDLE};
}

void bench_watch_excuse(bench_life_t *life, bench_excuse_t excuse)
{
    life->watch.excuses |= 1U << excuse;
    if (excuse == BENCH_EXCUSE_COMMANDED) {
        life->watch.commanded_us = life->world.clock.now_us;
    }
}

bool bench_watch_has_excuse(const bench_life_t *life, bench_excuse_t excuse)
{
    return (life->watch.excuses >> excuse & 1U) != 0U;
}

void bench_watch_commanded(bench_life_t *life)
{
    life->watch.rest_us = SIM_NEVER;
    life->watch.peace = false;
}
