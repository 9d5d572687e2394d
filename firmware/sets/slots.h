/* slots.h - a record in a sector of its own, and behind it the mark that makes it valid (private to the room).
 *
 * A job is a plan, a row of actions: erase, check that the place is blank, program the record and read it back, and
 * only then program the mark, in a granule of its own. So whatever bytes a loss of power leaves in a place that was
 * being written, the place is not valid. A step makes at most one call of the memory. The owner knows which place an
 * action is about.
 */
#ifndef TUMBLE_SETS_SLOTS_H
#define TUMBLE_SETS_SLOTS_H

#include "tumble/sets.h"

/* The actions: the upper half of a byte; the lower half is the owner's. */
#define SLOT_END 0x00U
#define SLOT_ERASE 0x10U
#define SLOT_BODY 0x20U  /* program the record */
#define SLOT_MARK 0x30U  /* program the mark */
#define SLOT_BLANK 0x40U /* refuse to go on where something stands */
#define SLOT_OWN 0x50U   /* and those above: the owner's */

/* One read of a place. Returns TUMBLE_OK; TUMBLE_E_PORT_BUSY (ask again: the memory is at work, or it failed for the
 * first or second time in a row, which is counted); TUMBLE_E_NV (and for the third, which is counted as well). */
tumble_status_t tumble_slots_read(tumble_slots_t *slots, uint32_t offset, uint8_t *bytes, uint32_t *errors);

/* Begin a job; null: none is under way. */
void tumble_slots_begin(tumble_slots_t *slots, const uint8_t *plan);

/* The present action is the owner's, and done. Returns as tumble_slots_step. */
tumble_status_t tumble_slots_pass(tumble_slots_t *slots);

/* Go on with the present action, at a place; `bytes` hold record and mark. Returns TUMBLE_OK (the job is done),
 * TUMBLE_E_PORT_BUSY (step again), TUMBLE_E_NV (it has failed). */
tumble_status_t tumble_slots_step(tumble_slots_t *slots, uint32_t offset, const uint8_t *bytes);

#endif
