/* store_nv.h - a memory that behaves like flash, and lies like it: at a chosen operation power is lost, or it does nothing,
 * or a part, or the wrong thing, and says so or does not. Needs no Unity.
 */
#ifndef STORE_NV_H
#define STORE_NV_H

#include "port/port.h"
#include "store/regions.h"

#include <stdbool.h>
#include <string.h>

#define NV_MAX_SECTOR 8192U
#ifndef NV_SECTORS
#define NV_SECTORS ((uint32_t)TUMBLE_REGION_COUNT)
#endif
#define NV_MAX_BYTES (NV_MAX_SECTOR * NV_SECTORS)
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
    uint32_t operations;   /* erases and programs since nv_arm */
    uint32_t violations;   /* calls that port.h forbids, or a granule programmed twice */
    uint32_t random;
    uint32_t reads;
    uint32_t read_fails_at; /* that read fails; NV_NEVER */
    uint32_t read_fails;    /* so many in a row */
    uint32_t busy_each;     /* TUMBLE_E_PORT_BUSY so often before every call is done */
    uint32_t busy_left;
    uint32_t busy_offset; /* the call that is being put off */
    bool is_off;
} store_nv_t;

static inline uint32_t nv_draw(store_nv_t *memory)
{
    memory->random = memory->random * 1664525U + 1013904223U;
    return memory->random >> 8;
}

static inline uint8_t nv_mix(store_nv_t *memory, done_t done, uint32_t i, uint32_t size, uint8_t old, uint8_t new)
{
    const uint8_t bits = (uint8_t)nv_draw(memory);
    switch (done) {
    case DONE_NOTHING:
        return old;
    case DONE_QUARTER:
        return (i < size / 4U) ? new : old;
    case DONE_HALF:
        return (i < size / 2U) ? new : old;
    case DONE_BUT_LAST:
        return (i + 1U < size) ? new : old;
    case DONE_SECOND_HALF:
        return (i >= size / 2U) ? new : old;
    case DONE_SOME_BITS:
        return (uint8_t)(old ^ ((old ^ new) & bits));
    case DONE_SOME_BYTES:
        return ((bits & 1U) != 0U) ? new : old;
    case DONE_ANY_VALUES:
        return bits;
    default:
        return new;
    }
}

/* Put a call off, and see that the same call comes again. */
static inline bool nv_is_busy(store_nv_t *memory, uint32_t offset)
{
    if (memory->busy_each == 0U) {
        return false;
    }
    if (memory->busy_left == 0U) {
        memory->busy_left = memory->busy_each + 1U;
        memory->busy_offset = offset;
    }
    memory->violations += (memory->busy_offset != offset) ? 1U : 0U;
    memory->busy_left--;
    return memory->busy_left > 0U;
}

static inline void nv_fill(uint8_t *to, const uint8_t *bytes, uint32_t size)
{
    if (bytes == NULL) {
        memset(to, 0xFF, size);
    } else {
        memcpy(to, bytes, size);
    }
}

static inline tumble_status_t nv_change(store_nv_t *memory, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    const bool hit = memory->operations == memory->fault.at;
    memory->operations++;
    if (!hit) {
        nv_fill(&memory->bytes[offset], bytes, size);
        return TUMBLE_OK;
    }
    for (uint32_t i = 0; i < size; i++) {
        uint8_t *byte = &memory->bytes[offset + i];
        *byte = nv_mix(memory, memory->fault.done, i, size, *byte, (bytes == NULL) ? 0xFF : bytes[i]);
    }
    memory->is_off = memory->fault.then == THEN_CUT;
    return (memory->fault.then != THEN_SILENT) ? TUMBLE_E_NV : TUMBLE_OK;
}

static inline tumble_status_t nv_erase(void *context, uint32_t offset)
{
    store_nv_t *memory = context;
    const bool right = offset % memory->nv.sector_bytes == 0U && offset < memory->nv.size_bytes;
    memory->violations += right && offset != 0U ? 0U : 1U; /* the factory set is never erased */
    if (!right || memory->is_off) {
        return TUMBLE_E_NV;
    }
    return nv_is_busy(memory, offset) ? TUMBLE_E_PORT_BUSY : nv_change(memory, offset, NULL, memory->nv.sector_bytes);
}

static inline bool nv_all_blank(const uint8_t *bytes, uint32_t size)
{
    uint8_t all = 0xFF;
    for (uint32_t i = 0; i < size; i++) {
        all &= bytes[i];
    }
    return all == 0xFFU;
}

static inline tumble_status_t nv_program(void *context, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    store_nv_t *memory = context;
    const tumble_nv_t *nv = &memory->nv;
    if (memory->is_off) {
        return TUMBLE_E_NV;
    }
    const bool right = size > 0U && offset % nv->granule_bytes == 0U && size % nv->granule_bytes == 0U &&
                       offset + size <= nv->size_bytes &&
                       offset / nv->sector_bytes == (offset + size - 1U) / nv->sector_bytes;
    if (!right || !nv_all_blank(&memory->bytes[offset], size)) {
        memory->violations++;
        return TUMBLE_E_NV;
    }
    return nv_is_busy(memory, offset) ? TUMBLE_E_PORT_BUSY : nv_change(memory, offset, bytes, size);
}

static inline tumble_status_t nv_read(void *context, uint32_t offset, uint8_t *bytes, uint32_t size)
{
    store_nv_t *memory = context;
    const bool right = offset + size <= memory->nv.size_bytes;
    memory->violations += right ? 0U : 1U;
    if (!right || memory->is_off) {
        return TUMBLE_E_NV;
    }
    if (nv_is_busy(memory, offset)) {
        return TUMBLE_E_PORT_BUSY;
    }
    const uint32_t read = memory->reads++;
    if (read >= memory->read_fails_at && read - memory->read_fails_at < memory->read_fails) {
        return TUMBLE_E_NV;
    }
    memcpy(bytes, &memory->bytes[offset], size);
    return TUMBLE_OK;
}

/* From here on count operations anew; the one at `fault.at` goes wrong. Power is on. */
static inline void nv_arm(store_nv_t *memory, nv_fault_t fault)
{
    memory->fault = fault;
    memory->operations = 0;
    memory->is_off = false;
    memory->busy_left = 0;
}

static const nv_fault_t nv_no_fault = {NV_NEVER, DONE_ALL, THEN_SILENT};

static inline void nv_make(store_nv_t *memory, uint32_t granule, uint32_t sector)
{
    memset(memory, 0, sizeof *memory);
    memset(memory->bytes, 0xFF, sizeof memory->bytes);
    memory->nv = (tumble_nv_t){memory, NV_SECTORS * sector, sector, granule, nv_erase, nv_program, nv_read};
    memory->random = 1;
    memory->read_fails_at = NV_NEVER;
    nv_arm(memory, nv_no_fault);
}

#endif
