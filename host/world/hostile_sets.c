/* The invariants of the coefficient sets and of what can be read. */
#include "world/hostile.h"

#include "core/bytes.h"

#include <math.h>

#define TOLD_US 2000000U
#define DECIDED_US 5000000U /* what is decided is done by then */

/* What excuses coefficients that are off. */
static bool is_excused(const bench_life_t *life)
{
    static const uint32_t EXCUSES = 1U << BENCH_EXCUSE_REWRITTEN | 1U << BENCH_EXCUSE_STEP | 1U << BENCH_EXCUSE_SLIP |
                                    1U << BENCH_EXCUSE_SHORT | 1U << BENCH_EXCUSE_CHANNEL | 1U << BENCH_EXCUSE_SAMPLE |
                                    1U << BENCH_EXCUSE_RULES;
    return (life->watch.excuses & EXCUSES) != 0U;
}

static void compare_with_truth(bench_life_t *life, const tumble_set_t *set)
{
    const tumble_coefficients_t *const truth = &life->world.truth.block;
    double worst = 0.0;
    uint32_t where = 0;
    for (uint32_t c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        const uint32_t row = (c < 9U) ? c / 3U : c - 9U;
        const double off = (c < 9U) ? set->coefficients.k_v_per_g[row][c % 3U] - truth->k_v_per_g[row][c % 3U]
                                    : set->coefficients.u0_v[row] - truth->u0_v[row];
        const double u = (c < 9U) ? set->uncertainty.k_v_per_g[row][c % 3U] : set->uncertainty.u0_v[row];
        const double ratio = fabs(off) / u;
        if (!(ratio <= worst)) {
            worst = ratio;
            where = c;
        }
    }
    if (!(worst <= BENCH_TRUTH_COVERAGE)) {
        bench_watch_break(life, BENCH_BROKEN_TRUTH, worst, where);
    }
}

/* Another set is active. */
static void look_at_new(bench_life_t *life)
{
    tumble_set_t set;
    if (tumble_store_read(&life->keeper.sets.store, TUMBLE_SET_ACTIVE, &set) != TUMBLE_OK ||
        set.origin != TUMBLE_ORIGIN_COMMITTED) {
        return;
    }
    life->counts.committed++;
    if (!is_excused(life)) {
        life->counts.judged++;
        compare_with_truth(life, &set);
    }
}

/* A flipped bit may have hit it. */
static void bear_decay(bench_life_t *life, bench_broken_t kind, double value)
{
    if (!bench_watch_has_excuse(life, BENCH_EXCUSE_FLIPPED)) {
        bench_watch_break(life, kind, value, life->watch.counter);
    } else if (life->watch.told_by_us == SIM_NEVER) {
        life->watch.told_by_us = life->world.clock.now_us + TOLD_US;
    }
}

static void look_whether_told(bench_life_t *life)
{
    bench_watch_t *const watch = &life->watch;
    if (watch->told_by_us == SIM_NEVER) {
        return;
    }
    tumble_sets_state_t state;
    tumble_sets_state(&life->keeper.sets, &state);
    const bool lacks = !watch->has_set && (state.due & TUMBLE_DUE_NO_SET) != 0; /* which says it */
    if (watch->told || lacks || (state.due & TUMBLE_DUE_DECAYED) != 0) {
        watch->told_by_us = SIM_NEVER;
    } else if (life->world.clock.now_us >= watch->told_by_us) {
        watch->told_by_us = SIM_NEVER;
        if (life->counts.flips == 1U) {
            bench_watch_break(life, BENCH_BROKEN_COUNTER, (double)watch->counter, watch->counter);
        }
    }
}

/* Have bits of the proposal flipped? */
static bool was_hit(const bench_life_t *life)
{
    bool hit = false;
    for (uint32_t i = 0; i < life->flipped_count; i++) {
        hit = hit || life->flipped[i].offset == TUMBLE_REGION_PROPOSAL * SIM_NV_SECTOR;
    }
    return hit;
}

/* A proposal stays until somebody decides, or another result takes its place. */
static void look_at_proposal(bench_life_t *life)
{
    bench_watch_t *const watch = &life->watch;
    const uint32_t proposal = tumble_store_proposal(&life->keeper.sets.store);
    if (proposal == watch->proposal) {
        return;
    }
    if (watch->proposal != 0U && life->world.clock.now_us > watch->decided_us && !was_hit(life)) {
        bench_watch_break(life, BENCH_BROKEN_PROPOSAL, (double)proposal, watch->proposal);
    }
    watch->proposal = proposal;
    watch->decided_us = 0;
}

