/* checkpoint.h - the finished positions of a run, kept as they come, so that it can go on after a loss of power.
 *
 * A log: a header with the fingerprint of the run, then one entry a position. The fingerprint is the application's: CRC-32
 * over all that must not have changed (stand, block, schedule, configuration, and the sequence of the active set, so that
 * the checkpoint of a run that ended in a commit is not taken up again). The CRC of every entry covers it too.
 * Jobs as in store.h: begin, then step; at most one call of the memory a step.
 */
#ifndef TUMBLE_SETS_CHECKPOINT_H
#define TUMBLE_SETS_CHECKPOINT_H

#include "tumble/core.h"
#include "tumble/port.h"
#include "sets/nv_writer.h"
#include "sets/regions.h"

#include <stdbool.h>
#include <stdint.h>

#define TUMBLE_CHECKPOINT_BYTES 64U
#define TUMBLE_CHECKPOINT_CELLS ((2U * TUMBLE_STORE_MIN_SECTOR) / TUMBLE_CHECKPOINT_BYTES) /* the first is the header */

typedef struct {
    tumble_nv_writer_t writer;
    tumble_status_t outcome;
    uint32_t fingerprint; /* of the run that is kept */
    uint32_t verify;      /* read back wrong, since init */
    uint32_t nv_errors;
    uint32_t torn;        /* cells that init found neither blank nor valid; of a run that is kept only */
    uint8_t place[TUMBLE_MAX_POSITIONS]; /* the cell of the last valid entry of each position; 0: none */
    uint8_t next;         /* the cell where the next entry goes */
    uint8_t scanned;
    uint8_t phase;        /* private to checkpoint.c */
    bool kept;            /* a run has been begun */
    bool booted;
    uint8_t bytes[TUMBLE_CHECKPOINT_BYTES];
} tumble_checkpoint_t;

/* As tumble_store_init, _step, _busy. */
tumble_status_t tumble_checkpoint_init(tumble_checkpoint_t *checkpoint, const tumble_nv_t *nv);
tumble_status_t tumble_checkpoint_step(tumble_checkpoint_t *checkpoint);
bool tumble_checkpoint_busy(const tumble_checkpoint_t *checkpoint);

/* Forget what is kept and begin a new run. Returns TUMBLE_OK (begun), _PORT_BUSY, _STATE (init refused). */
tumble_status_t tumble_checkpoint_begin(tumble_checkpoint_t *checkpoint, uint32_t fingerprint);

/* Keep one finished position. Returns TUMBLE_OK (begun); _PORT_BUSY; _STATE (no run has been begun); _FULL (no cell is
 * left: TUMBLE_CHECKPOINT_CELLS - 1 entries, torn ones included); _ARGUMENT (null, an index not below
 * TUMBLE_MAX_POSITIONS, samples 0 or above TUMBLE_MAX_SAMPLES, a negative scatter); _NOT_FINITE (the scatter). */
tumble_status_t tumble_checkpoint_append(tumble_checkpoint_t *checkpoint, uint8_t index,
                                         const tumble_average_t *average);

/* Forget the run. Returns TUMBLE_OK (begun), _PORT_BUSY, _STATE (init refused). */
tumble_status_t tumble_checkpoint_clear(tumble_checkpoint_t *checkpoint);

/* Is a run with this fingerprint kept? False while busy. */
bool tumble_checkpoint_matches(const tumble_checkpoint_t *checkpoint, uint32_t fingerprint);

/* Is this position kept? The last entry of a position counts. False while busy, and for an index out of range. */
bool tumble_checkpoint_has(const tumble_checkpoint_t *checkpoint, uint8_t index);

/* One kept position; one read. The caller has asked tumble_checkpoint_matches before.
 * Returns TUMBLE_OK, _PORT_BUSY (ask again), _MISSING_POSITION (not kept), _ARGUMENT (null), _NV, _CRC. */
tumble_status_t tumble_checkpoint_read(tumble_checkpoint_t *checkpoint, uint8_t index, tumble_average_t *average);

#endif
