/* store_logs.h - the history and the checkpoint under disturbance, and what may be found after it. Needs no Unity. */
#ifndef STORE_LOGS_H
#define STORE_LOGS_H

#include "store_jobs.h"
#include "tumble/sets.h"

#define LOG_LAST 16U /* entries that survive whatever happens */

static tumble_history_t logs_history;
static uint32_t logs_entries; /* appended before; their sequences are 1, 2, ... */

static inline bool history_settles(void)
{
    int steps = 0;
    while (tumble_history_step(&logs_history) == TUMBLE_E_PORT_BUSY && steps < STEPS_AT_MOST) {
        steps++;
    }
    return steps < STEPS_AT_MOST;
}

static inline bool history_boot(nv_memory_t *memory)
{
    return tumble_history_init(&logs_history, &memory->nv) == TUMBLE_OK && history_settles();
}

static inline tumble_history_entry_t entry_of(uint32_t sequence)
{
    tumble_set_t set = set_of(sequence % 100U);
    tumble_history_entry_t entry = {0};
    set.sequence = sequence;
    (void)tumble_history_from_set(&set, &entry);
    return entry;
}

static inline tumble_status_t append_entry(uint32_t sequence)
{
    const tumble_history_entry_t entry = entry_of(sequence);
    const tumble_status_t status = tumble_history_append(&logs_history, &entry);
    if (status != TUMBLE_OK) {
        return status;
    }
    return history_settles() ? tumble_history_step(&logs_history) : TUMBLE_E_PORT_BUSY;
}

static inline tumble_status_t job_append(void)
{
    return append_entry(logs_entries + 1U);
}

/* The sequence of an entry that is what was appended; 0: it is not. */
static inline uint32_t sequence_at(uint8_t age)
{
    tumble_history_entry_t found;
    uint8_t one[TUMBLE_HISTORY_BYTES];
    uint8_t other[TUMBLE_HISTORY_BYTES];
    if (tumble_history_read(&logs_history, age, &found) != TUMBLE_OK) {
        return 0;
    }
    const tumble_history_entry_t expected = entry_of(found.sequence);
    found.number = 0;
    (void)tumble_history_encode(&found, one);
    (void)tumble_history_encode(&expected, other);
    return (memcmp(one, other, sizeof one) == 0) ? found.sequence : 0U;
}

/* Newest first, the new one or not, and the last sixteen of those before without a gap. A new one may be there twice: where
 * the memory said that it had failed, and had not. Of the oldest an erase that was cut short may leave any. */
static inline state_t look_append(void)
{
    const uint8_t count = tumble_history_count(&logs_history);
    uint32_t next = logs_entries;
    uint8_t news = 0;
    while (news < count && sequence_at(news) == logs_entries + 1U) {
        news++;
    }
    for (uint32_t i = 0; news + i < count; i++) {
        const uint32_t sequence = sequence_at((uint8_t)(news + i));
        if (sequence == 0U || sequence > next || (i < LOG_LAST && sequence != next)) {
            return STATE_BAD;
        }
        next = sequence - 1U;
    }
    if (news > 2U || (logs_entries - next < LOG_LAST && next != 0U)) {
        return STATE_BAD;
    }
    return (news > 0U) ? STATE_AFTER : STATE_BEFORE;
}

static inline void prepare_history(nv_memory_t *memory, const start_t *start)
{
    (void)history_boot(memory);
    for (logs_entries = 0; logs_entries < start->entries; logs_entries++) {
        (void)append_entry(logs_entries + 1U);
    }
}

/* And every second entry torn in the sector before the change. */
static inline void prepare_torn_entries(nv_memory_t *memory, const start_t *start)
{
    prepare_history(memory, start);
    for (uint32_t i = 0; i < 16U; i++) {
        nv_arm(memory, (nv_fault_t){(i == 0U) ? 1U : 0U, DONE_HALF, THEN_CUT}); /* the first one erases */
        (void)append_entry(logs_entries + 1U);
        nv_arm(memory, nv_no_fault);
        (void)history_boot(memory);
        (void)append_entry(++logs_entries);
    }
}

