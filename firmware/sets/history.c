#include "sets/history.h"

#include "sets/record.h"

#include <stddef.h>
#include <string.h>

enum { PHASE_IDLE = 0, PHASE_SCANNING, PHASE_ERASING, PHASE_WRITING };

#define SECTORS 2U
#define MAX_NUMBER (UINT32_MAX - 1U)

static_assert(TUMBLE_HISTORY_CELLS == 32U, "the valid cells of a sector are the bits of one word");

static uint32_t offset_of(const tumble_history_t *history, uint32_t sector, uint32_t at)
{
    return (((uint32_t)TUMBLE_REGION_HISTORY + sector) * history->writer.nv->sector_bytes) + (at * TUMBLE_HISTORY_BYTES);
}

static void count(uint32_t *counter)
{
    *counter += (*counter < UINT32_MAX) ? 1U : 0U;
}

static void begin_scan(tumble_history_t *history)
{
    (void)memset(history->valid, 0, sizeof history->valid);
    (void)memset(history->used, 0, sizeof history->used);
    history->newest = 0;
    history->sequence = 0;
    history->sector = 0;
    history->scanned = 0;
    history->unread = false;
    history->phase = PHASE_SCANNING;
}

tumble_status_t tumble_history_init(tumble_history_t *history, const tumble_nv_t *nv)
{
    if (history == NULL) {
        return TUMBLE_E_ARGUMENT;
    }
    *history = (tumble_history_t){.outcome = TUMBLE_E_STATE};
    const tumble_status_t status = tumble_nv_writer_open(&history->writer, nv);
    if (status == TUMBLE_OK) {
        history->outcome = TUMBLE_OK;
        begin_scan(history);
    }
    return status;
}

bool tumble_history_busy(const tumble_history_t *history)
{
    return history->phase != (uint8_t)PHASE_IDLE;
}

static void note_valid(tumble_history_t *history, uint32_t sector, uint32_t at,
                       const tumble_history_entry_t *entry)
{
    history->valid[sector] |= UINT32_C(1) << at;
    if (entry->number > history->newest) {
        history->newest = entry->number;
        history->sequence = entry->sequence;
        history->sector = (uint8_t)sector;
    }
}

static void note_cell(tumble_history_t *history, bool was_read)
{
    const uint32_t sector = history->scanned / TUMBLE_HISTORY_CELLS;
    const uint32_t at = history->scanned % TUMBLE_HISTORY_CELLS;
    tumble_history_entry_t entry;
    if (was_read && tumble_nv_is_blank(history->bytes, TUMBLE_HISTORY_BYTES)) {
        return;
    }
    history->used[sector] = (uint8_t)(at + 1U);
    if (was_read && (tumble_history_decode(history->bytes, &entry) == TUMBLE_OK)) {
        note_valid(history, sector, at, &entry);
    } else if (!history->booted) {
        count(&history->torn);
    } else {
        /* an attempt that failed, and was counted as such */
    }
}

static void scan(tumble_history_t *history)
{
    const uint32_t sector = history->scanned / TUMBLE_HISTORY_CELLS;
    const uint32_t offset = offset_of(history, sector, history->scanned % TUMBLE_HISTORY_CELLS);
    const tumble_status_t status = tumble_nv_read(history->writer.nv, offset, history->bytes, TUMBLE_HISTORY_BYTES);
    if (status == TUMBLE_E_PORT_BUSY) {
        return;
    }
    if (status != TUMBLE_OK) {
        count(&history->nv_errors);
        history->unread = true;
    }
    note_cell(history, status == TUMBLE_OK);
    history->scanned++;
    if (history->scanned == (SECTORS * TUMBLE_HISTORY_CELLS)) {
        history->booted = true;
        history->phase = PHASE_IDLE;
    }
}

static void begin_writing(tumble_history_t *history)
{
    const uint32_t offset = offset_of(history, history->sector, history->used[history->sector]);
    tumble_nv_begin_program(&history->writer, offset, history->bytes, TUMBLE_HISTORY_BYTES);
    history->phase = PHASE_WRITING;
}