void bench_watch_decide(bench_life_t *life, tumble_command_t command, bool refused)
{
    if (command == TUMBLE_COMMAND_ACCEPT || command == TUMBLE_COMMAND_DISCARD || command == TUMBLE_COMMAND_ROLLBACK) {
        bench_watch_may_go(life, !refused);
    }
}

void bench_watch_may_go(bench_life_t *life, bool may)
{
    life->watch.decided_us = may ? life->world.clock.now_us + DECIDED_US : 0U;
}

static bool counts_as_valid(const bench_life_t *life, uint32_t offset)
{
    const tumble_sets_t *const sets = &life->keeper.sets;
    const uint32_t region = offset / SIM_NV_SECTOR;
    if (region <= TUMBLE_REGION_PROPOSAL) {
        return sets->store.places[region].valid;
    }
    const uint32_t cell = offset % SIM_NV_SECTOR / TUMBLE_HISTORY_BYTES;
    return !tumble_history_busy(&sets->history) &&
           (sets->history.valid[region - TUMBLE_REGION_HISTORY] >> cell & 1U) != 0U;
}

static void look_at_flipped(bench_life_t *life)
{
    for (uint32_t i = 0; i < life->flipped_count; i++) {
        const bench_flipped_t *const flipped = &life->flipped[i];
        if (counts_as_valid(life, flipped->offset) && bench_life_is_flipped(life, flipped)) {
            bench_watch_break(life, BENCH_BROKEN_DECAYED, 0.0, flipped->offset);
        }
    }
}

void bench_watch_sets(bench_life_t *life)
{
    bench_watch_t *const watch = &life->watch;
    const tumble_store_t *const store = &life->keeper.sets.store;
    if (!store->booted || tumble_store_busy(store)) {
        return;
    }
    const bool has_set = tumble_store_has(store, TUMBLE_SET_ACTIVE);
    const uint32_t counter = tumble_store_sequence(store);
    if (watch->has_set && !has_set) {
        bear_decay(life, BENCH_BROKEN_LOST, 0.0);
    } else if (counter < watch->counter) {
        bear_decay(life, BENCH_BROKEN_COUNTER, (double)counter);
    } else if (counter > watch->counter) {
        look_at_new(life);
    }
    watch->has_set = has_set;
    watch->counter = counter;
    look_whether_told(life);
    look_at_proposal(life);
    look_at_flipped(life);
}

void bench_watch_power_on(bench_life_t *life)
{
    life->watch.told = false;
    bench_watch_may_go(life, life->watch.decided_us == SIM_NEVER);
    bench_watch_begin_again(life);
}

/* What can be read. */

static bool is_finite(const tumble_entry_t *entry, const uint8_t *bytes)
{
    return (entry->type == TUMBLE_TYPE_REAL32) ? isfinite(tumble_get_f32(bytes)) : isfinite(tumble_get_f64(bytes));
}

static void read_row(bench_life_t *life, const tumble_entry_t *row)
{
    tumble_node_t *const node = &life->world.navcomp.node;
    for (uint32_t object = 0; object <= row->more_objects; object++) {
        for (uint32_t sub = 0; sub <= row->more_subindices; sub++) {
            uint8_t bytes[TUMBLE_MAX_OBJECT_BYTES];
            uint8_t size = 0;
            const uint16_t index = (uint16_t)(row->index + object);
            const uint8_t subindex = (uint8_t)(row->subindex + sub);
            if (tumble_node_read(node, index, subindex, bytes, &size) == TUMBLE_ABORT_NONE && !is_finite(row, bytes)) {
                bench_watch_break(life, BENCH_BROKEN_FINITE, 0.0, (uint32_t)index << 8 | subindex);
            }
        }
    }
}

static void read_table(bench_life_t *life, const tumble_object_table_t *table)
{
    for (uint32_t i = 0; i < table->count; i++) {
        const tumble_entry_t *const row = &table->entries[i];
        const bool real = row->type == TUMBLE_TYPE_REAL32 || row->type == TUMBLE_TYPE_REAL64;
        if (real && (row->access & TUMBLE_ACCESS_READ) != 0U) {
            read_row(life, row);
        }
    }
}

void bench_watch_read_all(bench_life_t *life)
{
    const tumble_dictionary_t *const dictionary = &life->world.navcomp.node.dictionary;
    read_table(life, dictionary->table);
    if (dictionary->extension != NULL) {
        read_table(life, dictionary->extension->table);
    }
}
