/* pace.h - virtual time tied to the wall's: an event is not let happen before its time. */
#ifndef TUMBLE_BENCH_PACE_H
#define TUMBLE_BENCH_PACE_H

#include "bench/guests.h"
#include "bench/world.h"

#include <stdint.h>

typedef struct {
    double factor;       /* virtual seconds per second */
    double wall_s;       /* at the start ... */
    uint64_t virtual_us; /* ... it was this virtual time */
} bench_pace_t;

/* Virtual time goes on from here. */
void bench_pace_start(bench_pace_t *pace, const bench_world_t *world, double factor);

/* Wait until the next event is due, or a guest (may be null) has handed in frames, which are put on the bus, or the
 * program is interrupted. */
void bench_pace_wait(const bench_pace_t *pace, bench_world_t *world, bench_guests_t *guests);

#endif
