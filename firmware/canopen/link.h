/* link.h - the port's CAN functions with their answers checked and counted.
 *
 * A frame that the port cannot take now stays with the service that made it and is offered again at its next step.
 */
#ifndef TUMBLE_CANOPEN_LINK_H
#define TUMBLE_CANOPEN_LINK_H

#include "core/count.h"
#include "tumble/port.h"

#include <stdint.h>

/* Monotonic; they stop at UINT32_MAX instead of wrapping. */
typedef struct {
    uint32_t sent;
    uint32_t received;
    uint32_t busy;    /* offers that the port had no room for */
    uint32_t down;    /* answers that the controller is off the bus, or outside the port's list */
    uint32_t invalid; /* received frames dropped: longer than eight bytes or an identifier beyond eleven bits */
} tumble_link_counters_t;

typedef struct {
    const tumble_port_t *port;
    tumble_link_counters_t counters;
    tumble_status_t last; /* of the latest send or receive: TUMBLE_E_PORT_DOWN tells that the bus is off */
} tumble_link_t;

void tumble_link_init(tumble_link_t *link, const tumble_port_t *port);

/* Returns TUMBLE_OK, TUMBLE_E_PORT_BUSY or TUMBLE_E_PORT_DOWN. */
tumble_status_t tumble_link_send(tumble_link_t *link, const tumble_can_frame_t *frame);

/* The same for a frame that is made of these. */
tumble_status_t tumble_link_send_bytes(tumble_link_t *link, uint32_t id, const uint8_t *bytes, uint8_t length);

/* Returns TUMBLE_OK, TUMBLE_E_PORT_EMPTY, TUMBLE_E_PORT_DOWN, or TUMBLE_E_FRAME for a frame that was dropped (ask
 * again). */
tumble_status_t tumble_link_receive(tumble_link_t *link, tumble_can_frame_t *frame);

/* A time that never comes: a timer that does not run. */
#define TUMBLE_NEVER UINT64_MAX

#endif
