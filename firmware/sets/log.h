/* log.h - cells of one size in two sectors, written one behind the other (private to the room).
 *
 * A log looks through its cells, erases a sector, programs a cell and reads it back: what that means is its owner's to
 * know. A step makes at most one call of the memory, and returns what has come of it: a cell was looked at, a job is done.
 * Then the owner goes on: with the next cell, with the next job of the plan, or not at all.
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

/* Returns TUMBLE_OK: look through all cells; or TUMBLE_E_ARGUMENT or TUMBLE_E_NV as tumble_regions_check: then nothing is
 * ever under way, and TUMBLE_E_STATE the outcome. */
tumble_status_t tumble_log_open(tumble_log_t *log, const tumble_log_kind_t *kind, const tumble_nv_t *nv);

/* Look through all cells. */
void tumble_log_scan(tumble_log_t *log);

/* A cell is blank; or it holds something, and the next entry goes behind it; `valid`: or is torn. */
bool tumble_log_is_blank(const tumble_log_t *log, const uint8_t *bytes);
void tumble_log_note(tumble_log_t *log, bool valid);

/* On to the next cell; without `more`, or behind the last one, the look through them is over. */
void tumble_log_next(tumble_log_t *log, bool more);

/* Begin a job of the owner's: erase a sector (0 or 1), or program `bytes`, which must stay, into a cell (counted through
 * both sectors). */
void tumble_log_erase(tumble_log_t *log, uint8_t sector, uint8_t job);
void tumble_log_program(tumble_log_t *log, uint8_t at_cell, const uint8_t *bytes, uint8_t job);

/* The last job of a plan is done: nothing is under way, and the outcome is TUMBLE_OK. */
void tumble_log_end(tumble_log_t *log);

/* Go on; a cell is read to `bytes`. */
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
