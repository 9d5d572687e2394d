/* store_job.h - what the store is doing (private to the room): store.c answers and begins jobs, store_job.c does
 * them. */
#ifndef TUMBLE_SETS_STORE_JOB_H
#define TUMBLE_SETS_STORE_JOB_H

#include "sets/set_record.h"
#include "sets/slots.h"

#define NO_REGION 0xFFU

/* Actions of a job that are the store's own. */
#define PLAN_LOAD (SLOT_OWN)          /* read a record and put the job's stamp on it */
#define PLAN_STAMP (SLOT_OWN + 0x10U) /* the staged copy becomes the one to be committed */

/* Where. */
#define IN_FACTORY 0x00U
#define IN_TARGET 0x01U /* the slot that is not active */
#define IN_OTHER 0x02U  /* the slot that was active when the job began */
#define IN_PROPOSAL 0x03U
#define IN_SOURCE 0x04U /* what a rollback brings back */

/* The region of the active set, and of the one that a rollback would bring back; NO_REGION: none. */
uint8_t tumble_store_active(const tumble_store_t *store);
uint8_t tumble_store_previous(const tumble_store_t *store);

/* Is the proposal active already, and has only not been cleared yet? */
bool tumble_store_is_stale(const tumble_store_t *store);

/* Where the record of a region begins in the memory. */
uint32_t tumble_store_place(const tumble_store_t *store, uint8_t region);

/* The mark behind the record in `bytes`: put it there, and is it there? */
void tumble_store_set_mark(uint8_t bytes[TUMBLE_SET_PLACE_BYTES]);
bool tumble_store_is_marked(const uint8_t bytes[TUMBLE_SET_PLACE_BYTES]);

/* Start a scan of all places, which the next steps make; the boot scan (`booted` is not set yet) then clears
 * leftovers. */
void tumble_store_begin_scan(tumble_store_t *store);

/* Slots by their region. */
static inline uint8_t tumble_store_other_slot(uint8_t slot)
{
    return (slot == (uint8_t)TUMBLE_REGION_SLOT_A) ? (uint8_t)TUMBLE_REGION_SLOT_B : (uint8_t)TUMBLE_REGION_SLOT_A;
}

static inline bool tumble_store_is_slot(uint8_t region)
{
    return (region == (uint8_t)TUMBLE_REGION_SLOT_A) || (region == (uint8_t)TUMBLE_REGION_SLOT_B);
}

#endif
