/* history.h - the last sets that became active, in short: an append-only log in two sectors that take turns.
 *
 * Each sector has room for TUMBLE_HISTORY_CELLS entries. When one is full the other, which holds the oldest, is erased and
 * goes on. So the last 32 are there at any time, whatever a loss of power does to the one being written; an entry torn by a
 * loss of power costs one of them its place. Between a commit and its entry power may fail: a caller that compares the
 * newest entry's sequence with the store's at start-up, and appends what is missing, has them all.
 * Jobs as in store.h: begin, then step; at most one call of the memory a step.
 */
#ifndef TUMBLE_SETS_HISTORY_H
#define TUMBLE_SETS_HISTORY_H

#include "tumble/core.h"
#include "tumble/port.h"
#include "sets/nv_writer.h"
#include "sets/regions.h"
#include "sets/set_record.h"

#include <stdbool.h>
#include <stdint.h>

#define TUMBLE_HISTORY_BYTES 128U
#define TUMBLE_HISTORY_CELLS (TUMBLE_STORE_MIN_SECTOR / TUMBLE_HISTORY_BYTES)

/* A flag of an entry that its writer may add: the sets before are of another block. */
#define TUMBLE_HISTORY_OTHER_BLOCK 0x8000U

/* The numbers as single precision: six parts in 10^8, far below what a calibration can resolve. */
typedef struct {
    uint32_t number;   /* of the entry, from 1; written by the log */
    uint32_t sequence; /* of the set */
    uint64_t date_utc_s; /* 0: unknown */
    float temperature_c;
    uint8_t origin;
    uint8_t estimator;
    uint16_t flags; /* TUMBLE_SET_HAS_TEMPERATURE and _UNCERTAINTY are meant for this entry; TUMBLE_HISTORY_... */
    float value[TUMBLE_COEFFICIENTS]; /* K row by row (V/g), then U0 (V) */
    float u[TUMBLE_COEFFICIENTS];     /* standard uncertainties; 0 where not known */
} tumble_history_entry_t;

typedef struct {
    tumble_nv_writer_t writer;
    tumble_status_t outcome;
    uint32_t valid[2];  /* one bit a cell */
    uint32_t newest;    /* its number; 0: the log is empty */
    uint32_t sequence;  /* of the newest */
    uint32_t verify;    /* read back wrong, since init */
    uint32_t nv_errors;
    uint32_t torn;      /* cells that init found neither blank nor valid */
    uint8_t sector;     /* 0 or 1: where the newest is */
    uint8_t used[2];    /* cells of each up to the last that is not blank; the next goes there */
    uint8_t scanned;
    uint8_t phase;      /* private to history.c */
    bool booted;
    bool unread;        /* the last scan could not read a cell: what is there must not be overwritten */
    uint8_t bytes[TUMBLE_HISTORY_BYTES];
} tumble_history_t;

/* What of a set goes into the log. Pure. Returns TUMBLE_OK, _ARGUMENT (null), _NOT_FINITE (a number too large for single
 * precision). */
tumble_status_t tumble_history_from_set(const tumble_set_t *set, tumble_history_entry_t *entry);

/* Bytes of an entry (docs/store.md). `encode`: _ARGUMENT (null), _NOT_FINITE. `decode`: _ARGUMENT, _FRAME (blank, or not the
 * magic), _CRC, _NOT_FINITE. */
tumble_status_t tumble_history_encode(const tumble_history_entry_t *entry, uint8_t bytes[TUMBLE_HISTORY_BYTES]);
tumble_status_t tumble_history_decode(const uint8_t bytes[TUMBLE_HISTORY_BYTES], tumble_history_entry_t *entry);

/* Give an encoded entry another number. For the log. */
void tumble_history_number(uint8_t bytes[TUMBLE_HISTORY_BYTES], uint32_t number);

/* As tumble_store_init, _step, _busy; init takes 64 calls of the memory. */
tumble_status_t tumble_history_init(tumble_history_t *history, const tumble_nv_t *nv);
tumble_status_t tumble_history_step(tumble_history_t *history);
bool tumble_history_busy(const tumble_history_t *history);

/* Begin to append. Returns TUMBLE_OK (begun), _PORT_BUSY (a job is under way), _STATE (init refused, or the number of
 * entries has reached UINT32_MAX - 1), _NV (a cell could not be read when it looked what is there: it looks again now;
 * step, then try again), or as tumble_history_encode. */
tumble_status_t tumble_history_append(tumble_history_t *history, const tumble_history_entry_t *entry);

/* How many entries there are: after more than 32, 32 to 64. 0 while busy. */
uint8_t tumble_history_count(const tumble_history_t *history);

/* The sequence of the newest entry; 0: none. */
uint32_t tumble_history_sequence(const tumble_history_t *history);

/* One entry, `age` 0 the newest, below tumble_history_count(). One read.
 * Returns TUMBLE_OK, _PORT_BUSY (ask again), _ARGUMENT (null, or no such age), _NV, _FRAME, _CRC. */
tumble_status_t tumble_history_read(tumble_history_t *history, uint8_t age, tumble_history_entry_t *entry);

#endif
