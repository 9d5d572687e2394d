#include "world/hostile_draw.h"

double bench_draw(sim_random_t *stream, double low, double high)
{
    return low + (high - low) * sim_random_unit(stream);
}

uint32_t bench_pick(sim_random_t *stream, uint32_t count)
{
    return (uint32_t)((sim_random_u64(stream) >> 32) * (uint64_t)count >> 32);
}

bool bench_chance(sim_random_t *stream, double probability)
{
    return sim_random_unit(stream) < probability;
}

bench_event_t *bench_plan_add(bench_plan_t *plan, bench_hostile_t kind, double at_s)
{
    static bench_event_t beyond;
    bench_event_t *const event = (plan->count < BENCH_PLAN_EVENTS) ? &plan->events[plan->count] : &beyond;
    *event = (bench_event_t){.kind = kind, .number = plan->count};
    event->moment.at_us = (uint64_t)((at_s > 0.0) ? at_s * 1e6 : 0.0);
    plan->count += (event != &beyond) ? 1U : 0U;
    return event;
}

bench_event_t *bench_plan_add_command(bench_plan_t *plan, double at_s, tumble_command_t command, uint8_t argument)
{
    bench_event_t *const event = bench_plan_add(plan, BENCH_HOSTILE_COMMAND, at_s);
    event->command = command;
    event->argument = argument;
    return event;
}
