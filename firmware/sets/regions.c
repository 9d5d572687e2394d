#include "tumble/sets.h"

#include <stdbool.h>
#include <stddef.h>

static bool is_granule(uint32_t bytes)
{
    return (bytes != 0U) && (bytes <= TUMBLE_NV_MAX_GRANULE) && ((bytes & (bytes - 1U)) == 0U);
}

tumble_status_t tumble_regions_check(const tumble_nv_t *nv)
{
    if ((nv == NULL) || (nv->erase == NULL) || (nv->program == NULL) || (nv->read == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    const bool fits = (nv->sector_bytes >= TUMBLE_STORE_MIN_SECTOR) && is_granule(nv->granule_bytes) &&
                      ((nv->sector_bytes % nv->granule_bytes) == 0U) &&
                      ((nv->size_bytes / nv->sector_bytes) >= (uint32_t)TUMBLE_REGION_COUNT);
    return fits ? TUMBLE_OK : TUMBLE_E_NV;
}
