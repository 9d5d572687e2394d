/* What the active set is, and what is told when it decays. */
#include "navcomp/keeper_internal.h"
#include "navcomp/navcomp_internal.h"

#include <stddef.h>

static void note_active(tumble_keeper_t *keeper, const tumble_set_t *set)
{
    const bool known = (set->flags & TUMBLE_SET_HAS_TEMPERATURE) != 0U;
    const double half_c = 2.0 * set->temperature_c;
    keeper->has_active_half_c = known && (half_c >= (double)INT8_MIN) && (half_c <= (double)INT8_MAX);
    keeper->active_half_c = (int16_t)(keeper->has_active_half_c ? half_c : 0.0);
    keeper->active_utc_s = set->date_utc_s;
}

void tumble_keeper_try_history_again(tumble_keeper_t *keeper)
{
    keeper->stale = keeper->stale || (keeper->history_tries != 0U);
}

/* A commit whose entry in the history a loss of power or the memory prevented is caught up on here. */
static void write_history(tumble_keeper_t *keeper, const tumble_set_t *set)
{
    tumble_history_entry_t entry;
    if (set->sequence <= tumble_history_sequence(&keeper->history)) {
        return;
    }
    tumble_status_t status = tumble_history_from_set(set, &entry);
    if (status == TUMBLE_OK) {
        const bool other_block = (set->reasons & TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_OTHER_BLOCK)) != 0U;
        entry.flags |= other_block ? TUMBLE_HISTORY_OTHER_BLOCK : 0U;
        keeper->history_tries = (uint8_t)(keeper->history_tries - ((keeper->history_tries != 0U) ? 1U : 0U));
        status = tumble_history_append(&keeper->history, &entry);
    }
    if (status != TUMBLE_OK) {
        tumble_keeper_fail(keeper, status);
    }
    if (status == TUMBLE_E_NV) {
        tumble_keeper_try_history_again(keeper);
    }
}

static void note_change(tumble_keeper_t *keeper)
{
    const uint32_t sequence = tumble_store_sequence(&keeper->store);
    if (keeper->sequence != sequence) {
        keeper->sequence = sequence;
        keeper->active_us = keeper->now_us;
        keeper->shown = UINT32_MAX;
    }
}

/* Decay: the history knows of a set that the store no longer has. */

/* The error register has one bit for all errors of the maker, and a reset of the communication clears it. So the message
 * is sent again as long as the bit is not set. */
void tumble_keeper_tell_decay(tumble_keeper_t *keeper)
{
    tumble_emcy_t *emcy = &keeper->navcomp->node.emcy;
    const bool told = (emcy->error_register & TUMBLE_ERROR_MANUFACTURER) != 0U;
    if (keeper->decayed && !told) {
        tumble_emcy_tell(emcy, TUMBLE_KEEPER_EMCY_DECAYED, TUMBLE_ERROR_MANUFACTURER, keeper->sequence);
        keeper->decay_told = true;
    } else if (!keeper->decayed && keeper->decay_told) {
        tumble_emcy_clear(emcy, TUMBLE_ERROR_MANUFACTURER);
        keeper->decay_told = false;
    } else {
        /* nothing has changed */
    }
}

/* The event goes into the history once, however often power comes back: has the newest entry told it? */
void tumble_keeper_record_decay(tumble_keeper_t *keeper)
{
    tumble_history_entry_t entry;
    tumble_set_t active = {.sequence = 0};
    tumble_status_t status = tumble_history_read(&keeper->history, 0, &entry);
    if (status == TUMBLE_OK) {
        const bool there = (entry.origin == (uint8_t)TUMBLE_ORIGIN_DECAYED);
        status = there ? TUMBLE_E_STATE : tumble_store_read(&keeper->store, TUMBLE_SET_ACTIVE, &active);
        status = (!there && (status == TUMBLE_E_STATE)) ? TUMBLE_OK : status; /* no set is left: zeros */
    }
    if (status == TUMBLE_E_PORT_BUSY) {
        return;
    }
    keeper->wants &= (uint8_t)~(unsigned)WANT_RECORD_DECAY;
    if ((status == TUMBLE_OK) && (tumble_history_from_set(&active, &entry) == TUMBLE_OK)) {
        entry.sequence = tumble_history_sequence(&keeper->history);
        entry.origin = (uint8_t)TUMBLE_ORIGIN_DECAYED;
        entry.date_utc_s = tumble_keeper_utc_s(keeper);
        (void)tumble_history_append(&keeper->history, &entry); /* refused: the next power-on tries again */
    }
}

static void note_decay(tumble_keeper_t *keeper)
{
    const uint32_t known = tumble_history_sequence(&keeper->history);
    const bool decayed = (known > keeper->sequence) && (known < TUMBLE_MAX_SEQUENCE);
    if (decayed && !keeper->decayed) {
        keeper->wants |= WANT_RECORD_DECAY;
    }
    keeper->decayed = decayed;
}

void tumble_keeper_refresh(tumble_keeper_t *keeper)
{
    tumble_set_t active;
    const tumble_status_t status = tumble_store_read(&keeper->store, TUMBLE_SET_ACTIVE, &active);
    if (status == TUMBLE_E_PORT_BUSY) {
        return;
    }
    tumble_store_number_above(&keeper->store, tumble_history_sequence(&keeper->history));
    keeper->stale = false;
    keeper->has_active = (status == TUMBLE_OK);
    keeper->off_temperature = 0;
    note_change(keeper);
    note_decay(keeper);
    if (keeper->has_active) {
        note_active(keeper, &active);
        write_history(keeper, &active);
    } else {
        keeper->has_active_half_c = false;
        keeper->active_utc_s = 0;
        if (status != TUMBLE_E_STATE) {
            tumble_keeper_fail(keeper, status);
        }
    }
    tumble_keeper_count_resumable(keeper);
}
