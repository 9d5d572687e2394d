/* can.h - a CAN controller of the Zynq UltraScale+ (there are two), without interrupts: the main loop asks.
 *
 * The controller queues 64 frames in either direction; that is all the queue there is. A frame that finds the receive
 * queue full is lost, and the controller tells no more than that: such moments are counted. Up to four filters keep
 * frames out that nobody here wants; extended and remote frames never pass them.
 *
 * Bus-off: the controller is reset at once, which empties its queues, stays away for the time of 128 x 11 bits, and
 * joins again by itself. Meanwhile send and receive return TUMBLE_E_PORT_DOWN.
 *
 * The caller owns the object; not re-entrant on one object. Nothing waits.
 */
#ifndef ZCU102_CAN_H
#define ZCU102_CAN_H

#include "bit_timing.h"
#include "tumble/port.h"

#include <stdbool.h>
#include <stdint.h>

#define ZCU102_CAN0 0xFF060000U
#define ZCU102_CAN1 0xFF070000U
#define ZCU102_CAN0_INTERRUPT 55U /* at the interrupt controller */
#define ZCU102_CAN_QUEUE 64U      /* frames, either direction */
#define ZCU102_CAN_FILTERS 4U

/* Where the words of a frame hold the identifier and the first data byte. The emulator's model of this controller takes
 * its words for those of a Linux frame, so that what it puts on a bus of the host differs from the chip. */
typedef enum {
    ZCU102_CAN_SILICON = 0, /* identifier in bits 31 to 21, first byte on top: as documented */
    ZCU102_CAN_EMULATED     /* QEMU 7.2: identifier in bits 10 to 0, first byte at the bottom */
} zcu102_can_layout_t;

/* A frame passes when its identifier equals `id` in all bits that are set in `mask`. */
typedef struct {
    uint16_t id;
    uint16_t mask;
} zcu102_can_filter_t;

typedef struct {
    uint32_t base; /* ZCU102_CAN0 or _CAN1 */
    uint32_t clock_hz;
    uint32_t bits_per_second;
    const zcu102_can_filter_t *filters; /* null: every standard frame passes */
    uint8_t filter_count;               /* up to ZCU102_CAN_FILTERS */
    zcu102_can_layout_t layout;
} zcu102_can_config_t;

/* Monotonic since init; they stop at UINT32_MAX. */
typedef struct {
    uint32_t sent; /* handed to the controller */
    uint32_t received;
    uint32_t busy;        /* found the transmit queue full */
    uint32_t rx_overflow; /* moments in which frames were lost because the receive queue was full */
    uint32_t foreign;     /* extended or remote frames that came in spite of the filters */
    uint32_t bus_off;
} zcu102_can_counters_t;

typedef struct {
    const zcu102_can_config_t *config;
    zcu102_bit_timing_t timing;
    zcu102_can_counters_t counters;
    uint64_t rejoin_us; /* while away: when to join again */
    bool away;
} zcu102_can_t;

/* Configure and join the bus. Returns TUMBLE_OK, or TUMBLE_E_ARGUMENT (null, too many filters, or a rate that the clock
 * does not reach). */
tumble_status_t zcu102_can_init(zcu102_can_t *can, const zcu102_can_config_t *config);

/* As in port.h. Also TUMBLE_E_ARGUMENT: not a classic data frame. */
tumble_status_t zcu102_can_send(zcu102_can_t *can, const tumble_can_frame_t *frame, uint64_t now_us);
tumble_status_t zcu102_can_receive(zcu102_can_t *can, tumble_can_frame_t *frame, uint64_t now_us);

#endif
