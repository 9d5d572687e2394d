/* controller.h - a model of two CAN controllers of the Zynq UltraScale+ on one wire, by the published layout of their
 * registers; it was never compared with the chip. It stands in the place of boards/zcu102/io.c.
 *
 * A frame that is written waits in the transmit queue until `controller_run` carries it over the wire. What software
 * must not do is counted as misuse: half frames, reading an empty queue, writing into a full one, setting timing or
 * filters while the controller is on.
 */
#ifndef TUMBLE_TESTS_CONTROLLER_H
#define TUMBLE_TESTS_CONTROLLER_H

#include <stdbool.h>
#include <stdint.h>

#define CONTROLLER_QUEUE 64U

typedef struct {
    uint32_t word[4];
} controller_frame_t;

typedef struct {
    uint32_t reg[0x84 / 4];
    controller_frame_t tx[CONTROLLER_QUEUE], rx[CONTROLLER_QUEUE];
    uint32_t tx_count, rx_count;
    controller_frame_t writing;
    uint32_t written; /* words of it */
    uint32_t reading; /* words left of the frame that is being read */
    bool dead;        /* bus-off until a reset */
    uint32_t misuse;
    uint32_t resets;
} controller_t;

extern controller_t controllers[2];

/* As after power-on. */
void controllers_init(void);

/* Carry everything that waits over the wire, lowest identifier first; at most `frames`. */
void controllers_run(uint32_t frames);

/* Too many errors: the controller goes off the bus. */
void controller_kill(uint32_t number);

/* A frame from a third node, as the words of the receive queue. */
void controllers_hear(const controller_frame_t *frame);

#endif
