#include "sets/memory.h"

#include "core/count.h"
#include "core/one_copy.h"

#include <string.h>

#define BLANK 0xFFU

static bool is_granule(uint32_t bytes)
{
    return (bytes != 0U) && (bytes <= TUMBLE_NV_MAX_GRANULE) && ((bytes & (bytes - 1U)) == 0U);
}

tumble_status_t tumble_regions_check(const tumble_nv_t *nv)
{
    if ((nv == NULL) || (nv->erase == NULL) || (nv->program == NULL) || (nv->read == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    const bool fits = (nv->sector_bytes >= TUMBLE_STORE_MIN_SECTOR) && is_granule(nv->granule_bytes) &&
                      ((nv->sector_bytes % nv->granule_bytes) == 0U) &&
                      ((nv->size_bytes / nv->sector_bytes) >= (uint32_t)TUMBLE_REGION_COUNT);
    return fits ? TUMBLE_OK : TUMBLE_E_NV;
}

static uint32_t offset_of(const tumble_cells_t *cells, uint32_t at)
{
    const tumble_cells_kind_t *kind = cells->kind;
    const uint32_t sector = kind->region + (at / kind->per_sector);
    return (sector * cells->nv->sector_bytes) + ((at % kind->per_sector) * kind->pitch);
}

static bool is_blank(const uint8_t *bytes, uint32_t size)
{
    bool blank = true;
    for (uint32_t i = 0; i < size; i++) {
        blank = blank && (bytes[i] == BLANK);
    }
    return blank;
}

/* Whatever a port answers beyond TUMBLE_OK and TUMBLE_E_PORT_BUSY is TUMBLE_E_NV. */
static tumble_status_t known(tumble_status_t status)
{
    return ((status == TUMBLE_OK) || (status == TUMBLE_E_PORT_BUSY)) ? status : TUMBLE_E_NV;
}

static tumble_status_t read_nv(const tumble_nv_t *nv, uint32_t offset, uint8_t *bytes, uint32_t size)
{
    return known(nv->read(nv->context, offset, bytes, size));
}

/* The scan. */

tumble_status_t tumble_cells_open(tumble_cells_t *cells, const tumble_cells_kind_t *kind, const tumble_nv_t *nv)
{
    const tumble_status_t status = tumble_regions_check(nv);
    *cells = (tumble_cells_t){.kind = kind, .outcome = TUMBLE_E_STATE};
    if (status == TUMBLE_OK) {
        cells->nv = nv;
        cells->outcome = TUMBLE_OK;
        tumble_cells_scan(cells);
    }
    return status;
}

void tumble_cells_scan(tumble_cells_t *cells)
{
    cells->at = 0;
    cells->scans = true;
    cells->unread = false;
    cells->failed_reads = 0;
}

void tumble_cells_next(tumble_cells_t *cells, uint32_t at)
{
    cells->at = (uint8_t)at;
    cells->scans = (at < cells->kind->count);
    cells->booted = cells->booted || !cells->scans;
}

bool tumble_cells_is_blank(const tumble_cells_t *cells, const uint8_t *bytes)
{
    return cells->was_read && is_blank(bytes, cells->kind->bytes);
}

void tumble_cells_note(tumble_cells_t *cells, bool valid)
{
    if (!valid && !cells->booted) {
        tumble_count(&cells->torn);
    }
}

/* Otherwise a memory that fails now and then would lose what it holds. */
tumble_status_t tumble_cells_read(tumble_cells_t *cells, uint32_t at, uint8_t *bytes)
{
    const tumble_status_t status = read_nv(cells->nv, offset_of(cells, at), bytes, cells->kind->bytes);
    if (status == TUMBLE_E_NV) {
        tumble_count(&cells->nv_errors);
        cells->failed_reads++;
        if (cells->failed_reads < cells->kind->attempts) {
            return TUMBLE_E_PORT_BUSY;
        }
    }
    if (status != TUMBLE_E_PORT_BUSY) {
        cells->failed_reads = 0;
    }
    return status;
}

static tumble_cells_event_t look(tumble_cells_t *cells, uint8_t *bytes)
{
    const tumble_status_t status = tumble_cells_read(cells, cells->at, bytes);
    if (status == TUMBLE_E_PORT_BUSY) {
        return TUMBLE_CELLS_NOTHING;
    }
    cells->was_read = (status == TUMBLE_OK);
    cells->unread = cells->unread || !cells->was_read;
    return TUMBLE_CELLS_READ;
}

/* A job. */

tumble_status_t tumble_cells_ready(const tumble_cells_t *cells)
{
    if (tumble_cells_busy(cells)) {
        return TUMBLE_E_PORT_BUSY;
    }
    return (cells->nv != NULL) ? TUMBLE_OK : TUMBLE_E_STATE;
}

void tumble_cells_begin(tumble_cells_t *cells, const uint8_t *plan)
{
    cells->plan = plan;
    cells->changes = ((*plan & CELL_WHAT) != CELL_BLANK);
    cells->checked = 0;
    cells->failed_to_hold = false;
}

tumble_cells_event_t tumble_cells_pass(tumble_cells_t *cells)
{
    tumble_cells_begin(cells, &cells->plan[1]);
    if (*cells->plan != CELL_END) {
        return TUMBLE_CELLS_NOTHING;
    }
    cells->plan = NULL;
    cells->outcome = TUMBLE_OK;
    return TUMBLE_CELLS_DONE;
}

tumble_cells_event_t tumble_cells_fail(tumble_cells_t *cells, tumble_status_t outcome)
{
    if (outcome == TUMBLE_E_NV) {
        tumble_count(cells->failed_to_hold ? &cells->verify : &cells->nv_errors);
    }
    cells->plan = NULL;
    cells->outcome = outcome;
    tumble_cells_scan(cells);
    return TUMBLE_CELLS_FAILED;
}

/* What the present action programs, and where. */
typedef struct {
    const uint8_t *bytes; /* null: it is to be blank */
    uint32_t offset;
    uint32_t size;
} action_t;

static action_t action_of(const tumble_cells_t *cells, const uint8_t *bytes)
{
    const tumble_cells_kind_t *kind = cells->kind;
    const unsigned what = *cells->plan & CELL_WHAT;
    action_t action = {NULL, offset_of(cells, cells->where[*cells->plan & CELL_WHERE]), kind->bytes};
    if (what == CELL_ERASE) {
        action.size = kind->erased_bytes;
    } else if (what == CELL_BODY) {
        action.bytes = bytes;
        action.size = kind->record_bytes;
    } else if (what == CELL_MARK) {
        action.bytes = &bytes[kind->record_bytes];
        action.offset += kind->record_bytes;
        action.size -= kind->record_bytes;
    } else {
        /* only check that it is blank */
    }
    return action;
}

static tumble_status_t change(tumble_cells_t *cells, const action_t *action)
{
    const tumble_nv_t *nv = cells->nv;
    const tumble_status_t status =
        known((action->bytes == NULL) ? nv->erase(nv->context, action->offset)
                                      : nv->program(nv->context, action->offset, action->bytes, action->size));
    cells->changes = (status != TUMBLE_OK);
    return (status == TUMBLE_OK) ? TUMBLE_E_PORT_BUSY : status;
}

/* Read back a part of what was erased or programmed. */
static tumble_status_t check(tumble_cells_t *cells, const action_t *action)
{
    const uint32_t left = action->size - cells->checked;
    const uint32_t size = (left < TUMBLE_NV_CHUNK) ? left : TUMBLE_NV_CHUNK;
    const tumble_status_t status = read_nv(cells->nv, action->offset + cells->checked, cells->chunk, size);
    if (status != TUMBLE_OK) {
        return status;
    }
    cells->failed_to_hold = (action->bytes == NULL) ? !is_blank(cells->chunk, size)
                                                    : (memcmp(cells->chunk, &action->bytes[cells->checked], size) != 0);
    if (cells->failed_to_hold) {
        return TUMBLE_E_NV;
    }
    cells->checked = (uint16_t)(cells->checked + size);
    return (cells->checked == action->size) ? TUMBLE_OK : TUMBLE_E_PORT_BUSY;
}

TUMBLE_ONE_COPY tumble_cells_event_t tumble_cells_step(tumble_cells_t *cells, uint8_t *bytes)
{
    if (!tumble_cells_busy(cells)) {
        return TUMBLE_CELLS_NOTHING;
    }
    if (cells->scans) {
        return look(cells, bytes);
    }
    const action_t action = action_of(cells, bytes);
    const bool loads = ((*cells->plan & CELL_WHAT) == CELL_LOAD);
    tumble_status_t status;
    if (loads) {
        status = read_nv(cells->nv, action.offset, bytes, action.size);
    } else {
        status = cells->changes ? change(cells, &action) : check(cells, &action);
    }
    if (status == TUMBLE_E_PORT_BUSY) {
        return TUMBLE_CELLS_NOTHING;
    }
    if (status != TUMBLE_OK) {
        return tumble_cells_fail(cells, status);
    }
    return loads ? TUMBLE_CELLS_READ : tumble_cells_pass(cells);
}
