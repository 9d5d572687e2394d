/* bus.h - a classic CAN bus in virtual time: arbitration, frame times to the bit, queues, faults, statistics.
 *
 * Whenever the bus is idle, the frames at the heads of the nodes' transmit queues compete and the lowest identifier
 * wins. A frame reaches every other node at the end of its end-of-frame field; three bits later the next may begin.
 * Queues are bounded, and what does not fit is counted. Nodes are woken through the clock, each as its actor.
 *
 * Faults act where a frame is handed in, so every node, and the log, sees the same traffic.
 */
#ifndef TUMBLE_SIMULATION_BUS_H
#define TUMBLE_SIMULATION_BUS_H

#include "simulation/clock.h"
#include "simulation/frame_bits.h"
#include "simulation/random.h"
#include "tumble/port.h"

#include <assert.h>
#include <stdbool.h>
#include <stdint.h>

#define SIM_BUS_NODES 7 /* up to 8 */
#define SIM_BUS_TX_DEPTH 32
#define SIM_BUS_RX_DEPTH 64
#define SIM_BUS_HELD 16 /* frames that faults may hold back at one time */

static_assert((SIM_BUS_RX_DEPTH & (SIM_BUS_RX_DEPTH - 1)) == 0 && (SIM_BUS_TX_DEPTH & (SIM_BUS_TX_DEPTH - 1)) == 0,
              "depths of queues are powers of two");

/* What can go wrong with frames on their way to the bus. */
#define SIM_BUS_FAULTS 16

typedef enum {
    SIM_FRAME_DROP = 0,  /* lost without a trace */
    SIM_FRAME_CORRUPT,   /* one bit of its data flipped, unnoticed by CAN's own CRC */
    SIM_FRAME_TRUNCATE,  /* its last byte missing */
    SIM_FRAME_DELAY,     /* handed in later */
    SIM_FRAME_DUPLICATE, /* handed in twice */
    SIM_FRAME_REORDER    /* handed in behind the next frame that matches */
} sim_frame_fault_t;

/* Frames with (id & mask) == match are affected, each with `probability`; the first `skip` of those picked are spared,
 * then `count` are affected. */
typedef struct {
    sim_frame_fault_t kind;
    uint16_t match;
    uint16_t mask;
    uint32_t skip;
    uint32_t count; /* UINT32_MAX: without end */
    uint32_t delay_us;
    double probability;
    sim_random_t random;
    bool holding; /* reorder: one frame waits for the next */
} sim_bus_fault_t;

/* A frame that waits. */
typedef struct {
    tumble_can_frame_t frame;
    uint64_t due_us; /* SIM_NEVER: until fault number `fault` meets its next frame */
    uint8_t node;
    uint8_t fault;
} sim_bus_held_t;

typedef struct {
    uint32_t sent;        /* frames that went over the bus */
    uint32_t received;    /* frames put into the receive queue */
    uint32_t tx_overflow; /* refused, queue full */
    uint32_t rx_overflow; /* lost, queue full */
} sim_bus_counters_t;

typedef struct {
    tumble_can_frame_t tx[SIM_BUS_TX_DEPTH];
    tumble_can_frame_t rx[SIM_BUS_RX_DEPTH];
    uint32_t tx_first, tx_count;
    uint32_t rx_first, rx_count;
    sim_actor_t actor;
    uint32_t loop_us; /* it looks for frames at multiples of this; 0: at once */
    bool attached;
    bool down; /* off the bus: sends nothing, hears nothing */
    sim_bus_counters_t counters;
} sim_bus_node_t;

/* Called at the end of every frame, before it is delivered. */
typedef void (*sim_bus_tap_t)(void *context, uint64_t time_us, uint8_t sender, const tumble_can_frame_t *frame);

typedef struct {
    uint64_t frames;
    uint64_t bits; /* with stuff bits and interframe space */
    uint64_t busy_us;
} sim_bus_load_t;

typedef struct {
    sim_clock_t *clock;
    const sim_wire_t *wire;
    sim_bus_node_t nodes[SIM_BUS_NODES];
    sim_bus_load_t load;
    tumble_can_frame_t flying; /* on the wire now */
    uint64_t free_from_us;     /* end of the last interframe space */
    uint32_t bit_us;
    uint32_t waiting;                          /* bit n: node n has something to send */
    uint8_t listeners[TUMBLE_CAN_MAX_ID + 1U]; /* by identifier, bit n: node n receives it, by its acceptance filter */
    uint8_t sender;                            /* of `flying` */
    bool transmitting;
    sim_bus_tap_t tap; /* may be null */
    void *tap_context;
    sim_bus_fault_t faults[SIM_BUS_FAULTS];
    uint32_t faulty; /* bit n: fault n is in force */
    sim_bus_held_t held[SIM_BUS_HELD];
    uint32_t held_count;
    uint32_t held_overflow; /* frames lost because a fault held too many */
} sim_bus_t;

/* Quiet bus at 125, 250, 500 or 1000 kbit/s: bits of whole microseconds. */
void sim_bus_init(sim_bus_t *bus, sim_clock_t *clock, const sim_wire_t *wire, uint32_t bits_per_second);

/* Attach a node, to be woken as `actor`; its number is below SIM_BUS_NODES and not in use yet. */
void sim_bus_attach(sim_bus_t *bus, uint8_t node, sim_actor_t actor);

/* Attach a node that only sends: what it is to hear, the tap tells it. */
void sim_bus_attach_sender(sim_bus_t *bus, uint8_t node);

/* A node that looks for frames only every so often: at whole multiples of `loop_us`. */
void sim_bus_set_loop(sim_bus_t *bus, uint8_t node, uint32_t loop_us);

/* Acceptance filter of a node's controller: it does not hear identifiers from `from` to `to` (either),
 * besides those that it does not hear already. */
void sim_bus_set_deaf(sim_bus_t *bus, uint8_t node, uint16_t from, uint16_t to);

/* Take a node off the bus, which empties its queues, or put it back. */
void sim_bus_set_down(sim_bus_t *bus, uint8_t node, bool down);

/* As in port.h. A frame that is no classic frame is refused with TUMBLE_E_ARGUMENT. */
tumble_status_t sim_bus_send(sim_bus_t *bus, uint8_t node, const tumble_can_frame_t *frame);
tumble_status_t sim_bus_receive(sim_bus_t *bus, uint8_t node, tumble_can_frame_t *frame);

/* One node's end of the bus, which its port speaks for: that has the time of the bus and the node's frames, and nothing
 * else yet. The end must outlive the port. */
typedef struct {
    sim_bus_t *bus;
    uint8_t node;
} sim_bus_end_t;

tumble_port_t sim_bus_port(sim_bus_end_t *end);

/* The bus's alarm has gone off: end of a frame, or time for the next to begin. */
void sim_bus_on_alarm(sim_bus_t *bus);

/* The alarm of the frames that a fault holds back. */
void sim_bus_on_delay(sim_bus_t *bus);

/* Begin fault `number`, below SIM_BUS_FAULTS, in place of what it was before; end it, which lets go what it holds back.
 */
void sim_bus_begin_fault(sim_bus_t *bus, uint32_t number, const sim_bus_fault_t *fault);
void sim_bus_end_fault(sim_bus_t *bus, uint32_t number);

#endif
