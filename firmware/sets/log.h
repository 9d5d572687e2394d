/* log.h - cells of one size in two sectors, written one behind the other (private to the room).
 *
 * A log scans its cells, erases a sector, programs a cell and reads it back; its owner knows what the cells mean. A
 * step makes at most one call of the memory and returns its outcome: a cell was read, or a job is done. Then the owner
 * goes on with the next cell, with the next job of its plan, or not at all.
 */
#ifndef TUMBLE_SETS_LOG_H
#define TUMBLE_SETS_LOG_H

#include "tumble/sets.h"

/* tumble_log_t.job: what is under way; further ones are the owner's. */
enum { TUMBLE_LOG_IDLE = 0, TUMBLE_LOG_SCANNING = 1, TUMBLE_LOG_OWN = 2 };

typedef enum {
    TUMBLE_LOG_NOTHING = 0, /* the memory is at work, or nothing is under way */
    TUMBLE_LOG_CELL,        /* log->at_cell was read (was_read), or could not be: call tumble_log_next */
    TUMBLE_LOG_DONE,        /* log->job is: begin another one, or call tumble_log_end */
    TUMBLE_LOG_FAILED       /* it is not: all cells are looked at anew */
} tumble_log_event_t;

/* Returns TUMBLE_OK (the scan of all cells has begun), or TUMBLE_E_ARGUMENT or TUMBLE_E_NV as tumble_regions_check:
 * then nothing is ever under way, and the outcome is TUMBLE_E_STATE. */
tumble_status_t tumble_log_open(tumble_log_t *log, const tumble_log_kind_t *kind, const tumble_nv_t *nv);

/* Start the scan of all cells. */
void tumble_log_scan(tumble_log_t *log);

/* Is this cell blank? If not, note it: the next entry goes behind it. `valid`: it holds an entry; otherwise it is
 * torn. */
bool tumble_log_is_blank(const tumble_log_t *log, const uint8_t *bytes);
void tumble_log_note(tumble_log_t *log, bool valid);

/* Go on to the next cell. Without `more`, or behind the last cell, the scan is over. */
void tumble_log_next(tumble_log_t *log, bool more);

/* Begin a job of the owner's: erase a sector (0 or 1), or program `bytes`, which must stay, into a cell (counted
 * through both sectors). */
void tumble_log_erase(tumble_log_t *log, uint8_t sector, uint8_t job);
void tumble_log_program(tumble_log_t *log, uint8_t at_cell, const uint8_t *bytes, uint8_t job);

/* The last job of a plan is done: now nothing is under way, and the outcome is TUMBLE_OK. */
void tumble_log_end(tumble_log_t *log);

/* Go on: at most one call of the memory. A cell is read into `bytes`. */
tumble_log_event_t tumble_log_step(tumble_log_t *log, uint8_t *bytes);

/* One read. Returns TUMBLE_OK, TUMBLE_E_PORT_BUSY, TUMBLE_E_NV. */
tumble_status_t tumble_log_read(const tumble_log_t *log, uint8_t at_cell, uint8_t *bytes);

/* May a job be begun? Returns TUMBLE_OK, TUMBLE_E_PORT_BUSY (one is under way), TUMBLE_E_STATE (it was not opened). */
tumble_status_t tumble_log_ready(const tumble_log_t *log);

static inline bool tumble_log_busy(const tumble_log_t *log)
{
    return log->job != (uint8_t)TUMBLE_LOG_IDLE;
}

#endif
