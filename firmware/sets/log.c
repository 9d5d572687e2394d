#include "sets/log.h"

#include "core/count.h"
#include "core/one_copy.h"
#include "sets/nv_writer.h"

#include <stddef.h>

#define SECTORS 2U

static uint32_t offset_of(const tumble_log_t *log, uint32_t at_cell)
{
    const tumble_log_kind_t *kind = log->kind;
    const uint32_t sector = kind->region + (at_cell / kind->cells);
    return (sector * log->writer.nv->sector_bytes) + ((at_cell % kind->cells) * kind->cell_bytes);
}

tumble_status_t tumble_log_open(tumble_log_t *log, const tumble_log_kind_t *kind, const tumble_nv_t *nv)
{
    *log = (tumble_log_t){.kind = kind, .outcome = TUMBLE_E_STATE};
    const tumble_status_t status = tumble_nv_writer_open(&log->writer, nv);
    if (status == TUMBLE_OK) {
        log->outcome = TUMBLE_OK;
        tumble_log_scan(log);
    }
    return status;
}

void tumble_log_scan(tumble_log_t *log)
{
    log->used[0] = 0;
    log->used[1] = 0;
    log->at_cell = 0;
    log->unread = false;
    log->job = TUMBLE_LOG_SCANNING;
}

bool tumble_log_is_blank(const tumble_log_t *log, const uint8_t *bytes)
{
    return log->was_read && tumble_nv_is_blank(bytes, log->kind->cell_bytes);
}

/* Torn cells count at the boot scan only: later ones are failed attempts, which have been counted. */
void tumble_log_note(tumble_log_t *log, bool valid)
{
    const uint8_t cells = log->kind->cells;
    log->used[log->at_cell / cells] = (uint8_t)((log->at_cell % cells) + 1U);
    if (!valid && !log->booted) {
        tumble_count(&log->torn);
    }
}

TUMBLE_ONE_COPY void tumble_log_next(tumble_log_t *log, bool more)
{
    log->at_cell++;
    if (!more || (log->at_cell == (SECTORS * log->kind->cells))) {
        log->booted = true;
        log->job = TUMBLE_LOG_IDLE;
    }
}

void tumble_log_erase(tumble_log_t *log, uint8_t sector, uint8_t job)
{
    tumble_nv_begin_erase(&log->writer, offset_of(log, (uint32_t)sector * log->kind->cells), TUMBLE_STORE_MIN_SECTOR);
    log->job = job;
}

void tumble_log_program(tumble_log_t *log, uint8_t at_cell, const uint8_t *bytes, uint8_t job)
{
    tumble_nv_begin_program(&log->writer, offset_of(log, at_cell), bytes, log->kind->cell_bytes);
    log->at_cell = at_cell;
    log->job = job;
}

void tumble_log_end(tumble_log_t *log)
{
    log->outcome = TUMBLE_OK;
    log->job = TUMBLE_LOG_IDLE;
}

static tumble_log_event_t look(tumble_log_t *log, uint8_t *bytes)
{
    const tumble_status_t status = tumble_log_read(log, log->at_cell, bytes);
    if (status == TUMBLE_E_PORT_BUSY) {
        return TUMBLE_LOG_NOTHING;
    }
    log->was_read = (status == TUMBLE_OK);
    if (!log->was_read) {
        tumble_count(&log->nv_errors);
        log->unread = true;
    }
    return TUMBLE_LOG_CELL;
}

static tumble_log_event_t write_on(tumble_log_t *log)
{
    const tumble_status_t status = tumble_nv_writer_step(&log->writer);
    if (status == TUMBLE_E_PORT_BUSY) {
        return TUMBLE_LOG_NOTHING;
    }
    if (status == TUMBLE_OK) {
        return TUMBLE_LOG_DONE;
    }
    tumble_count(log->writer.failed_to_hold ? &log->verify : &log->nv_errors);
    log->outcome = status;
    tumble_log_scan(log);
    return TUMBLE_LOG_FAILED;
}

tumble_log_event_t tumble_log_step(tumble_log_t *log, uint8_t *bytes)
{
    if (!tumble_log_busy(log)) {
        return TUMBLE_LOG_NOTHING;
    }
    return (log->job == (uint8_t)TUMBLE_LOG_SCANNING) ? look(log, bytes) : write_on(log);
}

tumble_status_t tumble_log_read(const tumble_log_t *log, uint8_t at_cell, uint8_t *bytes)
{
    return tumble_nv_read(log->writer.nv, offset_of(log, at_cell), bytes, log->kind->cell_bytes);
}

tumble_status_t tumble_log_ready(const tumble_log_t *log)
{
    if (tumble_log_busy(log)) {
        return TUMBLE_E_PORT_BUSY;
    }
    return (log->writer.nv != NULL) ? TUMBLE_OK : TUMBLE_E_STATE;
}
