/* regions.h - where in the non-volatile memory what is kept (docs/store.md). Region n begins at n sectors.
 *
 * Of a sector only the first TUMBLE_STORE_MIN_SECTOR bytes are used, so the layout is the same for every larger sector and
 * for every granule.
 */
#ifndef TUMBLE_SETS_REGIONS_H
#define TUMBLE_SETS_REGIONS_H

#include "tumble/status.h"
#include "tumble/port.h"

enum {
    TUMBLE_REGION_FACTORY = 0,    /* the factory set: written once, never erased by the firmware */
    TUMBLE_REGION_SLOT_A = 1,     /* the active set is in one of the two slots, or it is the factory set */
    TUMBLE_REGION_SLOT_B = 2,
    TUMBLE_REGION_PROPOSAL = 3,   /* the held set */
    TUMBLE_REGION_HISTORY = 4,    /* two sectors in turns */
    TUMBLE_REGION_CHECKPOINT = 6, /* finished positions of a run: one log through two sectors */
    TUMBLE_REGION_COUNT = 8
};

#define TUMBLE_STORE_MIN_SECTOR 4096U

/* Can all of it be kept there? A board whose memory has smaller sectors joins several to one.
 * Returns TUMBLE_OK; _ARGUMENT (null); _NV (fewer than TUMBLE_REGION_COUNT sectors, one smaller than
 * TUMBLE_STORE_MIN_SECTOR, or a granule that is no power of two up to TUMBLE_NV_MAX_GRANULE). */
tumble_status_t tumble_regions_check(const tumble_nv_t *nv);

#endif
