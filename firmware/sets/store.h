/* store.h - coefficient sets that survive loss of power: two slots, a factory set, and a proposal.
 *
 * Active is the set with the highest sequence in the two slots, and where neither holds one, the factory set. A new set
 * goes to the other slot: erase, look that it is blank, program the record, read back, and only then program the mark that
 * makes it valid, in a granule of its own. So at every instant either the set that was active is active, or the new one;
 * which bytes a loss of power leaves in what was being written does not matter (docs/store.md).
 *
 * Nothing waits: a job is begun, and tumble_store_step() makes at most one call of the memory. One job at a time, on one
 * memory: where a history or a checkpoint lies in the same memory, step one of them until it is not busy, then the next.
 * The caller owns the object; not re-entrant on one object.
 */
#ifndef TUMBLE_SETS_STORE_H
#define TUMBLE_SETS_STORE_H

#include "tumble/status.h"
#include "tumble/port.h"
#include "sets/nv_writer.h"
#include "sets/regions.h"
#include "sets/set_record.h"

#include <assert.h>
#include <stdbool.h>
#include <stdint.h>

#define TUMBLE_SET_MARK_BYTES 32U /* a cell for the mark behind the record */
#define TUMBLE_SET_PLACE_BYTES (TUMBLE_SET_BYTES + TUMBLE_SET_MARK_BYTES)
#define TUMBLE_FACTORY_PLACES 4U /* attempts to write the factory set; the first valid one counts */
#define TUMBLE_FACTORY_PITCH 512U
#define TUMBLE_MAX_SEQUENCE (UINT32_MAX - 1U) /* then commits are refused: a sequence never wraps */

typedef enum {
    TUMBLE_SET_ACTIVE = 0,
    TUMBLE_SET_FACTORY = 1,
    TUMBLE_SET_PROPOSAL = 2,
    TUMBLE_SET_PREVIOUS = 3 /* what a rollback would bring back: the other slot's set, or else the factory set */
} tumble_which_set_t;

/* Since init; they stop at UINT32_MAX instead of wrapping. */
typedef struct {
    uint32_t commits;      /* sets that became active: committed, accepted, rolled back */
    uint32_t verify;       /* what was read back differed from what the memory had confirmed */
    uint32_t nv_errors;    /* a call of the memory failed */
    uint32_t torn_at_boot; /* places that the first scan found neither blank nor holding a valid set */
} tumble_store_counters_t;

/* What the last scan found in a region. Private to the store, as all that follows. */
typedef struct {
    tumble_set_stamp_t stamp;
    uint32_t crc;
    bool valid;
} tumble_store_place_t;

typedef struct {
    tumble_nv_writer_t writer; /* without a memory: init has refused */
    tumble_store_counters_t counters;
    tumble_store_place_t places[4]; /* by region */
    tumble_set_stamp_t stamp;       /* of the record in `bytes` */
    const uint8_t *plan;            /* the actions that are left of the job; null: no job */
    tumble_status_t outcome;
    uint32_t sequence;     /* of the active set */
    uint32_t highest;      /* that one was known to have: of the active set, or told */
    uint8_t scanned;       /* places so far */
    uint8_t failed_reads;  /* in a row, of the place that is read */
    bool unread;           /* the last scan could not read a place: what is there must not be overwritten */
    uint8_t factory_place; /* where the factory set is, or else where it would go; TUMBLE_FACTORY_PLACES: nowhere */
    uint8_t target;        /* the slot that is being written */
    uint8_t source;        /* the region that a rollback copies */
    uint16_t flags;        /* further ones for the record that is loaded */
    bool begun;            /* the action is */
    bool booted;
    uint8_t bytes[TUMBLE_SET_PLACE_BYTES]; /* record and mark */
} tumble_store_t;

static_assert(sizeof(tumble_store_t) <= 768U, "the store must stay small");

/* Begin to look what is there, and to clear what a job left behind that lost its power; step until it is done: eight calls
 * of the memory, some more where there is something to clear. `nv` must stay.
 * Returns TUMBLE_OK, _ARGUMENT, _NV (tumble_regions_check); after a refusal the object answers every call with
 * TUMBLE_E_STATE and holds nothing. */
tumble_status_t tumble_store_init(tumble_store_t *store, const tumble_nv_t *nv);

