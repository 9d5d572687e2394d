#include "core/one_copy.h"
#include "sets/history_entry.h"
#include "sets/log.h"

#include <stddef.h>
#include <string.h>

enum { JOB_ERASE = TUMBLE_LOG_OWN, JOB_WRITE };

#define MAX_NUMBER (UINT32_MAX - 1U)

static_assert(TUMBLE_HISTORY_CELLS == 32U, "the valid cells of a sector are the bits of one word");

static void forget(tumble_history_t *history)
{
    (void)memset(history->valid, 0, sizeof history->valid);
    history->newest = 0;
    history->sequence = 0;
    history->sector = 0;
}

tumble_status_t tumble_history_init(tumble_history_t *history, const tumble_nv_t *nv)
{
    static const tumble_log_kind_t kind = {TUMBLE_REGION_HISTORY, TUMBLE_HISTORY_CELLS, TUMBLE_HISTORY_BYTES};
    if (history == NULL) {
        return TUMBLE_E_ARGUMENT;
    }
    forget(history);
    return tumble_log_open(&history->log, &kind, nv);
}

bool tumble_history_busy(const tumble_history_t *history)
{
    return tumble_log_busy(&history->log);
}

/* The entry in `bytes`, of the cell that was looked at or written. False: there is none. */
static bool note_entry(tumble_history_t *history)
{
    const uint32_t at_cell = history->log.at_cell;
    tumble_history_entry_t entry;
    if (tumble_history_decode(history->bytes, &entry) != TUMBLE_OK) {
        return false;
    }
    history->valid[at_cell / TUMBLE_HISTORY_CELLS] |= UINT32_C(1) << (at_cell % TUMBLE_HISTORY_CELLS);
    if (entry.number > history->newest) {
        history->newest = entry.number;
        history->sequence = entry.sequence;
        history->sector = (uint8_t)(at_cell / TUMBLE_HISTORY_CELLS);
    }
    return true;
}

static void note_cell(tumble_history_t *history)
{
    if (!tumble_log_is_blank(&history->log, history->bytes)) {
        tumble_log_note(&history->log, history->log.was_read && note_entry(history));
    }
    tumble_log_next(&history->log, true);
}

static void begin_writing(tumble_history_t *history, uint32_t sector)
{
    const uint32_t at_cell = (sector * TUMBLE_HISTORY_CELLS) + history->log.used[sector];
    tumble_log_program(&history->log, (uint8_t)at_cell, history->bytes, JOB_WRITE);
}

static void go_on(tumble_history_t *history)
{
    if (history->log.job == (uint8_t)JOB_ERASE) {
        history->log.used[history->sector ^ 1U] = 0;
        begin_writing(history, history->sector ^ 1U);
        return;
    }
    tumble_log_note(&history->log, note_entry(history)); /* these are the bytes that append() made */
    tumble_log_end(&history->log);
}

TUMBLE_ONE_COPY tumble_status_t tumble_history_step(tumble_history_t *history)
{
    const tumble_log_event_t event = tumble_log_step(&history->log, history->bytes);
    if (event == TUMBLE_LOG_CELL) {
        note_cell(history);
    } else if (event == TUMBLE_LOG_DONE) {
        go_on(history);
    } else if (event == TUMBLE_LOG_FAILED) {
        forget(history);
    } else {
        /* it goes on at the next step */
    }
    return tumble_history_busy(history) ? TUMBLE_E_PORT_BUSY : history->log.outcome;
}

tumble_status_t tumble_history_append(tumble_history_t *history, const tumble_history_entry_t *entry)
{
    tumble_status_t status = tumble_log_ready(&history->log);
    if (status != TUMBLE_OK) {
        return status;
    }
    if (history->newest >= MAX_NUMBER) {
        return TUMBLE_E_STATE;
    }
    status = tumble_history_encode(entry, history->bytes);
    if (status != TUMBLE_OK) {
        return status;
    }
    if (history->log.unread) { /* a cell that could not be read may hold the newest entry: look again first */
        forget(history);
        tumble_log_scan(&history->log);
        return TUMBLE_E_NV;
    }
    tumble_history_number(history->bytes, history->newest + 1U);
    if (history->log.used[history->sector] < TUMBLE_HISTORY_CELLS) {
        begin_writing(history, history->sector);
    } else {
        const uint32_t other = (history->sector == 0U) ? 1U : 0U;
        history->valid[other] = 0;
        tumble_log_erase(&history->log, (uint8_t)other, JOB_ERASE);
    }
    return TUMBLE_OK;
}

uint8_t tumble_history_count(const tumble_history_t *history)
{
    uint32_t entries = 0;
    for (uint32_t bit = 0; !tumble_history_busy(history) && (bit < TUMBLE_HISTORY_CELLS); bit++) {
        entries += ((history->valid[0] >> bit) & 1U) + ((history->valid[1] >> bit) & 1U);
    }
    return (uint8_t)entries;
}

uint32_t tumble_history_sequence(const tumble_history_t *history)
{
    return history->sequence;
}

/* From the newest backwards through its sector, then from the end of the other. */
static uint8_t cell_of_age(const tumble_history_t *history, uint8_t age)
{
    uint32_t left = age;
    uint32_t sector = history->sector;
    uint32_t at = TUMBLE_HISTORY_CELLS - 1U;
    while ((left > 0U) || (((history->valid[sector] >> at) & 1U) == 0U)) {
        left -= (history->valid[sector] >> at) & 1U;
        sector ^= (at == 0U) ? 1U : 0U;
        at = ((at == 0U) ? TUMBLE_HISTORY_CELLS : at) - 1U;
    }
    return (uint8_t)((sector * TUMBLE_HISTORY_CELLS) + at);
}

tumble_status_t tumble_history_read(tumble_history_t *history, uint8_t age, tumble_history_entry_t *entry)
{
    if (tumble_history_busy(history)) {
        return TUMBLE_E_PORT_BUSY;
    }
    if ((entry == NULL) || (age >= tumble_history_count(history))) {
        return TUMBLE_E_ARGUMENT;
    }
    const tumble_status_t status = tumble_log_read(&history->log, cell_of_age(history, age), history->bytes);
    return (status == TUMBLE_OK) ? tumble_history_decode(history->bytes, entry) : status;
}
