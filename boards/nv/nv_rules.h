/* nv_rules.h - what port.h wants of the arguments of a non-volatile memory, for everything that stands in for flash. */
#ifndef TUMBLE_BOARDS_NV_RULES_H
#define TUMBLE_BOARDS_NV_RULES_H

#include "tumble/port.h"

#include <stdbool.h>
#include <stdint.h>

#define NV_ERASED 0xFFU

/* Does a sector begin there? */
static inline bool nv_is_sector(const tumble_nv_t *nv, uint32_t offset)
{
    return (offset < nv->size_bytes) && ((offset % nv->sector_bytes) == 0U);
}

/* Whole granules, at least one, all of one sector? */
static inline bool nv_are_granules(const tumble_nv_t *nv, uint32_t offset, uint32_t size)
{
    return (offset < nv->size_bytes) && (size != 0U) && ((offset % nv->granule_bytes) == 0U) &&
           ((size % nv->granule_bytes) == 0U) && (size <= (nv->sector_bytes - (offset % nv->sector_bytes)));
}

/* Bytes of this memory? */
static inline bool nv_are_there(const tumble_nv_t *nv, uint32_t offset, uint32_t size)
{
    return (offset <= nv->size_bytes) && (size <= (nv->size_bytes - offset));
}

/* A granule that holds anything else has been programmed since it was erased, and may not be again: flash with error
 * correction refuses it. */
static inline bool nv_is_blank(const uint8_t *bytes, uint32_t size)
{
    bool blank = true;
    for (uint32_t i = 0; i < size; i++) {
        blank = blank && (bytes[i] == NV_ERASED);
    }
    return blank;
}

#endif
