/* memory.h - cells in the non-volatile memory, and the jobs that write them (private to the room, and to those who keep a
 * record in its memory).
 *
 * All that is kept lies in cells of one size: a set with its mark in a sector of its own, the entries of a log one behind
 * the other in two sectors. A scan reads cell by cell. A job is a plan, a row of actions: erase a sector, check that a cell
 * is blank, program the record and read it back, and only then program the mark behind it, in a granule of its own. So
 * whatever bytes a loss of power leaves in a cell that was being written, the cell is not valid.
 *
 * A step makes at most one call of the memory and returns what came of it. The owner knows what the cells mean.
 */
#ifndef TUMBLE_SETS_MEMORY_H
#define TUMBLE_SETS_MEMORY_H

#include "tumble/sets.h"

#include <stddef.h>

/* The actions: the upper half of a byte. The lower half is the place: which of cells->where. */
#define CELL_WHAT 0xF0U
#define CELL_WHERE 0x0FU
#define CELL_END 0x00U
#define CELL_ERASE 0x10U /* the sector of the cell */
#define CELL_BODY 0x20U  /* program the record */
#define CELL_MARK 0x30U  /* program the mark */
#define CELL_BLANK 0x40U /* refuse to go on where something stands */
#define CELL_LOAD 0x50U  /* read the cell: TUMBLE_CELLS_READ, and then it is the owner's turn */

typedef enum {
    TUMBLE_CELLS_NOTHING = 0, /* the memory is at work, the job goes on, or nothing is under way */
    TUMBLE_CELLS_READ,        /* of a scan: cells->at was read (was_read), or could not be: call tumble_cells_next */
    TUMBLE_CELLS_DONE,        /* the job is: nothing is under way */
    TUMBLE_CELLS_FAILED       /* it is not: all cells are looked at anew */
} tumble_cells_event_t;

/* Start the scan of all cells.
 * Returns TUMBLE_OK, or TUMBLE_E_ARGUMENT or TUMBLE_E_NV as tumble_regions_check: then nothing is ever under way, and the
 * outcome is TUMBLE_E_STATE. */
tumble_status_t tumble_cells_open(tumble_cells_t *cells, const tumble_cells_kind_t *kind, const tumble_nv_t *nv);
void tumble_cells_scan(tumble_cells_t *cells);

/* Go on with the scan at another cell. At kind->count, or beyond, it is over. */
void tumble_cells_next(tumble_cells_t *cells, uint32_t at);

/* Is the cell blank that was read? If not, and it is not `valid` either, it is torn. Torn cells count at the first scan
 * only: later ones are failed attempts, which have been counted. */
bool tumble_cells_is_blank(const tumble_cells_t *cells, const uint8_t *bytes);
void tumble_cells_note(tumble_cells_t *cells, bool valid);

/* May a job be begun? Returns TUMBLE_OK, TUMBLE_E_PORT_BUSY (something is under way), TUMBLE_E_STATE (it was not
 * opened). */
tumble_status_t tumble_cells_ready(const tumble_cells_t *cells);
void tumble_cells_begin(tumble_cells_t *cells, const uint8_t *plan);

/* Go on: at most one call of the memory. `bytes` take the cell that is read; the record and mark that are written must
 * stay in them. */
tumble_cells_event_t tumble_cells_step(tumble_cells_t *cells, uint8_t *bytes);

/* It is the owner's turn: the present action is done, or it has failed and so has the job. */
tumble_cells_event_t tumble_cells_pass(tumble_cells_t *cells);
tumble_cells_event_t tumble_cells_fail(tumble_cells_t *cells, tumble_status_t outcome);

/* One read. Returns TUMBLE_OK; TUMBLE_E_PORT_BUSY (ask again: the memory is at work, or it failed and kind->attempts
 * are left, which is counted); TUMBLE_E_NV (none is left; counted as well). */
tumble_status_t tumble_cells_read(tumble_cells_t *cells, uint32_t at, uint8_t *bytes);

static inline bool tumble_cells_busy(const tumble_cells_t *cells)
{
    return (cells->nv != NULL) && (cells->scans || (cells->plan != NULL));
}

#endif