static const scenario_t history_scenarios[] = {
    {"the first entry of the history", prepare_history, history_boot, job_append, look_append, {.entries = 0}},
    {"an entry of the history", prepare_history, history_boot, job_append, look_append, {.entries = 5}},
    {"the first change of sector", prepare_history, history_boot, job_append, look_append, {.entries = 32}},
    {"an entry in the second sector", prepare_history, history_boot, job_append, look_append, {.entries = 40}},
    {"a change of sector over the oldest", prepare_history, history_boot, job_append, look_append, {.entries = 64}},
    {"an entry of the history among torn ones",
     prepare_torn_entries,
     history_boot,
     job_append,
     look_append,
     {.entries = 32}},
};

static tumble_checkpoint_t logs_checkpoint;
static uint32_t logs_kept; /* entries appended before, entry i at index i modulo TUMBLE_MAX_POSITIONS */
enum { OLD_RUN = 0x11111111, NEW_RUN = 0x22222222 };

static inline bool checkpoint_settles(void)
{
    int steps = 0;
    while (tumble_checkpoint_step(&logs_checkpoint) == TUMBLE_E_PORT_BUSY && steps < STEPS_AT_MOST) {
        steps++;
    }
    return steps < STEPS_AT_MOST;
}

static inline bool checkpoint_boot(nv_memory_t *memory)
{
    return tumble_checkpoint_init(&logs_checkpoint, &memory->nv) == TUMBLE_OK && checkpoint_settles();
}

static inline tumble_status_t checkpoint_ended(tumble_status_t begun)
{
    if (begun != TUMBLE_OK) {
        return begun;
    }
    return checkpoint_settles() ? tumble_checkpoint_step(&logs_checkpoint) : TUMBLE_E_PORT_BUSY;
}

static inline tumble_average_t average_of(uint32_t number)
{
    tumble_average_t average = {.samples = 50U + number};
    for (int i = 0; i < 3; i++) {
        average.sum_counts[i] = (number % 2U == 0U ? -1 : 1) * (INT64_C(1) << 40) * (i + 1) + (int64_t)number;
        average.scatter_counts[i] = 1.5F + (float)number / 4.0F + (float)i;
    }
    return average;
}

static inline tumble_status_t append_average(uint32_t number)
{
    const tumble_average_t average = average_of(number);
    const uint8_t index = (uint8_t)(number % TUMBLE_MAX_POSITIONS);
    return checkpoint_ended(tumble_checkpoint_append(&logs_checkpoint, index, &average));
}

/* clang-format off: a line each */
static inline tumble_status_t job_keep(void)
{
    return append_average(logs_kept);
}
static inline tumble_status_t job_begin(void)
{
    return checkpoint_ended(tumble_checkpoint_begin(&logs_checkpoint, NEW_RUN));
}
static inline tumble_status_t job_clear(void)
{
    return checkpoint_ended(tumble_checkpoint_clear(&logs_checkpoint));
}
/* clang-format on */

static inline bool average_is(uint8_t index, uint32_t number)
{
    const tumble_average_t expected = average_of(number);
    tumble_average_t found = {0};
    bool same =
        tumble_checkpoint_read(&logs_checkpoint, index, &found) == TUMBLE_OK && found.samples == expected.samples;
    for (int i = 0; i < 3; i++) {
        same = same && found.sum_counts[i] == expected.sum_counts[i] &&
               !(found.scatter_counts[i] < expected.scatter_counts[i]) &&
               !(found.scatter_counts[i] > expected.scatter_counts[i]);
    }
    return same;
}

/* The last of those kept before at this index; logs_kept: none. */
static inline uint32_t last_before(uint8_t index)
{
    uint32_t last = logs_kept;
    for (uint32_t number = index; number < logs_kept; number += TUMBLE_MAX_POSITIONS) {
        last = number;
    }
    return last;
}

