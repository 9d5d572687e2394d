/* port_linux.h - the firmware's port (tumble/port.h) on a CAN socket and the monotonic clock.
 *
 * Only classic data frames with 11-bit identifiers get to the firmware; others are counted. Every frame that it takes
 * or gives can be watched, in the order in which the firmware has them.
 */
#ifndef TUMBLE_LINUX_PORT_LINUX_H
#define TUMBLE_LINUX_PORT_LINUX_H

#include "can_socket.h"
#include "tumble/port.h"

#include <stdint.h>

typedef struct {
    can_socket_t can;
    uint64_t start_us; /* of the monotonic clock: the port's time begins here */
    uint64_t foreign;  /* frames received that are no classic data frames with 11-bit identifiers */
    void (*on_frame)(void *context, const tumble_can_frame_t *frame); /* may be null */
    void *context;
} port_linux_t;

/* Open the interface and fill in `port`, which keeps a pointer to `self`. As can_socket_open. */
can_socket_status_t port_linux_open(port_linux_t *self, tumble_port_t *port, const char *interface);

/* The port's time. */
uint64_t port_linux_now_us(const port_linux_t *self);

/* The monotonic clock itself, and UTC. */
uint64_t port_linux_clock_us(void);
uint64_t port_linux_utc_us(void);

/* From one form of a frame to the other. False: it is no classic data frame with an 11-bit identifier. */
bool port_linux_from(const struct can_frame *from, tumble_can_frame_t *frame);
void port_linux_to(const tumble_can_frame_t *from, struct can_frame *frame);

void port_linux_close(port_linux_t *self);

#endif
