#include "world/lives.h"

#include "world/hostile.h"
#include "world/readout.h"

#include <stdlib.h>
#include <string.h>

struct lives {
    bench_plan_t plan;
    bench_life_t life;
    bench_text_t text;
    const char *undrawn; /* why there is no plan */
};

lives_t *lives_new(void)
{
    return calloc(1, sizeof(lives_t));
}

void lives_free(lives_t *lives)
{
    free(lives);
}

const char *lives_live(lives_t *lives, uint64_t seed)
{
    lives->undrawn = bench_plan_draw(&lives->plan, seed);
    if (lives->undrawn != NULL) {
        memset(&lives->life, 0, sizeof lives->life);
        lives->life.watch.violation.kind = BENCH_BROKEN_BENCH;
    } else {
        bench_life_run(&lives->life, &lives->plan);
    }
    const bench_broken_t kind = lives->life.watch.violation.kind;
    return (kind == BENCH_HOLDS) ? NULL : bench_broken_name(kind);
}

const char *lives_violation(lives_t *lives, uint64_t *at_us)
{
    *at_us = lives->life.watch.violation.at_us;
    lives->text = bench_text_violation(&lives->life.watch.violation);
    return (lives->undrawn != NULL) ? lives->undrawn : lives->text.text;
}

bool lives_shrink(lives_t *lives, uint32_t *drawn, uint32_t *left)
{
    *drawn = lives->plan.count;
    if (lives->undrawn == NULL) {
        bench_plan_shrink(&lives->plan, &lives->life, lives->life.watch.violation.kind);
    }
    *left = lives->plan.count;
    return lives->undrawn == NULL;
}

const char *lives_line(lives_t *lives, uint32_t number)
{
    if (number > lives->plan.count) {
        return NULL;
    }
    lives->text = (number == 0U) ? bench_text_world(&lives->plan) : bench_text_event(&lives->plan.events[number - 1U]);
    return lives->text.text;
}

/* The groups of counts, each with as many rows as its list has. */

static uint64_t count_violation(const lives_t *lives, size_t row, const char **name)
{
    *name = bench_broken_name((bench_broken_t)(row + 1U));
    return (lives->life.watch.violation.kind == (bench_broken_t)(row + 1U)) ? 1U : 0U;
}

static uint64_t count_fault(const lives_t *lives, size_t row, const char **name)
{
    *name = sim_fault_word((sim_fault_kind_t)row);
    return lives->life.counts.faults[row];
}

static uint64_t count_event(const lives_t *lives, size_t row, const char **name)
{
    *name = bench_hostile_name((bench_hostile_t)row);
    return lives->life.counts.events[row];
}

static uint64_t count_excuse(const lives_t *lives, size_t row, const char **name)
{
    *name = bench_excuse_name((bench_excuse_t)row);
    return lives->life.watch.excuses >> row & 1U;
}

static uint64_t count_end(const lives_t *lives, tumble_state_t state, size_t row, const char **name)
{
    *name = tumble_reason_name((tumble_reason_t)row);
    return lives->life.counts.ends[state][row];
}

#define COUNT_END(function, state)                                                                                     \
    static uint64_t function(const lives_t *lives, size_t row, const char **name)                                      \
    {                                                                                                                  \
        return count_end(lives, state, row, name);                                                                     \
    }
COUNT_END(count_idle, TUMBLE_STATE_IDLE)
COUNT_END(count_done, TUMBLE_STATE_DONE)
COUNT_END(count_failed, TUMBLE_STATE_FAULT)
COUNT_END(count_aborted, TUMBLE_STATE_ABORT)

static uint64_t count_set(const lives_t *lives, size_t row, const char **name)
{
    static const char *const NAMES[] = {"committed", "judged", "held"};
    const bench_life_counts_t *const counts = &lives->life.counts;
    const uint32_t values[] = {counts->committed, counts->judged, counts->held};
    *name = NAMES[row];
    return values[row];
}

static uint64_t count_all(const lives_t *lives, size_t row, const char **name)
{
    static const char *const NAMES[] = {"flipped_bits", "homings", "virtual_us", "frames", "steps"};
    const bench_life_t *const life = &lives->life;
    const uint64_t values[] = {life->counts.flips, life->counts.homings, life->world.clock.now_us,
                               life->world.bus.load.frames, life->world.steps};
    *name = NAMES[row];
    return values[row];
}

static const struct {
    const char *group;
    size_t rows;
    uint64_t (*count)(const lives_t *lives, size_t row, const char **name);
} GROUPS[] = {
    {"violations", (size_t)BENCH_VIOLATION_KINDS - 1U, count_violation},
    {"faults", SIM_FAULT_KINDS, count_fault},
    {"events", BENCH_HOSTILE_KINDS, count_event},
    {"excuses", BENCH_EXCUSES, count_excuse},
    {"TUMBLE_STATE_IDLE", TUMBLE_REASON_COUNT, count_idle},
    {"TUMBLE_STATE_DONE", TUMBLE_REASON_COUNT, count_done},
    {"TUMBLE_STATE_FAULT", TUMBLE_REASON_COUNT, count_failed},
    {"TUMBLE_STATE_ABORT", TUMBLE_REASON_COUNT, count_aborted},
    {"sets", 3, count_set},
    {"all", 5, count_all},
};

const char *lives_count(const lives_t *lives, size_t row, const char **name, uint64_t *value)
{
    for (size_t g = 0; g < sizeof GROUPS / sizeof GROUPS[0]; g++) {
        if (row < GROUPS[g].rows) {
            *value = GROUPS[g].count(lives, row, name);
            return GROUPS[g].group;
        }
        row -= GROUPS[g].rows;
    }
    return NULL;
}

bool lives_travel(const lives_t *lives, bool *at_rest, double *lowest_deg, double *highest_deg)
{
    if (lives->life.world.clock.now_us == 0U) {
        return false;
    }
    const bench_travel_t travel = bench_travel(&lives->life.world);
    *at_rest = travel.at_rest;
    *lowest_deg = travel.lowest_deg;
    *highest_deg = travel.highest_deg;
    return true;
}
