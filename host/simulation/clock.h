/* clock.h - virtual time: jumps from one event to the next.
 *
 * Every actor of a run has one alarm. Time moves to the earliest alarm and nowhere in between, so an idle hour costs
 * nothing. Alarms of one moment go off in the order of the actors' numbers, whatever the order in which they were set,
 * so a run has one course only. With so few actors a look at all of them is faster than any heap; moment and actor
 * share one number, so that the smallest says both.
 */
#ifndef TUMBLE_SIMULATION_CLOCK_H
#define TUMBLE_SIMULATION_CLOCK_H

#include <assert.h>
#include <stdbool.h>
#include <stdint.h>

/* The bus comes last: all frames handed in at one moment take part in the same arbitration. */
typedef enum {
    SIM_ACTOR_FAULTS = 0,
    SIM_ACTOR_OPERATOR,
    SIM_ACTOR_BLOCK,
    SIM_ACTOR_DRIVE,
    SIM_ACTOR_NAVCOMP,
    SIM_ACTOR_DELAY, /* frames held back by a fault */
    SIM_ACTOR_BUS,
    SIM_ACTORS
} sim_actor_t;

#define SIM_ACTOR_BITS 3

static_assert(SIM_ACTORS <= 1 << SIM_ACTOR_BITS, "an actor fits beside its moment");

#define SIM_NEVER (UINT64_MAX >> SIM_ACTOR_BITS)

/* A node that could not send offers the frame again after this time. */
#define SIM_RETRY_US 1000U

typedef struct {
    uint64_t now_us;
    uint64_t alarm[SIM_ACTORS]; /* moment << SIM_ACTOR_BITS | actor; moment SIM_NEVER: off */
} sim_clock_t;

/* Time 0, all alarms off. */
void sim_clock_init(sim_clock_t *clock);

/* Set an actor's alarm, replacing the one it had; a time in the past means now, SIM_NEVER turns it off. */
static inline void sim_clock_set(sim_clock_t *clock, sim_actor_t actor, uint64_t at_us)
{
    const uint64_t moment_us = (at_us < clock->now_us) ? clock->now_us : (at_us > SIM_NEVER) ? SIM_NEVER : at_us;
    clock->alarm[actor] = moment_us << SIM_ACTOR_BITS | (uint64_t)actor;
}

/* As sim_clock_set, but never later than the alarm already set. */
static inline void sim_clock_set_no_later(sim_clock_t *clock, sim_actor_t actor, uint64_t at_us)
{
    if (at_us < clock->alarm[actor] >> SIM_ACTOR_BITS) {
        sim_clock_set(clock, actor, at_us);
    }
}

/* When the earliest alarm goes off; SIM_NEVER if all are off. */
uint64_t sim_clock_next_us(const sim_clock_t *clock);

/* When a node that has just been looked at wants to be looked at again: what it wanted at once it could not do. */
static inline uint64_t sim_clock_again_us(const sim_clock_t *clock, uint64_t wanted_us)
{
    return (wanted_us <= clock->now_us) ? clock->now_us + SIM_RETRY_US : wanted_us;
}

/* Move to the earliest alarm, turn it off and say whose it is. False, and time stays, when there is none up to and
 * including `limit_us`. */
bool sim_clock_next(sim_clock_t *clock, uint64_t limit_us, sim_actor_t *actor);

#endif