/* Whatever is there is what was kept; `all`: and all of it. */
static inline bool old_ones_are_right(bool all, uint8_t but_for)
{
    bool right = true;
    for (uint8_t index = 0; index < TUMBLE_MAX_POSITIONS; index++) {
        const uint32_t last = last_before(index);
        const bool has = tumble_checkpoint_has(&logs_checkpoint, index);
        if (index != but_for) {
            right = right && (!has || last < logs_kept) && (has || !all || last == logs_kept) &&
                    (!has || average_is(index, last) || (!all && last >= TUMBLE_MAX_POSITIONS));
        }
    }
    return right;
}

static inline state_t look_keep(void)
{
    const uint8_t index = (uint8_t)(logs_kept % TUMBLE_MAX_POSITIONS);
    const bool has = tumble_checkpoint_has(&logs_checkpoint, index);
    if (!tumble_checkpoint_matches(&logs_checkpoint, NEW_RUN) || !old_ones_are_right(true, index)) {
        return STATE_BAD;
    }
    if (has && average_is(index, logs_kept)) {
        return STATE_AFTER;
    }
    const uint32_t last = last_before(index);
    return (has ? (last < logs_kept && average_is(index, last)) : last == logs_kept) ? STATE_BEFORE : STATE_BAD;
}

static inline bool nothing_is_kept(void)
{
    bool nothing = true;
    for (uint8_t index = 0; index < TUMBLE_MAX_POSITIONS; index++) {
        nothing = nothing && !tumble_checkpoint_has(&logs_checkpoint, index);
    }
    return nothing;
}

static inline state_t look_begin(void)
{
    if (tumble_checkpoint_matches(&logs_checkpoint, NEW_RUN)) {
        return nothing_is_kept() ? STATE_AFTER : STATE_BAD;
    }
    if (tumble_checkpoint_matches(&logs_checkpoint, OLD_RUN)) {
        return old_ones_are_right(false, UINT8_MAX) ? STATE_BEFORE : STATE_BAD;
    }
    return nothing_is_kept() ? STATE_BEFORE : STATE_BAD;
}

static inline state_t look_clear(void)
{
    if (tumble_checkpoint_matches(&logs_checkpoint, OLD_RUN)) {
        return old_ones_are_right(false, UINT8_MAX) ? STATE_BEFORE : STATE_BAD;
    }
    return nothing_is_kept() ? STATE_AFTER : STATE_BAD;
}

static inline void prepare_run(nv_memory_t *memory, const start_t *start)
{
    (void)checkpoint_boot(memory);
    (void)checkpoint_ended(tumble_checkpoint_begin(&logs_checkpoint, start->run));
    for (logs_kept = 0; logs_kept < start->entries; logs_kept++) {
        (void)append_average(logs_kept);
    }
}

static inline void prepare_no_run(nv_memory_t *memory, const start_t *start)
{
    logs_kept = start->entries;
    (void)checkpoint_boot(memory);
}

static const scenario_t checkpoint_scenarios[] = {
    {"the first run", prepare_no_run, checkpoint_boot, job_begin, look_begin, {.entries = 0}},
    {"a run in place of another", prepare_run, checkpoint_boot, job_begin, look_begin, {.run = OLD_RUN, .entries = 80}},
    {"a run forgotten", prepare_run, checkpoint_boot, job_clear, look_clear, {.run = OLD_RUN, .entries = 80}},
    {"the first position", prepare_run, checkpoint_boot, job_keep, look_keep, {.run = NEW_RUN}},
    {"a position", prepare_run, checkpoint_boot, job_keep, look_keep, {.run = NEW_RUN, .entries = 17}},
    {"a position measured again", prepare_run, checkpoint_boot, job_keep, look_keep, {.run = NEW_RUN, .entries = 36}},
    {"a position in the second sector",
     prepare_run,
     checkpoint_boot,
     job_keep,
     look_keep,
     {.run = NEW_RUN, .entries = 63}},
};

#endif