static void end_erasing(tumble_history_t *history)
{
    history->sector = (history->sector == 0U) ? 1U : 0U;
    history->used[history->sector] = 0;
    begin_writing(history);
}

static void end_writing(tumble_history_t *history)
{
    tumble_history_entry_t entry;
    (void)tumble_history_decode(history->bytes, &entry); /* these are the bytes that append() made */
    note_valid(history, history->sector, history->used[history->sector], &entry);
    history->used[history->sector]++;
    history->outcome = TUMBLE_OK;
    history->phase = PHASE_IDLE;
}

static void write_on(tumble_history_t *history)
{
    const tumble_status_t status = tumble_nv_writer_step(&history->writer);
    if (status == TUMBLE_E_NV) {
        count(history->writer.failed_to_hold ? &history->verify : &history->nv_errors);
        history->outcome = status;
        begin_scan(history);
    } else if (status == TUMBLE_E_PORT_BUSY) {
        /* it goes on at the next step */
    } else if (history->phase == (uint8_t)PHASE_ERASING) {
        end_erasing(history);
    } else {
        end_writing(history);
    }
}

tumble_status_t tumble_history_step(tumble_history_t *history)
{
    if (history->phase == (uint8_t)PHASE_SCANNING) {
        scan(history);
    } else if (history->phase != (uint8_t)PHASE_IDLE) {
        write_on(history);
    } else {
        /* nothing is under way */
    }
    return tumble_history_busy(history) ? TUMBLE_E_PORT_BUSY : history->outcome;
}

tumble_status_t tumble_history_append(tumble_history_t *history, const tumble_history_entry_t *entry)
{
    if (tumble_history_busy(history)) {
        return TUMBLE_E_PORT_BUSY;
    }
    if ((history->writer.nv == NULL) || (history->newest >= MAX_NUMBER)) {
        return TUMBLE_E_STATE;
    }
    const tumble_status_t status = tumble_history_encode(entry, history->bytes);
    if (status != TUMBLE_OK) {
        return status;
    }
    if (history->unread) { /* a cell that could not be read may hold the newest entry: look again first */
        begin_scan(history);
        return TUMBLE_E_NV;
    }
    tumble_history_number(history->bytes, history->newest + 1U);
    if (history->used[history->sector] < TUMBLE_HISTORY_CELLS) {
        begin_writing(history);
    } else {
        const uint32_t other = (history->sector == 0U) ? 1U : 0U;
        history->valid[other] = 0;
        tumble_nv_begin_erase(&history->writer, offset_of(history, other, 0), TUMBLE_STORE_MIN_SECTOR);
        history->phase = PHASE_ERASING;
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
static uint32_t offset_of_age(const tumble_history_t *history, uint8_t age)
{
    uint32_t left = age;
    uint32_t sector = history->sector;
    uint32_t at = TUMBLE_HISTORY_CELLS - 1U;
    while ((left > 0U) || (((history->valid[sector] >> at) & 1U) == 0U)) {
        left -= (history->valid[sector] >> at) & 1U;
        sector ^= (at == 0U) ? 1U : 0U;
        at = ((at == 0U) ? TUMBLE_HISTORY_CELLS : at) - 1U;
    }
    return offset_of(history, sector, at);
}

tumble_status_t tumble_history_read(tumble_history_t *history, uint8_t age, tumble_history_entry_t *entry)
{
    if (tumble_history_busy(history)) {
        return TUMBLE_E_PORT_BUSY;
    }
    if ((entry == NULL) || (age >= tumble_history_count(history))) {
        return TUMBLE_E_ARGUMENT;
    }
    const tumble_status_t status =
        tumble_nv_read(history->writer.nv, offset_of_age(history, age), history->bytes, TUMBLE_HISTORY_BYTES);
    return (status == TUMBLE_OK) ? tumble_history_decode(history->bytes, entry) : status;
}
