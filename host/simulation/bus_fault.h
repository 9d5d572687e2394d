/* bus_fault.h - what can go wrong with frames on their way to the bus. */
#ifndef TUMBLE_SIMULATION_BUS_FAULT_H
#define TUMBLE_SIMULATION_BUS_FAULT_H

#include "tumble/port.h"
#include "simulation/random.h"

#include <stdbool.h>
#include <stdint.h>

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

#endif
