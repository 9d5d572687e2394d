/* port.h - everything the firmware needs of a board: a clock and CAN frames.
 *
 * A board fills in one const table of non-blocking functions; nothing else reaches hardware. Every call returns at once.
 * What a port returns is checked and counted by its caller: a status outside the lists below counts as
 * TUMBLE_E_PORT_DOWN, a frame longer than eight bytes or with an identifier beyond eleven bits is dropped.
 */
#ifndef TUMBLE_PORT_PORT_H
#define TUMBLE_PORT_PORT_H

#include "core/status.h"

#include <stdint.h>

#define TUMBLE_CAN_MAX_BYTES 8
#define TUMBLE_CAN_MAX_ID 0x7FFU

/* A classic CAN data frame with an 11-bit identifier. */
typedef struct {
    uint16_t id;
    uint8_t length; /* 0 to 8 */
    uint8_t data[TUMBLE_CAN_MAX_BYTES];
} tumble_can_frame_t;

typedef struct {
    void *context; /* handed to every function */

    /* Monotonic time since any fixed moment, in microseconds; never goes back, never wraps. */
    uint64_t (*now_us)(void *context);

    /* Queue one frame for sending. TUMBLE_OK; TUMBLE_E_PORT_BUSY: no room now, try again at a later step;
     * TUMBLE_E_PORT_DOWN: the controller is off the bus. */
    tumble_status_t (*can_send)(void *context, const tumble_can_frame_t *frame);

    /* Take the oldest received frame. TUMBLE_OK; TUMBLE_E_PORT_EMPTY: nothing there; TUMBLE_E_PORT_DOWN. */
    tumble_status_t (*can_receive)(void *context, tumble_can_frame_t *frame);
} tumble_port_t;

#endif
