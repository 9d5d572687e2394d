/* What the active set is, and what is told when it decays. */
#include "sets/parts.h"

#include "core/arith.h"
#include "core/one_copy.h"

#include <stddef.h>

static void note_active(tumble_sets_t *sets, const tumble_set_t *set)
{
    const bool known = (set->flags & TUMBLE_SET_HAS_TEMPERATURE) != 0U;
    const double half_c = 2.0 * set->temperature_c;
    sets->has_active_half_c = known && tumble_within(half_c + 0.5, (double)INT8_MAX + 0.5); /* from INT8_MIN on */
    const int size = sets->has_active_half_c ? (int)tumble_whole(tumble_abs(half_c)) : 0;
    sets->active_half_c = (int16_t)(tumble_is_positive(half_c) ? size : -size);
    sets->active_utc_s = set->date_utc_s;
}

void tumble_sets_try_history_again(tumble_sets_t *sets)
{
    sets->stale = sets->stale || (sets->history_tries != 0U);
}

/* Append the history entry of a commit that a loss of power or a failing memory has prevented. */
static void write_history(tumble_sets_t *sets, const tumble_set_t *set)
{
    tumble_history_entry_t entry;
    if (set->sequence <= tumble_history_sequence(&sets->history)) {
        return;
    }
    tumble_status_t status = tumble_history_from_set(set, &entry);
    if (status == TUMBLE_OK) {
        const bool other_block = (set->reasons & TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_OTHER_BLOCK)) != 0U;
        entry.flags |= other_block ? TUMBLE_HISTORY_OTHER_BLOCK : 0U;
        sets->history_tries = (uint8_t)(sets->history_tries - ((sets->history_tries != 0U) ? 1U : 0U));
        status = tumble_history_append(&sets->history, &entry);
    }
    if (status != TUMBLE_OK) {
        tumble_sets_fail(sets, status);
    }
    if (status == TUMBLE_E_NV) {
        tumble_sets_try_history_again(sets);
    }
}

static void note_change(tumble_sets_t *sets)
{
    const uint32_t sequence = tumble_store_sequence(&sets->store);
    if (sets->sequence != sequence) {
        sets->sequence = sequence;
        sets->active_us = sets->now_us;
        sets->shown = UINT32_MAX;
    }
}

/* Decay: the history knows of a set that the store no longer has. */

/* A decay goes into the history once, however often power comes back: is the newest entry about it already? */
TUMBLE_ONE_COPY void tumble_sets_record_decay(tumble_sets_t *sets)
{
    tumble_history_entry_t entry;
    tumble_set_t active = {.sequence = 0};
    tumble_status_t status = tumble_history_read(&sets->history, 0, &entry);
    if (status == TUMBLE_OK) {
        const bool there = (entry.origin == (uint8_t)TUMBLE_ORIGIN_DECAYED);
        status = there ? TUMBLE_E_STATE : tumble_store_read(&sets->store, TUMBLE_SET_ACTIVE, &active);
        status = (!there && (status == TUMBLE_E_STATE)) ? TUMBLE_OK : status; /* no set is left: zeros */
    }
    if (status == TUMBLE_E_PORT_BUSY) {
        return;
    }
    sets->wants &= (uint8_t)~(unsigned)WANT_RECORD_DECAY;
    if ((status == TUMBLE_OK) && (tumble_history_from_set(&active, &entry) == TUMBLE_OK)) {
        entry.sequence = tumble_history_sequence(&sets->history);
        entry.origin = (uint8_t)TUMBLE_ORIGIN_DECAYED;
        entry.date_utc_s = tumble_sets_utc_s(sets);
        (void)tumble_history_append(&sets->history, &entry); /* refused: the next power-on tries again */
    }
}

static void note_decay(tumble_sets_t *sets)
{
    const uint32_t known = tumble_history_sequence(&sets->history);
    const bool gone = (known > sets->sequence) && (known < TUMBLE_MAX_SEQUENCE);
    const bool decayed = gone && !tumble_store_has_newer(&sets->store);
    if (decayed && !sets->decayed) {
        sets->wants |= WANT_RECORD_DECAY;
    }
    sets->decayed = decayed;
}

TUMBLE_ONE_COPY void tumble_sets_refresh(tumble_sets_t *sets)
{
    tumble_set_t active;
    const tumble_status_t status = tumble_store_read(&sets->store, TUMBLE_SET_ACTIVE, &active);
    if (status == TUMBLE_E_PORT_BUSY) {
        return;
    }
    tumble_store_number_above(&sets->store, tumble_history_sequence(&sets->history));
    sets->stale = false;
    sets->has_active = (status == TUMBLE_OK);
    sets->off_temperature = 0;
    note_change(sets);
    note_decay(sets);
    if (sets->has_active) {
        note_active(sets, &active);
        write_history(sets, &active);
    } else {
        sets->has_active_half_c = false;
        sets->active_utc_s = 0;
        if (status != TUMBLE_E_STATE) {
            tumble_sets_fail(sets, status);
        }
    }
    tumble_sets_count_resumable(sets);
}