/* Go on with what is under way: at most one call of the memory. TUMBLE_E_PORT_BUSY: call again. Else nothing is under
 * way, and the outcome of the last job is returned: TUMBLE_OK, or TUMBLE_E_NV (the memory failed or did not hold what it
 * confirmed: the set that was active is active still, or, in rare cases, the new one is; begin the job again), or
 * TUMBLE_E_CRC (what was to be copied is no longer valid). */
tumble_status_t tumble_store_step(tumble_store_t *store);

bool tumble_store_busy(const tumble_store_t *store);
tumble_status_t tumble_store_outcome(const tumble_store_t *store); /* as tumble_store_step, without a step */
const tumble_store_counters_t *tumble_store_counters(const tumble_store_t *store);

/* Is there such a set? By the last scan; false while busy. */
bool tumble_store_has(const tumble_store_t *store, tumble_which_set_t which);

/* The CRC-32 at the end of the proposal's record: its name; 0: there is none, or busy. By the last scan. */
uint32_t tumble_store_proposal(const tumble_store_t *store);

/* The sequence of the active set: the calibration counter, which grows with every set that becomes active by a job. 0:
 * the factory set, or none. Where the active set decays it goes back to that of the one before, and the next one that
 * becomes active gets a sequence that none had. Keeps its last value while busy. */
uint32_t tumble_store_sequence(const tumble_store_t *store);

/* Tell of a sequence that a set once had, say in the history: the next one that becomes active gets a higher one, even
 * where that set has decayed since. What is not below TUMBLE_MAX_SEQUENCE is not believed. */
void tumble_store_number_above(tumble_store_t *store, uint32_t sequence);

/* A set by value: one read and one check of its CRC; `*set` is written on TUMBLE_OK alone.
 * Returns TUMBLE_OK; _PORT_BUSY (a job is under way, or the memory is, or it failed for the first or second time in a
 * row: step, and ask again); _STATE (there is no such set); _ARGUMENT (null, or no such kind); and where the memory
 * cannot be read or has decayed since the last scan, _NV or as tumble_set_decode: then a scan is begun, after which the
 * next valid set is active. */
tumble_status_t tumble_store_read(tumble_store_t *store, tumble_which_set_t which, tumble_set_t *set);

/* The jobs. Each returns TUMBLE_OK (begun: step), or why it was not begun: _PORT_BUSY (one is under way), _STATE (see
 * there), _NV (a place could not be read, and may hold what is active: it is looked at anew, then begin again), and those that
 * take a set: _ARGUMENT or _NOT_FINITE (tumble_set_encode). The set is copied at once. */

/* Make a set active. _STATE: the sequence has reached TUMBLE_MAX_SEQUENCE. */
tumble_status_t tumble_store_commit(tumble_store_t *store, const tumble_set_t *set);

/* Keep a set as the proposal, in place of one that is held. Power lost on the way may lose both proposals.
 * _STATE: as tumble_store_commit. */
tumble_status_t tumble_store_hold(tumble_store_t *store, const tumble_set_t *set);

/* Make the proposal active, then clear it. _STATE: there is none, or as tumble_store_commit. */
tumble_status_t tumble_store_accept(tumble_store_t *store);

/* The same, and the set that becomes active gets these flags (TUMBLE_SET_...) besides those of the proposal. */
tumble_status_t tumble_store_accept_as(tumble_store_t *store, uint16_t flags);

/* Clear the proposal. _STATE: there is none. */
tumble_status_t tumble_store_discard(tumble_store_t *store);

/* Make the previous set active again, as a copy with a new sequence, and clear the slot of the one that was active. The
 * copy is staged as the proposal, so a proposal must be accepted or discarded before. After a loss of power on the way
 * either the copy is active, or nothing has changed, or the copy is the proposal: then a rollback, or an accept, goes on
 * with it, and a discard gives it up. _STATE: nothing to go back to (the factory set, or a copy of it, is active, or
 * there is none), a proposal is held, or as tumble_store_commit. */
tumble_status_t tumble_store_rollback(tumble_store_t *store);

/* Write the factory set. _STATE: there is one, or all TUMBLE_FACTORY_PLACES attempts are spent. */
tumble_status_t tumble_store_write_factory(tumble_store_t *store, const tumble_set_t *set);

#endif
