#define _POSIX_C_SOURCE 200809L

#include "bench/pace.h"

#include "bench/interrupt.h"

#include <stddef.h>
#include <time.h>

#define LONGEST_NAP_S 0.5
#define SHORTEST_NAP_S 1e-3 /* the resolution of waiting for guests */

static double wall_s(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void bench_pace_start(bench_pace_t *pace, const bench_world_t *world, double factor)
{
    *pace = (bench_pace_t){factor, wall_s(), world->clock.now_us};
}

/* How long it is until the next event. */
static double left_s(const bench_pace_t *pace, const bench_world_t *world)
{
    const uint64_t next_us = bench_world_next_us(world);
    if (next_us == SIM_NEVER) {
        return LONGEST_NAP_S;
    }
    return (double)(next_us - pace->virtual_us) * 1e-6 / pace->factor - (wall_s() - pace->wall_s);
}

static uint64_t virtual_now_us(const bench_pace_t *pace)
{
    return pace->virtual_us + (uint64_t)((wall_s() - pace->wall_s) * pace->factor * 1e6);
}

static void nap(double time_s)
{
    const struct timespec time = {.tv_sec = (time_t)time_s, .tv_nsec = (long)((time_s - (double)(time_t)time_s) * 1e9)};
    (void)nanosleep(&time, NULL);
}

void bench_pace_wait(const bench_pace_t *pace, bench_world_t *world, bench_guests_t *guests)
{
    double time_s;
    while ((time_s = left_s(pace, world)) > 0.0 && !bench_interrupted()) {
        const double nap_s = (time_s < LONGEST_NAP_S) ? time_s : LONGEST_NAP_S;
        if (guests == NULL) {
            nap(nap_s);
        } else if (bench_guests_poll(guests, (nap_s > SHORTEST_NAP_S) ? nap_s : 0.0)) {
            bench_world_pass(world, virtual_now_us(pace));
            bench_guests_take(guests, world);
            if (bench_guests_have_left(guests)) {
                return;
            }
        }
    }
}
