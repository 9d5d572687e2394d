#include "world/hostile_life.h"

#include <string.h>

static void take_out(bench_plan_t *plan, uint32_t first, uint32_t count)
{
    memmove(&plan->events[first], &plan->events[first + count], (plan->count - first - count) * sizeof plan->events[0]);
    plan->count -= count;
}

static bool breaks(bench_plan_t *plan, bench_life_t *life, bench_broken_t kind)
{
    bench_life_run(life, plan);
    return life->watch.violation.kind == kind;
}

/* One round with pieces of this size. True: something went. */
static bool one_round(bench_plan_t *plan, bench_life_t *life, bench_broken_t kind, uint32_t size)
{
    static bench_event_t kept[BENCH_PLAN_EVENTS];
    bool shrunk = false;
    uint32_t at = 0;
    while (at < plan->count) {
        const uint32_t before = plan->count;
        const uint32_t piece = (size < before - at) ? size : before - at;
        memcpy(kept, plan->events, sizeof kept);
        take_out(plan, at, piece);
        if (breaks(plan, life, kind)) {
            shrunk = true;
        } else {
            memcpy(plan->events, kept, sizeof kept);
            plan->count = before;
            at += piece;
        }
    }
    return shrunk;
}

void bench_plan_shrink(bench_plan_t *plan, bench_life_t *life, bench_broken_t kind)
{
    for (uint32_t size = (plan->count + 1U) / 2U; size > 1U; size = (size + 1U) / 2U) {
        (void)one_round(plan, life, kind, size);
    }
    while (one_round(plan, life, kind, 1)) {
    }
    (void)breaks(plan, life, kind);
}
