/* parameters.h - values that were written over CAN and shall outlast a loss of power (1010h, 1011h).
 *
 * The values of the objects that the generator lists (tumble_keeper_saved), as SDO carries them, in one record in two
 * sectors that take turns (TUMBLE_REGION_PARAMETERS). Little endian:
 *
 *       0  magic "TPAR"    4  schema u16, 1    6  bytes of values u16    8  sequence u32
 *      12  values: index u16, count u8, and for each subindex from 1 on its size u8 and its bytes
 *     284  CRC-32 of all before    288  mark: "TPARGOOD" four times, programmed when the rest has been read back
 *
 * The record with the higher sequence is in force. Without a record the board's own values are in force, and also with
 * a record that holds no values: that is how saved values are forgotten. Values that were read are written through the
 * dictionary, under its limits; those that it refuses are counted. Nothing waits: a call begins a job, and each step
 * makes at most one call of the memory. The keeper ensures that only one job runs on the memory at a time. So the
 * record lies in the bytes of the store, whose jobs end before one of the parameters goes on. What is read is used in the
 * same step. What is to be written must stay: the store has lent its bytes for so long, and reads no set. Not re-entrant
 * on one object.
 */
#ifndef TUMBLE_NAVCOMP_PARAMETERS_H
#define TUMBLE_NAVCOMP_PARAMETERS_H

#include "canopen/node.h"
#include "tumble/port.h"
#include "tumble/sets.h"
#include "tumble/status.h"

#include <assert.h>
#include <stdbool.h>
#include <stdint.h>

#define TUMBLE_REGION_PARAMETERS ((uint32_t)TUMBLE_REGION_COUNT) /* and the sector behind it */
#define TUMBLE_PARAMETERS_BYTES 320U
static_assert(TUMBLE_PARAMETERS_BYTES <= TUMBLE_SET_PLACE_BYTES, "the record must fit the bytes of the store");

typedef struct {
    uint32_t sequence; /* of the record in force: how often something was saved or forgotten; 0: never */
    uint32_t refused;  /* values of it that the dictionary refused */
    uint32_t applied;  /* values of it that are in force */
} tumble_parameters_view_t;

/* tumble_parameters_t.event */
enum {
    TUMBLE_PARAMETERS_NOTHING = 0,
    TUMBLE_PARAMETERS_APPLIED, /* what was saved is in force: some of it */
    TUMBLE_PARAMETERS_WRITTEN  /* saved, or forgotten */
};

/* Private but for `view` and `event`, which the owner sets back. */
typedef struct {
    uint8_t event;
    uint8_t slot;   /* 0 or 1: where the record in force is */
    uint8_t looked; /* records read so far: the two, and the better one again */
    bool failed;    /* a job: it is being looked what that left behind */
    bool again;     /* to be restored when that is done which is under way */
    tumble_node_t *node;
    tumble_store_t *store; /* its `bytes` hold the record */
    tumble_parameters_view_t view;
    tumble_cells_t cells; /* without a memory: there is no room for parameters */
} tumble_parameters_t;

/* Get ready and begin to read what was saved. If the memory lacks the two sectors (or is null), nothing can be saved.
 * `node` with its dictionary must be ready, and `store` be initialised with the same memory. */
void tumble_parameters_init(tumble_parameters_t *parameters, const tumble_nv_t *nv, tumble_node_t *node,
                            tumble_store_t *store);

/* Is there room for them? */
bool tumble_parameters_room(const tumble_parameters_t *parameters);

/* Read what was saved again and put it in force, after a reset to the board's own values. While busy this waits its
 * turn. */
void tumble_parameters_restore(tumble_parameters_t *parameters);

/* What was saved is not in force yet: it is being read, or about to be. */
bool tumble_parameters_reading(const tumble_parameters_t *parameters);

/* Begin to save the present values, or to forget what was saved. The SDO server is told the answer at the end
 * (tumble_node_answer).
 * Returns TUMBLE_ABORT_LATER (begun); TUMBLE_ABORT_HARDWARE (no room, or a record could not be read, until restored);
 * TUMBLE_ABORT_DEVICE_STATE (busy). */
tumble_abort_t tumble_parameters_save(tumble_parameters_t *parameters);
tumble_abort_t tumble_parameters_forget(tumble_parameters_t *parameters);

/* Go on: at most one call of the memory. */
void tumble_parameters_step(tumble_parameters_t *parameters);
bool tumble_parameters_busy(const tumble_parameters_t *parameters);

#endif
