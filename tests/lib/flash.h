/* flash.h - a memory that behaves like flash, and lies like it: at a chosen operation power is lost, or it does nothing,
 * or a part, or the wrong thing, and says so or does not. Needs no Unity.
 */
#ifndef TUMBLE_TESTS_FLASH_H
#define TUMBLE_TESTS_FLASH_H

#include "tumble/port.h"

#include <stdbool.h>
#include <string.h>

#define NV_MAX_SECTOR 8192U
#define NV_MAX_SECTORS 10U /* the store's, and two of the parameters */
#define NV_MAX_BYTES (NV_MAX_SECTOR * NV_MAX_SECTORS)
#define NV_FAULTS 2U
#define NV_NEVER UINT32_MAX

/* How much of an operation is done, */
typedef enum {
    DONE_NOTHING,
    DONE_ALL,
    DONE_QUARTER,
    DONE_HALF,
    DONE_BUT_LAST,
    DONE_SECOND_HALF,
    DONE_SOME_BITS, /* each bit that was to change has, or has not */
    DONE_SOME_BYTES,
    DONE_ANY_VALUES,
    DONE_KINDS
} done_t;

/* and what comes of it. */
typedef enum { THEN_CUT, THEN_SILENT, THEN_ERROR, THEN_KINDS } then_t; /* done in full and silent: done twice */

typedef struct {
    uint32_t at; /* operation, from 0; NV_NEVER */
    done_t done;
    then_t then;
} nv_fault_t;

typedef struct {
    tumble_nv_t nv;
    uint8_t bytes[NV_MAX_BYTES];
    nv_fault_t fault;
    uint32_t more;       /* operations after fault.at that go wrong as well */
    uint32_t operations; /* erases and programs since nv_arm */
    uint32_t violations; /* calls that port.h forbids, or a granule programmed twice */
    uint32_t random;
    uint32_t reads;
    uint32_t read_fails_at; /* that read fails; NV_NEVER */
    uint32_t read_fails;    /* so many in a row */
    uint32_t busy_each;     /* TUMBLE_E_PORT_BUSY so often before every call is done */
    uint32_t busy_left;
    uint32_t busy_offset; /* the call that is being put off */
    uint32_t busy_every;  /* TUMBLE_E_PORT_BUSY to each call of so many; 1: to all, 0: to none */
    uint32_t calls;
    void (*on_violation)(void); /* NULL: they are counted alone */
    bool is_off;
} nv_memory_t;

bool nv_all_blank(const uint8_t *bytes, uint32_t size);
tumble_status_t nv_program(void *context, uint32_t offset, const uint8_t *bytes, uint32_t size);
tumble_status_t nv_read(void *context, uint32_t offset, uint8_t *bytes, uint32_t size);

/* From here on count operations anew; the one at `fault.at` goes wrong. Power is on. */
void nv_arm(nv_memory_t *memory, nv_fault_t fault);

extern const nv_fault_t nv_no_fault;

/* The same, and so many operations are refused. */
void nv_refuse(nv_memory_t *memory, uint32_t times);

/* Erased; `sectors` of `sector` bytes. */
void nv_make(nv_memory_t *memory, uint32_t sectors, uint32_t granule, uint32_t sector);

#endif
