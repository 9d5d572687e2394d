/* tumble/port.h - what the firmware needs of a board: a clock, CAN frames and, where it keeps coefficients,
 * non-volatile memory.
 *
 * A board fills in one const table of non-blocking functions; nothing else reaches hardware. Every call returns at
 * once. The caller checks and counts what a port returns: a status outside the lists below counts as
 * TUMBLE_E_PORT_DOWN; a frame longer than eight bytes, or with an identifier beyond eleven bits, is dropped.
 */
#ifndef TUMBLE_PORT_H
#define TUMBLE_PORT_H

#include "tumble/status.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TUMBLE_CAN_MAX_BYTES 8
#define TUMBLE_CAN_MAX_ID 0x7FFU

/* A classic CAN data frame with an 11-bit identifier. */
typedef struct {
    uint16_t id;
    uint8_t length; /* 0 to 8 */
    uint8_t data[TUMBLE_CAN_MAX_BYTES];
} tumble_can_frame_t;

/* The largest granule that the store can fill. */
#define TUMBLE_NV_MAX_GRANULE 32U

/* Non-volatile memory that works like flash, addressed from 0: erased by the sector (every byte becomes FFh),
 * programmed by the granule (once after each erase), read by the byte. For FRAM and EEPROM an erase fills the sector
 * with FFh.
 *
 * An operation may take long. Until it has ended every call returns TUMBLE_E_PORT_BUSY at once, and the caller repeats
 * the same call, with the same arguments and bytes, at a later step. A loss of power in the middle of an operation may
 * leave any values in the bytes that it addresses, and in no others. All functions return TUMBLE_OK,
 * TUMBLE_E_PORT_BUSY, or TUMBLE_E_NV (the operation failed, or the memory has no such place).
 *
 * A driver may wait for an operation to end instead of returning TUMBLE_E_PORT_BUSY only if its caller can: the store
 * alone has no deadlines, but while a step of the navigation computer waits, no frame is sent or received, and a table
 * that turns is not watched. */
typedef struct {
    void *context;          /* handed to every function */
    uint32_t size_bytes;    /* whole sectors */
    uint32_t sector_bytes;  /* whole granules */
    uint32_t granule_bytes; /* 1 to TUMBLE_NV_MAX_GRANULE, a power of two */

    /* `offset` is that of a sector. */
    tumble_status_t (*erase)(void *context, uint32_t offset);

    /* `offset` and `size` are whole granules, all of one sector. Refuses (TUMBLE_E_NV) a granule that has been programmed
     * since its sector was erased. `bytes` may have any alignment. They stay where and as
     * they are from the first call until one returns anything but TUMBLE_E_PORT_BUSY, and no longer; until then the
     * driver may read them between calls too, as by DMA. (Initialising a store anew gives up the call under way.) */
    tumble_status_t (*program)(void *context, uint32_t offset, const uint8_t *bytes, uint32_t size);

    /* Any bytes; beyond the end TUMBLE_E_NV. Of a granule that a loss of power has torn the bytes come as they are, with
     * TUMBLE_OK, also if the memory reports an uncorrectable error: checksums judge them. */
    tumble_status_t (*read)(void *context, uint32_t offset, uint8_t *bytes, uint32_t size);
} tumble_nv_t;

typedef struct {
    void *context; /* handed to every function */

    /* Monotonic time since any fixed moment, in microseconds; never goes back, never wraps. */
    uint64_t (*now_us)(void *context);

    /* Queue one frame for sending. TUMBLE_OK; TUMBLE_E_PORT_BUSY: no room now, try again at a later step;
     * TUMBLE_E_PORT_DOWN: the controller is off the bus. */
    tumble_status_t (*can_send)(void *context, const tumble_can_frame_t *frame);

    /* Take the oldest received frame. TUMBLE_OK; TUMBLE_E_PORT_EMPTY: nothing there; TUMBLE_E_PORT_DOWN. */
    tumble_status_t (*can_receive)(void *context, tumble_can_frame_t *frame);

    const tumble_nv_t *nv; /* null: the board has none, and keeps nothing */
} tumble_port_t;

#ifdef __cplusplus
}
#endif

#endif
